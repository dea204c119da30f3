#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace caltwin {

/// One number that was measured elsewhere on a public engine's own code, and what the
/// engine here gives.
struct MeasuredFigure {
  std::string name{};             ///< "z rms um", "touches" ...
  std::optional<double> there{};  ///< nullopt: of caltwin's own engine, so of none.
  double last_digit = 0;          ///< One unit of it.
  double here = 0;
  bool is_met = false;  ///< Within the last digit, with noise within a tenth.
};

/// One engine at one task.
struct MeasuredTask {
  std::string engine{};
  std::string task{};
  int draws = 1;  ///< Rms and means over so many; 1: without noise.
  std::vector<MeasuredFigure> figures{};
  std::string note{};  ///< What is known of a figure that is not met.
};

/// Every task on the machine of sim/machine/kinds/delta/measured.h, those with noise
/// `draws` times. `progress` hears the name of each. Ends early where
/// InterruptRequested().
std::vector<MeasuredTask> CompareMeasuredDelta(
    int draws,
    std::uint64_t seed,
    const std::function<void(const std::string&)>& progress);

std::string MeasuredDeltaText(const std::vector<MeasuredTask>& tasks);
nlohmann::ordered_json MeasuredDeltaJson(const std::vector<MeasuredTask>& tasks,
                                         std::uint64_t seed);

}  // namespace caltwin
