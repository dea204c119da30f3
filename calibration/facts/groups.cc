#include "calibration/facts/groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/estimate/f_test.h"
#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

void Open(const std::string& what, const std::string& sentence, Facts* facts) {
  facts->not_determined.push_back(what);
  facts->cannot.push_back(sentence);
}

// Two sides, each time together: how far one is from the other.
void AddSideBySide(const Rows& rows, Facts* facts) {
  constexpr double kSure = 4, kLeast_mm = 0.02;
  if (rows.size() < 2 || !std::ranges::all_of(rows, [](const Row* row) {
        return row->flag == kSidesFlag;
      })) {
    return;
  }
  const Average apart = AverageOf(rows);
  const double sd_mm = apart.sd / std::sqrt(apart.num);
  const bool is_constant =
      std::abs(apart.mean) > kLeast_mm && std::abs(apart.mean) > kSure * sd_mm;
  if (!is_constant) return;
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "offset" || fact.id == "scale" || fact.id == "known_ratio";
  });
  facts->all.push_back(
      {.id = "offset",
       .axis =
           kAxisNames[static_cast<std::size_t>(std::max(0, AxisAlong(*rows.front())))],
       .word = "sides",
       .figures = {{"change_um", UmFromMm(apart.mean), UmFromMm(sd_mm)},
                   {"scatter_um", UmFromMm(apart.sd)}},
       .sigmas = std::abs(apart.mean) / std::max(sd_mm, 1e-9),
       .sentence = fmt::format(
           "The two sides differ by {}, the same each of {} times (they scatter by {} "
           "um): a stop or switch of one side sits off by that, and what sets them "
           "repeats. Move that switch, or enter the difference; what angle it makes "
           "depends on how far the sides are apart",
           WithSd(apart.mean, sd_mm, "mm"),
           rows.size(),
           TwoDigits(UmFromMm(apart.sd))),
       .is_answer = true});
}

/// Two gauges at one place.
struct Pair {
  double x_mm = 0, y_mm = 0, apart_mm = 0;
};

std::vector<Pair> PairsOf(const Rows& rows) {
  std::map<std::pair<long, long>, Rows> places;
  std::string first;
  for (const Row* row : rows) {
    const bool is_height =
        row->kind == RowKind::kTouch && Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]);
    if (!is_height || !row->campaign.starts_with("gauge_")) return {};
    if (first.empty()) first = row->campaign;
    places[{std::lround(100 * row->cmd_mm[0]), std::lround(100 * row->cmd_mm[1])}]
        .push_back(row);
  }
  std::vector<Pair> pairs;
  for (const auto& [place, both] : places) {
    if (both.size() != 2 || both[0]->campaign == both[1]->campaign) continue;
    const Row* one = both[0]->campaign == first ? both[0] : both[1];
    const Row* other = one == both[0] ? both[1] : both[0];
    pairs.push_back({one->cmd_mm[0], one->cmd_mm[1], other->value_mm - one->value_mm});
  }
  return pairs;
}

// A probe and another gauge that do not tell the same tilt.
void AddGauges(const Rows& rows, Facts* facts) {
  constexpr std::size_t kFewest = 4;
  constexpr double kLeast_mm = 0.05, kClear = 6;
  const std::vector<Pair> pairs = PairsOf(rows);
  if (pairs.size() < kFewest) return;
  const auto num = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd columns(num, 3);
  Eigen::VectorXd apart_mm(num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    columns.row(i) << 1, pair.x_mm, pair.y_mm;
    apart_mm[i] = pair.apart_mm;
  }
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  if (EigenvaluesOf(normal)[0] < 1e-9 * normal.trace()) return;
  const Eigen::VectorXd plane = Cholesky(normal).Solve(columns.transpose() * apart_mm);
  const Eigen::VectorXd left_mm = apart_mm - columns * plane;
  for (const int axis : {0, 1}) {
    const auto [low, high] =
        std::ranges::minmax(pairs, {}, axis == 0 ? &Pair::x_mm : &Pair::y_mm);
    const double span_mm = axis == 0 ? high.x_mm - low.x_mm : high.y_mm - low.y_mm;
    const double tilt_mm = plane[1 + axis] * span_mm;
    if (std::abs(tilt_mm) < kLeast_mm ||
        std::abs(tilt_mm) < kClear * left_mm.cwiseAbs().maxCoeff()) {
      continue;
    }
    facts->all.push_back(
        {.id = "contradiction",
         .axis = kAxisNames[static_cast<std::size_t>(axis)],
         .word = "gauges",
         .figures = {{"apart_um", UmFromMm(tilt_mm)},
                     {"slope_mrad", MradFromRad(plane[1 + axis])}},
         .sentence = fmt::format(
             "The two gauges contradict each other by {:.3g} mm over {:.4g} mm of {}: "
             "one of them does not read the bed. Either the probe triggers differently "
             "along {} (the head tilts, its cable pulls), or the gauge does not travel "
             "as the nozzle does. These rows cannot say which",
             std::abs(tilt_mm),
             span_mm,
             "XY"[axis],
             "XY"[axis]),
         .is_answer = true});
    Open(
        "cause", "which of the two gauges is right: they contradict each other", facts);
    facts->next.insert(facts->next.begin(),
                       {"feeler_gauge",
                        "put the nozzle itself on a feeler gauge at all four corners: "
                        "that is what the "
                        "print sees, and it tells which of the two gauges is right"});
  }
}

// Whether each reading stands behind a homing of its own.
bool AreHomings(const Rows& rows) {
  std::map<std::string, std::set<std::string>> homes;
  std::map<std::string, std::size_t> num;
  for (const Row* row : rows) {
    homes[row->campaign].insert(row->home);
    ++num[row->campaign];
  }
  return std::ranges::all_of(homes, [&](const auto& of) {
    return of.second.size() > 1 && of.second.size() == num.at(of.first);
  });
}

// How far each of several switches scatters from homing to homing.
void TellHomings(const std::map<std::string, std::vector<const Row*>>& ways,
                 Facts* facts) {
  constexpr double kFewest = 4;
  double least_mm = HUGE_VAL;
  for (const auto& [way, of_way] : ways) {
    const Average average = AverageOf(of_way);
    if (average.num > kFewest) least_mm = std::min(least_mm, average.sd);
  }
  for (const auto& [way, of_way] : ways) {
    const Average average = AverageOf(of_way);
    const double dof = average.num - 1;
    if (dof < kFewest) continue;
    const bool is_worse = average.sd > 2 * least_mm;
    facts->all.push_back(
        {.id = "homing_scatter",
         .word = way,
         .figures = {{"sd_um",
                      UmFromMm(average.sd),
                      UmFromMm(average.sd) / std::sqrt(2 * dof)}},
         .sentence = fmt::format(
             "'{}' scatters by {} um from homing to homing (standard deviation, {:.0f} "
             "degrees of freedom){}",
             way,
             TwoDigits(UmFromMm(average.sd)),
             dof,
             is_worse ? ", and another, homed as fast, by less than half of it: its "
                        "switch, the place where it is pressed, or its wire is worse. "
                        "Change it before any calibration rests on it"
                      : ""),
         .is_answer = is_worse});
  }
}

// One place measured in two ways: in place, and after something.
void AddScatters(const Rows& rows, const Repeats& repeats, Facts* facts) {
  constexpr double kMostChance = 1e-3, kFewest = 4;
  if (CellsOf(rows, kAnyHome | kAnyCampaign).size() != 1) return;
  std::map<std::string, Rows> ways;
  for (const Row* row : rows) {
    if (!repeats.outliers.contains(row->row)) ways[row->campaign].push_back(row);
  }
  if (ways.size() < 2) return;
  const auto sd_of = [](const auto& way) {
    return AverageOf(way.second).sd;
  };
  const auto quiet = std::ranges::min_element(ways, {}, sd_of);
  const auto loud = std::ranges::max_element(ways, {}, sd_of);
  const double quiet_dof = static_cast<double>(quiet->second.size()) - 1;
  const double loud_dof = static_cast<double>(loud->second.size()) - 1;
  const double quiet_mm = sd_of(*quiet), loud_mm = sd_of(*loud);
  if (quiet_dof < kFewest || loud_dof < kFewest || !(quiet_mm > 0)) return;
  const double chance =
      FUpperTail(std::pow(loud_mm / quiet_mm, 2), loud_dof, quiet_dof);
  if (chance > kMostChance) return;
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "repeatability" || fact.id == "outliers" || fact.id == "jump" ||
           fact.id == "homing_scatter";
  });
  if (AreHomings(rows)) {
    TellHomings(ways, facts);
    return;
  }
  const auto add = [&](const std::string& way, double sd_mm, double dof) {
    facts->all.push_back(
        {.id = "repeatability",
         .word = way,
         .figures = {{"sd_um", UmFromMm(sd_mm), UmFromMm(sd_mm) / std::sqrt(2 * dof)}},
         .sentence = fmt::format("'{}' scatters by {} um (standard deviation, {:.0f} "
                                 "degrees of freedom)",
                                 way,
                                 TwoDigits(UmFromMm(sd_mm)),
                                 dof),
         .is_answer = true});
  };
  add(quiet->first, quiet_mm, quiet_dof);
  add(loud->first, loud_mm, loud_dof);
  facts->all.back().sentence += fmt::format(
      ", {:.0f} times as much at the same place: the instrument and its axis are good, "
      "and what was done between the readings of '{}' makes the rest",
      loud_mm / quiet_mm,
      loud->first);
  Open("cause",
       fmt::format("what makes the scatter of '{}': no row says from where it came",
                   loud->first),
       facts);
  facts->next.insert(facts->next.begin(),
                     {"probe",
                      "come upon the place ten times from each side of X, then of Y: "
                      "that tells which axis makes the scatter"});
}

// Two programs on one machine, right by the one and off by a factor by the other.
void AddPrograms(const Rows& rows, Facts* facts) {
  constexpr double kRight = 0.01, kOff = 0.04, kEven = 0.015;
  std::map<int, std::map<std::string, std::vector<double>>> factors;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    if (row->kind != RowKind::kPosition || axis < 0 || row->campaign == "moves") return;
    const double told_mm = row->cmd_mm[static_cast<std::size_t>(axis)];
    if (!(told_mm > 0)) return;
    factors[axis][row->campaign].push_back(1 + row->value_mm / told_mm);
  }
  const std::string* wrong = nullptr;
  double factor = 1;
  for (const auto& [axis, groups] : factors) {
    if (groups.size() != 2) return;
    bool has_right = false, has_wrong = false;
    for (const auto& [group, all] : groups) {
      const double middle = Median(all);
      const auto [low, high] = std::ranges::minmax(all);
      if (high - low > 2 * kEven * middle) return;
      has_right |= std::abs(middle - 1) < kRight;
      if (std::abs(middle - 1) < kOff) continue;
      has_wrong = true;
      wrong = &group;
      factor = middle;
    }
    if (!has_right || !has_wrong) return;
  }
  if (wrong == nullptr) return;
  facts->not_the_machine = {
      "settings",
      fmt::format("All sizes of '{}' are {:.3g} times what they should be and those of "
                  "the other are right, on the same machine: '{}' reckons with another "
                  "machine (its steps/mm, its scale). Enter the machine there; nothing "
                  "is to be changed at the drives",
                  *wrong,
                  factor,
                  *wrong)};
}

}  // namespace

void FactsOfGroups(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   const DataHeader& header,
                   Facts* facts) {
  AddSideBySide(rows, facts);
  AddGauges(rows, facts);
  AddScatters(rows, repeats, facts);
  FactsOfTrials(rows, header, facts);
  AddPrograms(rows, facts);
}

}  // namespace caltwin
