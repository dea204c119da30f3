#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/groups.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

// Trials that agree: what the axis needs, and what of it is set now, where that is
// known.
void TellNeeded(std::size_t axis,
                const std::map<double, std::vector<double>>& by_steps,
                Facts* facts) {
  std::vector<double> needed;
  for (const auto& [steps, factors] : by_steps) {
    for (const double factor : factors) needed.push_back(steps / factor);
  }
  const Average average = AverageOf(needed);
  const double sd = average.sd / std::sqrt(average.num);
  std::erase_if(facts->all, [&](const Fact& fact) {
    return fact.axis == kAxisNames[axis] &&
           (fact.id == "scale" || fact.id == "known_ratio" || fact.id == "offset");
  });
  std::erase_if(facts->cannot, [&](const std::string& says) {
    return says.starts_with(fmt::format("steps/mm of {}", "XYZ"[axis]));
  });
  facts->all.push_back(
      {.id = "scale",
       .axis = kAxisNames[axis],
       .word = "trials",
       .figures = {{"steps_per_mm", average.mean, sd}},
       .sentence = fmt::format("{} needs {} steps/mm: tried at {:g} to {:g}, its "
                               "travel goes as the steps/mm "
                               "that were set, and each trial says the same. Enter "
                               "that; what holds for one "
                               "length may hide a constant, so measure one more",
                               "XYZ"[axis],
                               WithSd(average.mean, sd, ""),
                               by_steps.begin()->first,
                               by_steps.rbegin()->first),
       .is_answer = true});
}

// Travel over what was told ought to go as the steps/mm that were set.
void AddTrials(const Rows& rows, const DataHeader& header, Facts* facts) {
  constexpr double kApart = 0.03;
  std::map<int, std::map<double, std::vector<double>>> factors;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    const auto settings = header.settings.find(row->settings);
    if (row->kind != RowKind::kPosition || axis < 0 ||
        settings == header.settings.end()) {
      continue;
    }
    const auto k = static_cast<std::size_t>(axis);
    const auto steps = settings->second.steps_per_mm.find(kAxisNames[k]);
    if (steps == settings->second.steps_per_mm.end() || !(row->cmd_mm[k] > 0)) continue;
    factors[axis][steps->second].push_back(1 + row->value_mm / row->cmd_mm[k]);
  }
  for (const auto& [axis, by_steps] : factors) {
    if (by_steps.size() < 2 || facts->Find("settings") != nullptr) continue;
    double least = HUGE_VAL, most = -HUGE_VAL;
    std::vector<std::string> trials;
    for (const auto& [steps, all] : by_steps) {
      const auto [low, high] = std::ranges::minmax(all);
      least = std::min(least, low / steps);
      most = std::max(most, high / steps);
      trials.push_back(low == high
                           ? fmt::format("{:.3f} at {:g}", low, steps)
                           : fmt::format("{:.3f} to {:.3f} at {:g}", low, high, steps));
    }
    // Travel that did not change with the steps/mm agrees with none of them.
    constexpr double kAgree = 0.3;
    const double range = by_steps.rbegin()->first / by_steps.begin()->first - 1;
    if (most < (1 + kApart) * least && most / least - 1 > kAgree * range) continue;
    if (most < (1 + kApart) * least) {
      TellNeeded(static_cast<std::size_t>(axis), by_steps, facts);
      continue;
    }
    facts->not_the_machine = {};  // A factor of contradicting trials is none.
    const auto k = static_cast<std::size_t>(axis);
    std::erase_if(facts->all, [&](const Fact& fact) {
      return fact.axis == kAxisNames[k] &&
             (fact.id == "scale" || fact.id == "known_ratio" || fact.id == "offset");
    });
    facts->all.push_back(
        {.id = "contradiction",
         .axis = kAxisNames[k],
         .word = "trials",
         .figures = {{"apart", most / least - 1}},
         .sentence = fmt::format(
             "The trials contradict each other: travel over what was told is {}{} "
             "steps/mm, and ought to go as the steps/mm. With the most steps the axis "
             "loses some (it stalls): slow it down and repeat two lengths at two "
             "settings before any steps/mm is reckoned",
             trials.front(),
             trials.size() > 1 ? ", " + trials.back() : ""),
         .is_answer = true});
    facts->not_determined.push_back(fmt::format("scale.{}", kAxisNames[k]));
    facts->cannot.push_back(
        fmt::format("steps/mm of {}: its trials contradict each other", "XYZ"[axis]));
  }
}

// A factor that the steps/mm of freshly written firmware make.
void AddDefaults(const Rows& rows, const DataHeader& header, Facts* facts) {
  constexpr double kFreshGrbl = 250, kFar = 0.12, kRound = 10, kAlike = 0.01;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto scale = std::ranges::find_if(facts->all, [&](const Fact& fact) {
      return fact.id == "scale" && fact.word != "trials" && fact.axis == kAxisNames[k];
    });
    const auto settings = header.settings.find(rows.front()->settings);
    if (scale == facts->all.end() || settings == header.settings.end()) continue;
    const auto& all = settings->second.steps_per_mm;
    const auto own = all.find(kAxisNames[k]);
    if (own == all.end() || own->second != kFreshGrbl) continue;
    const double factor = scale->figures.front().value;
    const double needed = own->second / factor;
    const double round = kRound * std::round(needed / kRound);
    const bool is_it = std::abs(factor - 1) > kFar && round > 0 &&
                       std::abs(needed / round - 1) < kAlike &&
                       facts->not_the_machine.reason.empty();
    if (!is_it) continue;
    facts->not_the_machine = {
        "settings",
        fmt::format(
            "{} moves {:.3g} times what is told, and its setting is {:g} "
            "steps/mm, which is what freshly written grbl has in every axis: this "
            "machine needs {:g}. Enter that, and look through the other settings: "
            "all of them came back to defaults",
            "XYZ"[k],
            factor,
            own -> second,
            round)};
  }
}

}  // namespace

void FactsOfTrials(const std::vector<const Row*>& rows,
                   const DataHeader& header,
                   Facts* facts) {
  AddTrials(rows, header, facts);
  AddDefaults(rows, header, facts);
}

}  // namespace caltwin
