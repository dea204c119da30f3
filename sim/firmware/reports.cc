#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/firmware/model_path.h"
#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

/// @name Many times faster than the library's: M114 is asked after every touch.
void AppendWhole(long long value, std::string* line) {
  std::array<char, 24> digits{};
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), value);
  line->append(digits.data(), written.ptr);
}

/// With three decimals.
void AppendThousandths(double value, std::string* line) {
  constexpr long long kScale = 1000;
  const long long whole = std::llround(value * static_cast<double>(kScale));
  const long long size = std::abs(whole);
  if (whole < 0) *line += '-';
  AppendWhole(size / kScale, line);
  const long long part = size % kScale;
  *line += '.';
  *line += static_cast<char>('0' + part / 100);
  *line += static_cast<char>('0' + part / 10 % 10);
  *line += static_cast<char>('0' + part % 10);
}

}  // namespace

Reply Firmware::Parts::ReportPosition(const Words&) {
  motion.Finish();
  const Vec3<double> user_mm = motion.commanded_mm() - offset_mm();
  const Vec3<double>& counts = motion.counts();
  const Vec3<double> counted_mm = motion.counted_mm();
  constexpr std::size_t kUsualLength = 160;
  Reply reply{.lines = {std::string()}};
  std::string& line = reply.lines.front();
  line.reserve(kUsualLength);
  for (const Axis axis : kAxes) {
    line += CapitalLetter(axis);
    line += ':';
    const bool is_driver = bed.is_split && axis == Axis::kZ;
    AppendThousandths(
        is_driver ? bed.split_mm[0] - offset_mm()[2] : user_mm[Index(axis)], &line);
    line += ' ';
  }
  if (bed.is_split) {
    line += fmt::format("U:{:.3f} V:{:.3f} ", bed.split_mm[1], bed.split_mm[2]);
  }
  line += "E:0.000 Count";
  for (const double count : counts) {
    line += ' ';
    AppendWhole(std::llround(count), &line);
  }
  line += " Machine";
  for (const Axis axis : kAxes) {
    line += ' ';
    AppendThousandths(counted_mm[Index(axis)], &line);
  }
  return reply;
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
  const GcodeWord* const word = command.Find('S');
  const bool is_said = word != nullptr && (word->kind == GcodeWord::Kind::kQuoted ||
                                           word->kind == GcodeWord::Kind::kExpression);
  return {.lines = {is_said ? words.Text('S').value_or("") : command.rest}};
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
