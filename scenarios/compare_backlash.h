#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/contender.h"

namespace caltwin {

/// One way to measure the lost motion of X. A rival more is one line more in
/// BacklashRivals().
struct BacklashRival {
  std::string_view name{};
  std::string_view about{};
  std::string_view step{};  ///< Of `calibrate:` in a scenario, as YAML.
};
std::span<const BacklashRival> BacklashRivals();

/// The scenario in which a rival stands: a router whose gap, scale, pre-travel, switch
/// hysteresis and backlash compensation in force are drawn anew for each machine.
std::string BacklashScenarioText(const BacklashRival& rival);

/// How one rival did.
struct BacklashStanding {
  std::string_view name{};
  double touches = 0;  ///< Mean over machines.
  int failures = 0;    ///< No gap was told.
  /// How its runs ended, and how often ("collision": 200).
  std::map<std::string, int> outcomes{};
  Spread error_um{};   ///< Size of told minus built, of the machines that were told.
  double bias_um = 0;  ///< Mean of told minus built.
  int intervals = 0, covered = 0;  ///< 95 % intervals stated, and those with the truth.
  double machine_s = 0;            ///< Median of the machine's time.
};

struct BacklashComparison {
  int machines = 0;
  std::uint64_t seed = 0;
  bool is_interrupted = false;
  std::vector<BacklashStanding> engines{};
};

/// Runs every rival on every machine over G-code, in closed form.
BacklashComparison CompareBacklash(int machines,
                                   std::uint64_t seed,
                                   const std::function<void(int)>& progress);

/// By the error of the gap as told.
std::vector<Contender> ContendersOf(const BacklashComparison& comparison);
std::string BacklashComparisonText(const BacklashComparison& comparison);
nlohmann::ordered_json BacklashComparisonJson(const BacklashComparison& comparison);

}  // namespace caltwin
