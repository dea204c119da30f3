#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/firmware/model_path.h"
#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

/// A number with three decimals, several times faster than the library's: M114 is asked
/// after every touch.
std::string Thousandths(double value) {
  constexpr long long kScale = 1000;
  const long long whole = std::llround(value * static_cast<double>(kScale));
  const long long size = std::abs(whole);
  return fmt::format("{}{}.{:03}", whole < 0 ? "-" : "", size / kScale, size % kScale);
}

}  // namespace

Reply Firmware::Parts::ReportPosition(const Words&) {
  motion.Finish();
  const Vec3<double> user_mm = motion.commanded_mm() - offset_mm();
  const Vec3<double>& counts = motion.counts();
  std::string line;
  for (const Axis axis : kAxes) {
    line +=
        fmt::format("{}:{} ", CapitalLetter(axis), Thousandths(user_mm[Index(axis)]));
  }
  line += "E:0.000 Count";
  for (const double count : counts) line += fmt::format(" {}", std::llround(count));
  line += " Machine";
  for (const Axis axis : kAxes) {
    const double steps_per_mm = settings.steps_per_mm[Index(axis)];
    line += fmt::format(" {}", Thousandths(counts[Index(axis)] / steps_per_mm));
  }
  return {.lines = {line}};
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
