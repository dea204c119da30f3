#include "calibration/diagnosis/plausible.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

constexpr std::size_t kFewestRows = 5;
constexpr std::size_t kLongestRepeat = 8;  // Rows that recur in order by chance: never.
constexpr double kHottest_c = 200;      // A frame, screw, bed or room beyond: Kelvin.
constexpr double kHottestStart_c = 50;  // A machine begins its session colder.

std::vector<const Row*> InOrder(const RowTable& table) {
  std::vector<const Row*> rows;
  for (const Row& row : table.rows) rows.push_back(&row);
  std::ranges::stable_sort(rows, {}, &Row::row);
  return rows;
}

bool DoubtFinite(const RowTable& table, std::vector<Doubt>* doubts) {
  Doubt doubt{.kind = "not_finite", .refuse = true};
  for (const Row& row : table.rows) {
    bool is_finite = std::isfinite(row.value_mm);
    for (const double number : row.cmd_mm) is_finite &= !std::isinf(number);
    if (!is_finite) doubt.rows.push_back(row.row);
  }
  if (doubt.rows.empty()) return false;
  doubt.message = fmt::format(
      "{} rows have a value or position that is no finite number", doubt.rows.size());
  doubt.hint = "leave them out of the file";
  doubts->push_back(std::move(doubt));
  return true;
}

/// Everything a row says but its number and place, as text.
std::string Contents(const Row& row) {
  Row plain = row;
  plain.row = 1;
  plain.extra.clear();
  return RowsText({.rows = {plain}});
}

// With a time or a repetition no two readings are alike in everything. Without,
// readings at one pose may well be, but not eight in a row in the same order.
void DoubtDuplicates(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts) {
  Doubt doubt{.kind = "duplicated_rows"};
  std::map<std::string, std::vector<std::size_t>> seen;
  std::vector<std::string> contents;
  for (const Row* row : rows) contents.push_back(Contents(*row));
  std::size_t run = 0;
  std::size_t run_from = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto& earlier = seen[contents[i]];
    const bool is_told_apart = Known(rows[i]->t_s) || rows[i]->rep > 0;
    if (!earlier.empty() && is_told_apart) doubt.rows.push_back(rows[i]->row);
    const bool goes_on = run > 0 && contents[run_from + run] == contents[i];
    if (!is_told_apart && goes_on) {
      ++run;
    } else {
      run = !is_told_apart && !earlier.empty() ? 1 : 0;
      run_from = earlier.empty() ? 0 : earlier.front();
    }
    const bool differs =
        run >= kLongestRepeat &&
        std::set<std::string>(contents.begin() + i + 1 - run, contents.begin() + i + 1)
                .size() > kLongestRepeat / 2;
    if (differs) {
      for (std::size_t j = i + 1 - run; j <= i; ++j) {
        doubt.rows.push_back(rows[j]->row);
      }
    }
    earlier.push_back(i);
  }
  std::ranges::sort(doubt.rows);
  doubt.rows.erase(std::unique(doubt.rows.begin(), doubt.rows.end()), doubt.rows.end());
  if (doubt.rows.empty()) return;
  doubt.message = fmt::format(
      "{} rows repeat an earlier row in everything, the first is row {}: counted twice "
      "they make the noise look smaller than it is",
      doubt.rows.size(),
      doubt.rows.front());
  doubt.hint = "remove the copies";
  doubts->push_back(std::move(doubt));
}

void DoubtTimes(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts) {
  Doubt doubt{.kind = "time_backwards"};
  std::map<std::string, const Row*> last;
  for (const Row* row : rows) {
    if (!Known(row->t_s)) continue;
    const Row*& before = last[row->campaign];
    if (before != nullptr && row->t_s < before->t_s) doubt.rows.push_back(row->row);
    before = row;
  }
  if (doubt.rows.empty()) return;
  doubt.message = fmt::format("time runs backwards in {} places, the first at row {}",
                              doubt.rows.size(),
                              doubt.rows.front());
  doubt.hint =
      "t_s counts on from the campaign's start: rows out of order, a clock set back or "
      "a time of day past midnight. Causes that follow time cannot be trusted";
  doubts->push_back(std::move(doubt));
}

struct SensorColumn {
  std::string_view name{};
  double Row::*member = nullptr;
};
constexpr std::array kSensors = {SensorColumn{"temp_screw_c", &Row::temp_screw_c},
                                 SensorColumn{"temp_frame_c", &Row::temp_frame_c},
                                 SensorColumn{"temp_bed_c", &Row::temp_bed_c},
                                 SensorColumn{"temp_chamber_c", &Row::temp_chamber_c},
                                 SensorColumn{"temp_ambient_c", &Row::temp_ambient_c}};

void DoubtTemperatures(const std::vector<const Row*>& rows,
                       std::vector<Doubt>* doubts) {
  for (const SensorColumn& sensor : kSensors) {
    double first_c = kUnknown;
    double least_c = INFINITY;
    for (const Row* row : rows) {
      const double temp_c = row->*sensor.member;
      if (!Known(temp_c)) continue;
      if (!Known(first_c)) first_c = temp_c;
      least_c = std::min(least_c, temp_c);
    }
    if (!Known(first_c)) continue;
    if (least_c > kHottest_c) {
      doubts->push_back(
          {.kind = "temperature_unit",
           .message = fmt::format("{} begins with {:.1f} and never falls below {:.1f}",
                                  sensor.name,
                                  first_c,
                                  least_c),
           .hint =
               fmt::format("in kelvin that would be {:.1f} degrees Celsius; columns "
                           "that end in _c are in degrees Celsius",
                           CelsiusFromKelvin(first_c)),
           .refuse = true});
    } else if (first_c > kHottestStart_c && sensor.name != "temp_bed_c" &&
               CelsiusFromFahrenheit(first_c) < kHottestStart_c) {
      doubts->push_back(
          {.kind = "temperature_unit",
           .message =
               fmt::format("{} begins with {:.1f} degrees", sensor.name, first_c),
           .hint = fmt::format("in Fahrenheit that would be {:.1f} degrees Celsius; if "
                               "it is, every coefficient per kelvin is wrong by 1.8",
                               CelsiusFromFahrenheit(first_c))});
    }
  }
}

// Two units in one column: a step up or down, from one row to the next, by what
// Fahrenheit makes of the same temperature. Beds and probes may be that quick.
void DoubtMixedTemperatures(const std::vector<const Row*>& rows,
                            std::vector<Doubt>* doubts) {
  constexpr double kAlike_k = 5, kLeastStep_k = 20;
  for (const SensorColumn& sensor : kSensors) {
    if (sensor.name == "temp_bed_c" || sensor.name == "temp_probe_c") continue;
    const Row* before = nullptr;
    for (const Row* row : rows) {
      const double now_c = row->*sensor.member;
      if (!Known(now_c)) continue;
      const double then_c = before == nullptr ? now_c : before->*sensor.member;
      const double high_c = std::max(now_c, then_c), low_c = std::min(now_c, then_c);
      before = row;
      if (high_c - low_c < kLeastStep_k ||
          std::abs(CelsiusFromFahrenheit(high_c) - low_c) > kAlike_k) {
        continue;
      }
      doubts->push_back(
          {.kind = "temperature_unit",
           .message =
               fmt::format("{} goes from {:.1f} to {:.1f} degrees from one row to "
                           "the next (row {})",
                           sensor.name,
                           then_c,
                           now_c,
                           row->row),
           .hint = "that is the same temperature in Celsius and in Fahrenheit; columns "
                   "that end in _c are in degrees Celsius",
           .refuse = true});
      break;
    }
  }
}

void DoubtConstant(const RowTable& table, std::vector<Doubt>* doubts) {
  const double first_mm = table.rows.front().value_mm;
  const bool is_constant = std::ranges::all_of(
      table.rows, [&](const Row& row) { return row.value_mm == first_mm; });
  if (!is_constant) return;
  doubts->push_back(
      {.kind = "constant",
       .message =
           fmt::format("value_mm is {} in all {} rows", first_mm, table.rows.size()),
       .hint = "no instrument reads that: a stuck gauge, or the wrong column",
       .refuse = true});
}

// One sense written 0, which says that the axis did not move: places read with and
// without a sense, never with the other, though no other axis moved either.
void DoubtSenseOfNought(const RowTable& table, int axis, std::vector<Doubt>* doubts) {
  constexpr int kFewestPlaces = 4;
  struct Senses {
    bool none = false;
    std::set<double> some{};
  };
  std::map<std::string, std::map<double, Senses>> campaigns;
  for (const Row& row : table.rows) {
    if (row.kind != RowKind::kPosition || !(std::abs(row.n[axis]) > 0.99)) continue;
    Senses& here = campaigns[row.campaign][row.cmd_mm[axis]];
    const bool is_any = std::ranges::any_of(
        row.dir, [](double sense) { return Known(sense) && sense != 0; });
    if (!is_any) here.none |= row.dir[axis] == 0;
    if (Known(row.dir[axis]) && row.dir[axis] != 0) here.some.insert(row.dir[axis]);
  }
  for (const auto& [name, places] : campaigns) {
    std::set<double> all;
    for (const auto& [at_mm, senses] : places) {
      all.insert(senses.some.begin(), senses.some.end());
    }
    const auto both = std::ranges::count_if(places, [](const auto& place) {
      return place.second.none && !place.second.some.empty();
    });
    if (all.size() != 1 || both < kFewestPlaces) continue;
    doubts->push_back(
        {.kind = "sense_of_nought",
         .message = fmt::format("campaign {}: {} places are read with dir_{} {:+g} and "
                                "with 0, none with {:+g}",
                                name,
                                both,
                                "xyz"[axis],
                                *all.begin(),
                                -*all.begin()),
         .hint = "senses are 1 and -1; 0 says that the axis did not move, and would "
                 "double the gap",
         .refuse = true});
  }
}

void DoubtSenses(const RowTable& table, std::vector<Doubt>* doubts) {
  for (const int axis : {0, 1, 2}) {
    std::set<double> senses;
    std::size_t num_along = 0;
    for (const Row& row : table.rows) {
      const bool is_along = row.kind == RowKind::kPosition && Known(row.n[axis]) &&
                            std::abs(row.n[axis]) > 0.99;
      if (!is_along) continue;
      ++num_along;
      if (Known(row.dir[axis]) && row.dir[axis] != 0) senses.insert(row.dir[axis]);
    }
    if (num_along == 0 || senses.size() > 1) continue;
    const char letter = "xyz"[axis];
    if (senses.empty()) {
      doubts->push_back(
          {.kind = "direction_unknown",
           .message = fmt::format("no row along {} says from which side it was "
                                  "approached",
                                  letter),
           .hint =
               fmt::format("without dir_{} backlash hides in the scatter", letter)});
    } else {
      doubts->push_back(
          {.kind = "one_direction",
           .message =
               fmt::format("every row along {} was approached in the sense {:+g}",
                           letter,
                           *senses.begin()),
           .hint = "backlash cannot be told from an offset; measure in both senses"});
    }
  }
}

}  // namespace

void DoubtRows(const RowTable& table, std::vector<Doubt>* doubts) {
  const std::vector<const Row*> rows = InOrder(table);
  DoubtConstant(table, doubts);
  DoubtDuplicates(rows, doubts);
  DoubtTimes(rows, doubts);
  DoubtTemperatures(rows, doubts);
  DoubtMixedTemperatures(rows, doubts);
  DoubtSenses(table, doubts);
  for (const int axis : {0, 1, 2}) DoubtSenseOfNought(table, axis, doubts);
  DoubtMoves(rows, doubts);
}

std::vector<Doubt> Doubts(const RowTable& table,
                          const DataHeader& header,
                          const Machine* machine,
                          const KnownOfRows& known) {
  std::vector<Doubt> doubts;
  if (DoubtFinite(table, &doubts)) return doubts;
  if (table.rows.size() < kFewestRows) {
    doubts.push_back(
        {.kind = "too_few",
         .message =
             fmt::format("{} rows: no cause can be told from fewer than {}, only "
                         "what the numbers say by themselves",
                         table.rows.size(),
                         kFewestRows),
         .hint = std::string(
             DiagnosedAs(machine != nullptr ? *machine : Machine{}).FewestRowsHint())});
    return doubts;
  }
  const bool may_have_screws = machine == nullptr || machine->kind->bed_is_on_screws();
  const RowTable alike = may_have_screws ? WithoutLoneScrews(table) : table;
  DoubtRows(table, &doubts);
  if (!known.has_unit) DoubtBlocks(InOrder(alike), &doubts);
  DoubtSizes(table, alike, header, machine, known, &doubts);
  if (machine != nullptr) {
    DoubtTravel(table, *machine, &doubts);
    DoubtReachInInches(table, *machine, &doubts);
    DoubtDrives(header, *machine, &doubts);
  }
  std::ranges::stable_sort(doubts, std::greater(), &Doubt::refuse);
  return doubts;
}

}  // namespace caltwin
