// Whether campaigns that read along the same axis have their positions in one unit.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "calibration/diagnosis/readings_on_a_line.h"
#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::size_t kFewestPlaces = 12;
constexpr double kInside = 0.9;  // Of the rows, where the other campaign measured.
constexpr double kWide = 0.5;    // Of the other's range, that they then span.
// Standard deviations by which readings miss the other campaign's: a ratio of 1 to 4
// comes by chance in one of a hundred thousand where twelve places tell.
constexpr double kFits = 0.25;

struct PositionUnit {
  double mm = 1;
  std::string_view name{};
};
constexpr std::array kUnits = {PositionUnit{MmFromInch(1.0), "inches"},
                               PositionUnit{10, "centimetres"},
                               PositionUnit{1000, "metres"}};

/// Readings of one campaign along an axis, by sense, in the order of their places.
using BySense = std::map<int, std::vector<PlacedReading>>;

double Deviation(const std::vector<double>& numbers) {
  double mean = 0, squares = 0;
  for (const double number : numbers) mean += number;
  mean /= static_cast<double>(numbers.size());
  for (const double number : numbers) squares += std::pow(number - mean, 2);
  return std::sqrt(squares / static_cast<double>(numbers.size() - 1));
}

struct Range {
  double low_mm = HUGE_VAL, high_mm = -HUGE_VAL;
  double length_mm() const { return high_mm - low_mm; }
};

Range RangeOf(const BySense& campaign) {
  Range range;
  for (const auto& [sense, readings] : campaign) {
    range.low_mm = std::min(range.low_mm, readings.front().at_mm);
    range.high_mm = std::max(range.high_mm, readings.back().at_mm);
  }
  return range;
}

/// By how much readings miss another campaign's, offsets aside.
struct Missed {
  double as_written_mm = 0, in_unit_mm = 0;
};

// None where they would not measure the same places in that unit.
std::optional<Missed> MissedIn(const PositionUnit& unit,
                               const BySense& readings_of,
                               const BySense& reference) {
  std::vector<double> as_written_mm, in_unit_mm;
  std::size_t num = 0;
  for (const auto& [sense, readings] : readings_of) {
    num += readings.size();
    const auto other = reference.find(sense);
    if (other == reference.end()) continue;
    for (const PlacedReading& reading : readings) {
      const auto there = ReadingBetween(other->second, unit.mm * reading.at_mm);
      if (!there) continue;
      in_unit_mm.push_back(reading.value_mm - *there);
      as_written_mm.push_back(reading.value_mm -
                              ReadingNearest(other->second, reading.at_mm));
    }
  }
  const bool is_wide = unit.mm * RangeOf(readings_of).length_mm() >
                       kWide * RangeOf(reference).length_mm();
  if (in_unit_mm.size() < kFewestPlaces || !is_wide ||
      static_cast<double>(in_unit_mm.size()) < kInside * static_cast<double>(num)) {
    return std::nullopt;
  }
  return Missed{Deviation(as_written_mm), Deviation(in_unit_mm)};
}

BySense AveragedByPlace(const std::vector<const Row*>& rows, int axis) {
  std::map<std::pair<int, double>, std::vector<double>> values;
  for (const Row* row : rows) {
    const auto sense = static_cast<int>(SenseAlongNormal(*row));
    values[{sense, row->cmd_mm[axis]}].push_back(row->value_mm * row->n[axis]);
  }
  BySense readings;
  for (auto& [place, repeats] : values) {
    readings[place.first].push_back({place.second, Median(repeats)});
  }
  return readings;
}

void DoubtPair(const std::pair<std::string, BySense>& campaign,
               const std::pair<std::string, BySense>& reference,
               char letter,
               std::vector<Doubt>* doubts) {
  for (const PositionUnit& unit : kUnits) {
    const auto missed = MissedIn(unit, campaign.second, reference.second);
    if (!missed || missed->in_unit_mm > kFits * missed->as_written_mm) continue;
    doubts->push_back(
        {.kind = "position_unit",
         .message = fmt::format(
             "campaign {}: its readings follow those of {} (to {:.3g} um) where "
             "cmd_{}_mm is multiplied by {:g}, as it is written they do not ({:.3g} "
             "um)",
             campaign.first,
             reference.first,
             UmFromMm(missed->in_unit_mm),
             letter,
             unit.mm,
             UmFromMm(missed->as_written_mm)),
         .hint =
             fmt::format("cmd_{}_mm is in mm, and here it is in {}", letter, unit.name),
         .refuse = true});
    return;
  }
}

}  // namespace

// Gauged along an axis under the same settings.
void DoubtPositionUnits(const RowTable& table, std::vector<Doubt>* doubts) {
  constexpr double kAlong = 0.999;
  using Key = std::tuple<int, std::string>;
  std::map<Key, std::map<std::string, std::vector<const Row*>>> groups;
  for (const Row& row : table.rows) {
    if (row.kind == RowKind::kTouch) continue;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(std::abs(row.n[axis]) > kAlong) || !Known(row.cmd_mm[axis])) continue;
      groups[{axis, row.settings}][row.campaign].push_back(&row);
    }
  }
  for (const auto& [key, rows] : groups) {
    const int axis = std::get<0>(key);
    std::vector<std::pair<std::string, BySense>> campaigns;
    for (const auto& [name, of] : rows) {
      campaigns.emplace_back(name, AveragedByPlace(of, axis));
    }
    for (const auto& one : campaigns) {
      for (const auto& other : campaigns) {
        if (one.first == other.first) continue;
        DoubtPair(one, other, "xyz"[axis], doubts);
      }
    }
  }
}

}  // namespace caltwin
