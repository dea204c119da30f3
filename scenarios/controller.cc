#include "scenarios/controller.h"

#include <string>
#include <vector>

#include "scenarios/gcode_step.h"
#include "scenarios/klipper/klipper_trial.h"
#include "scenarios/linuxcnc/config_files.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> Blocks(const YamlValue& value) {
  std::vector<std::string> lines;
  for (const YamlValue& line : value.List()) lines.push_back(line.Text());
  if (value.is_list() && lines.empty()) {
    value.Fail("says nothing", "as in `mdi: [G0 X100, G38.2 Z-5 F60]`");
  }
  return lines;
}

// Lines for Klipper's own host, and among them what a person does there.
std::vector<std::string> LinesAndActs(const YamlValue& value,
                                      const Scenario& scenario) {
  std::vector<std::string> lines;
  for (const YamlValue& line : value.List()) {
    if (!line.is_map()) {
      lines.push_back(line.Text());
      if (lines.back().starts_with(kPersonDoes)) {
        line.Fail("is no line for the host", "`- person: ...` without quotes");
      }
      continue;
    }
    YamlMap by = line.Map();
    const auto act = by.Required("person");
    by.NoMoreKeys();
    const auto known = scenario.kind->PersonsActs();
    if (act) lines.push_back(kPersonDoes + act->Word(known));
  }
  if (value.is_list() && lines.empty()) {
    value.Fail("says nothing", "as in `gcode: [G28, DELTA_CALIBRATE, SAVE_CONFIG]`");
  }
  return lines;
}

// The same in place of `calibrate`.
void ReadUnderKlipper(YamlMap keys, const fs::path& folder, Scenario* scenario) {
  scenario->klipper.emplace();
  if (const auto config = keys.Optional("config")) {
    const fs::path file = folder / config->Text();
    std::error_code error;
    if (fs::is_regular_file(file, error) && fs::is_empty(file, error)) {
      config->Fail("is an empty file", "leave it away, and one is made of the machine");
    } else if (fs::is_regular_file(file, error)) {
      scenario->klipper->config = ReadTextFile(file, kLargestFile_bytes);
      scenario->klipper->beside = fs::absolute(file).parent_path();
      scenario->klipper->name = file.string();
    } else {
      config->Fail(
          "there is no file " + file.string(),
          "a printer.cfg, relative to this file; without it one is made of the "
          "machine");
    }
  }
  scenario->klipper->add = keys.TextOr("add", "");
  std::vector<std::string> lines;
  if (const auto gcode = keys.Required("gcode")) {
    lines = LinesAndActs(*gcode, *scenario);
  }
  keys.NoMoreKeys();
  scenario->calibrate = {{.name = "klipper", .procedure = GcodeStep(lines)}};
}

// Whether that file is there; else the fault is added.
bool IsThere(const YamlValue& name, const fs::path& file) {
  std::error_code error;
  if (fs::is_regular_file(file, error)) return true;
  name.Fail("names a file that is not there: " + file.string(),
            "its place is relative to this file");
  return false;
}

// What LinuxCNC's configuration is, or is made different in.
void ReadConfiguration(YamlMap* keys, const fs::path& folder, UnderLinuxCnc* asked) {
  if (const auto ini = keys->Optional("ini")) {
    const fs::path file = folder / ini->Text();
    if (IsThere(*ini, file)) asked->options.files = FilesBesideIni(file);
  }
  if (const auto files = keys->Optional("files")) {
    for (const YamlValue& name : files->List()) {
      const fs::path file = folder / name.Text();
      if (!IsThere(name, file)) continue;
      asked->more_files.emplace_back(file.filename().string(),
                                     ReadTextFile(file, kLargestFile_bytes));
    }
  }
  const auto set = keys->Optional("set");
  if (!set) return;
  for (const auto& [name, value] : set->Map().Entries()) {
    const auto point = name.find('.');
    if (point == std::string::npos || point == 0 || point + 1 == name.size()) {
      value.Fail("is set at no section and key", "as in `JOINT_0.BACKLASH: 0.05`");
      continue;
    }
    asked->options.set.push_back(name + "=" + value.Text());
  }
}

// Blocks for LinuxCNC, and a program after them, in place of `calibrate`.
void ReadUnderLinuxCnc(YamlMap keys, const fs::path& folder, Scenario* scenario) {
  UnderLinuxCnc& asked = scenario->linuxcnc.emplace();
  ReadConfiguration(&keys, folder, &asked);
  asked.is_homed_first = keys.FlagOr("home", true);
  if (const auto probe = keys.Optional("probe")) {
    YamlMap input = probe->Map();
    constexpr double kMs_per_s = 1000, kLongest_ms = 1000;
    asked.options.probe = {
        .is_latched = input.FlagOr("latch", false),
        .bounce_s = input.NumberOr("bounce_ms", 0, {0, kLongest_ms}) / kMs_per_s};
    input.NoMoreKeys();
  }
  std::vector<std::string> lines;
  const auto mdi = keys.Optional("mdi");
  if (mdi) lines = Blocks(*mdi);
  if (const auto program = keys.Optional("program")) {
    const fs::path file = folder / program->Text();
    if (IsThere(*program, file)) {
      asked.program_name = file.filename().string();
      asked.program = ReadTextFile(file, kLargestData_bytes);
      const LinuxCncFiles beside = SubroutinesBeside(file);
      asked.more_files.insert(asked.more_files.end(), beside.begin(), beside.end());
    }
    lines.emplace_back(kRunProgram);
  } else if (!mdi) {
    keys.Required("mdi");
  }
  keys.NoMoreKeys();
  scenario->calibrate = {{.name = "linuxcnc", .procedure = GcodeStep(lines)}};
}

}  // namespace

void ReadController(const YamlValue& value,
                    const fs::path& folder,
                    Scenario* scenario) {
  YamlMap keys = value.Map();
  const auto klipper = keys.Optional("klipper"), linuxcnc = keys.Optional("linuxcnc");
  keys.NoMoreKeys();
  if (klipper.has_value() == linuxcnc.has_value()) {
    value.Fail("names one real controller", "klipper or linuxcnc");
    return;
  }
  if (klipper) {
    ReadUnderKlipper(klipper->Map(), folder, scenario);
    if (scenario->kind->CanBeUnderKlipper()) return;
    klipper->Fail("such a machine cannot yet be driven by Klipper's host in a scenario",
                  "single motors speak another language");
    return;
  }
  ReadUnderLinuxCnc(linuxcnc->Map(), folder, scenario);
  if (scenario->kind->CanBeUnderLinuxCnc()) return;
  linuxcnc->Fail("such a machine cannot yet be driven by LinuxCNC",
                 "deltas can, and machines with one motor each for X, Y and Z");
}

}  // namespace caltwin
