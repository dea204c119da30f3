#include <fmt/format.h>

#include "sim/firmware/model_path.h"
#include "sim/firmware/parts.h"

namespace caltwin {

Reply Firmware::Parts::ReportPosition(const Words&) {
  motion.Finish();
  const Vec3<double> user_mm = motion.commanded_mm() - offset_mm();
  const Vec3<double>& counts = motion.counts();
  Vec3<double> machine_mm;
  for (const Axis axis : kAxes) {
    machine_mm[Index(axis)] = counts[Index(axis)] / settings.steps_per_mm[Index(axis)];
  }
  return {.lines = {fmt::format(
              "X:{:.3f} Y:{:.3f} Z:{:.3f} E:0.000 Count {:.0f} {:.0f} {:.0f} "
              "Machine {:.3f} {:.3f} {:.3f}",
              user_mm[0],
              user_mm[1],
              user_mm[2],
              counts[0],
              counts[1],
              counts[2],
              machine_mm[0],
              machine_mm[1],
              machine_mm[2])}};
}

Reply Firmware::Parts::ReportFirmware(const Words&) {
  return {.lines = {fmt::format(
              "FIRMWARE_NAME: RepRapFirmware dialect of caltwin FIRMWARE_VERSION: {} "
              "ELECTRONICS: simulated {} PROTOCOL_VERSION:1.0 EXTRUDER_COUNT:0",
              options.m400_ignores_backlash ? "3.6.0" : "3.6.1",
              machine.name)}};
}

Reply Firmware::Parts::ReportTemperatures(const Words&) {
  return {.lines = {"T:0.0 /0.0 B:0.0 /0.0"}};  // No heaters, but clients ask.
}

Reply Firmware::Parts::Say(const GcodeCommand& command, const Words& words) {
  const auto text = words.Text('S');
  return {.lines = {text ? *text : command.rest}};
}

Reply Firmware::Parts::ReportObjectModel(const Words& words) {
  motion.Finish();
  const std::string key = words.Text('K').value_or("");
  const std::string flags = words.Text('F').value_or("");
  nlohmann::ordered_json answer;
  answer["key"] = key;
  answer["flags"] = flags;
  answer["result"] = FindInModel(ObjectModel(), key);
  return {.lines = {answer.dump()}};
}

}  // namespace caltwin
