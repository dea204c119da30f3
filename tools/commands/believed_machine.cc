#include "tools/commands/believed_machine.h"

#include <algorithm>
#include <utility>

#include "sim/base/input_error.h"
#include "sim/base/yaml.h"
#include "sim/machine/machine_kind.h"
#include "tools/commands/assumed_machine.h"

namespace caltwin {

namespace fs = std::filesystem;

Believed BelievedMachine(const std::string& data_file,
                         const std::string& machine,
                         Data* data,
                         const std::string& asked_by) {
  const fs::path header_file = fs::path(data_file).replace_extension(".yaml");
  Believed believed;
  if (!machine.empty()) {
    believed.file = FindMachine(machine, "", {.file = asked_by});
  } else if (!data->header.machine.empty()) {
    believed.file = FindMachine(data->header.machine,
                                header_file.parent_path(),
                                {.file = header_file.string()});
  }
  if (believed.file.empty() && !data->machine_yaml.empty()) {
    Faults faults;
    YamlMap map = ReadYamlText(data->machine_yaml, data_file, &faults);
    believed.machine = ReadMachine(&map);
    map.NoMoreKeys();
    faults.ThrowIfAny();
    believed.machine.file.clear();
    data->notes.emplace_back("the machine is that of the settings in the same file");
    NoteMissingMotors(believed.machine, data);
    return believed;
  }
  if (believed.file.empty()) {
    const bool has_motors = std::ranges::any_of(data->table.rows, [](const Row& row) {
      return Known(row.motor_mm[0]) && Known(row.motor_mm[1]) && Known(row.motor_mm[2]);
    });
    if (has_motors) {
      throw InputError(
          {.file = data_file},
          "the rows have motor_ columns: the machine is not cartesian, and "
          "none is named",
          "say --machine FILE, or `machine:` in the header beside them");
    }
    believed.machine = AssumedMachine(data->table, &data->notes);
  } else {
    MachineFile read = ReadMachineWithTip(believed.file);
    believed.machine = std::move(read.machine);
    believed.effects = std::move(read.effects);
    believed.baseline = std::move(read.baseline);
    data->notes.insert(data->notes.end(), read.notes.begin(), read.notes.end());
  }
  NoteMissingMotors(believed.machine, data);
  believed.machine = WithTransmission(std::move(believed.machine), data->header);
  if (believed.file.empty()) {
    believed.machine = WithStepsAsSet(std::move(believed.machine), data->header);
  } else if (believed.machine.kind->axes_are_drives()) {
    believed.machine = WithSettingsOf(std::move(believed.machine), data->header);
  }
  return believed;
}

}  // namespace caltwin
