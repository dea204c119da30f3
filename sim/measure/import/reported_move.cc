#include "sim/measure/import/reported_move.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr std::string_view kSixAxes = "xyzabc";

// The number behind a letter of a block whose words stand together: "n0g1a2.00000f360".
std::optional<double> Behind(const std::string& block, char letter) {
  const std::size_t at = block.find(letter);
  if (at == std::string::npos) return std::nullopt;
  const std::size_t end = block.find_first_not_of("+-.0123456789", at + 1);
  return NumberOf(block.substr(at + 1, end - at - 1));
}

// The block that a line sends: from "g0" or "g1" to a blank; empty: none.
std::string BlockIn(const std::string& lower) {
  for (std::size_t at = lower.find('g'); at != std::string::npos;
       at = lower.find('g', at + 1)) {
    const bool is_move = at + 2 < lower.size() &&
                         (lower[at + 1] == '0' || lower[at + 1] == '1') &&
                         kSixAxes.find(lower[at + 2]) != std::string_view::npos;
    if (is_move) return lower.substr(at + 2, lower.find_first_of(" \t[", at) - at - 2);
  }
  return "";
}

}  // namespace

void ReportedMove::Take(const ConsoleLine& line) {
  is_in_inches_ |= line.lower.find("g20") != std::string::npos;
  const std::string block = BlockIn(line.lower);
  if (!block.empty()) {
    told_.clear();
    for (const char axis : kSixAxes) {
      if (const auto told = Behind(block, axis)) told_[axis] = *told;
    }
    return;
  }
  if (line.lower.find("\"sr\":{") == std::string::npos) return;
  for (const char axis : kSixAxes) {
    const auto at = NumberAfter(line.lower, fmt::format("\"pos{}\":", axis));
    if (at) reported_[axis] = *at;
  }
  if (line.lower.find("\"stat\":3") == std::string::npos) return;
  for (const auto& [axis, told] : told_) {
    const auto at = reported_.find(axis);
    if (at != reported_.end()) ended_[axis] = {told, at->second};
  }
  told_.clear();
}

void ReportedMove::Tell(Imported* imported) const {
  constexpr double kAlike = 0.02;
  if (is_in_inches_) return;
  std::string right;
  for (const auto& [axis, move] : ended_) {
    if (std::abs(move.told - move.reported) < 1e-3 * std::abs(move.told)) {
      right +=
          fmt::format("{}{}", right.empty() ? "" : ", ", static_cast<char>(axis - 32));
    }
  }
  // All alike, and more than one: the unit that the whole program is told in.
  if (right.empty() && ended_.size() > 1) return;
  for (const auto& [axis, move] : ended_) {
    const double factor = move.reported / move.told;
    const double inches = factor > 1 ? factor : 1 / factor;
    if (!std::isfinite(inches) || std::abs(MmFromInch(1 / inches) - 1) > kAlike)
      continue;
    imported->notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "firmware",
         .sentence = fmt::format(
             "{} was told {:g} and the controller itself says that it ended at {:g}: "
             "1 / {:.4g}, inches taken for millimetres on this axis{}. It is the "
             "controller's own count, so no motor, belt or steps per unit is to blame; "
             "{}update the firmware, or set the unit that the axis is told in",
             static_cast<char>(axis - 32),
             move.told,
             move.reported,
             inches,
             right.empty() ? "" : fmt::format(" ({} went where it was told)", right),
             axis >= 'a' && axis <= 'c' ? "a rotary axis has neither unit; " : ""),
         .fact = "known_ratio",
         .axis = std::string(1, axis),
         .word = "inches",
         .figures = {{"factor", factor}}});
  }
}

}  // namespace caltwin
