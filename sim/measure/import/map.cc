#include "sim/measure/import/map.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "sim/measure/columns.h"

namespace caltwin {
namespace {

std::string Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

/// The parts between commas; a comma inside brackets does not part.
std::vector<std::string> PartsOf(const std::string& word) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : word) {
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == ',' && depth <= 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::vector<std::string> Targets() {
  std::vector<std::string> names = {"kind", "value_mm", "actual_mm", "unit"};
  for (const Column& column : AllColumns()) names.emplace_back(column.name);
  return names;
}

Assignment Parsed(const std::string& part, Faults* faults) {
  const Place place{.file = fmt::format("--map '{}'", part)};
  const std::size_t equals = part.find('=');
  if (equals == std::string::npos || equals == 0) {
    faults->Add(
        place,
        "this assigns nothing",
        "target=source[unit], as value_mm=dev[um] or cmd_x_mm=1; or a constant, "
        "campaign:=laser");
    return {};
  }
  Assignment assignment;
  assignment.is_constant = part[equals - 1] == ':';
  assignment.target = Trimmed(
      std::string_view(part).substr(0, equals - (assignment.is_constant ? 1 : 0)));
  assignment.source = Trimmed(std::string_view(part).substr(equals + 1));
  if (assignment.target == "unit") assignment.is_constant = true;
  if (!assignment.is_constant) {
    const std::size_t bracket = assignment.source.rfind('[');
    if (assignment.source.ends_with(']') && bracket != std::string::npos) {
      assignment.unit =
          assignment.source.substr(bracket + 1, assignment.source.size() - bracket - 2);
      assignment.source = Trimmed(assignment.source.substr(0, bracket));
    }
    if (assignment.source.starts_with('-')) {
      assignment.is_reversed = true;
      assignment.source.erase(0, 1);
    }
  }
  if (assignment.source.empty()) {
    faults->Add(place, "nothing stands after the =", "a heading, or a number from 1");
  }
  const std::vector<std::string> targets = Targets();
  if (std::ranges::find(targets, assignment.target) == targets.end()) {
    const std::string nearest = NearestWord(assignment.target, targets);
    faults->Add(place,
                fmt::format("'{}' is no column of measured rows", assignment.target),
                (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                    "docs/data-format.md lists them");
  }
  return assignment;
}

}  // namespace

std::vector<Assignment> ParseMap(const std::vector<std::string>& words) {
  Faults faults;
  std::set<std::string> seen;
  std::vector<Assignment> assignments;
  for (const std::string& word : words) {
    for (const std::string& part : PartsOf(word)) {
      if (Trimmed(part).empty()) continue;
      Assignment assignment = Parsed(Trimmed(part), &faults);
      if (!assignment.target.empty() && !seen.insert(assignment.target).second) {
        faults.Add({.file = fmt::format("--map '{}'", Trimmed(part))},
                   fmt::format("{} is assigned twice", assignment.target));
      }
      assignments.push_back(std::move(assignment));
    }
  }
  faults.ThrowIfAny();
  return assignments;
}

}  // namespace caltwin
