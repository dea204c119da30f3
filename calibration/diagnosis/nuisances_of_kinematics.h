#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/diagnosis/nuisances.h"

namespace caltwin {

/// How far a placement may be off [mm].
inline constexpr double kPlacementSd_mm = 100;

/// The lines of a baseline while they are gathered.
class NuisanceList {
 public:
  using OfRow = std::function<double(Eigen::Index)>;
  explicit NuisanceList(const Observed& observed) : observed_(observed) {}

  /// Adds a column unless it is nothing. `of_row`: what one unit adds to a row [mm].
  void Add(const std::string& name,
           const std::string& unit,
           double prior_sd,
           const OfRow& of_row,
           double offset = 0,
           bool reported = true);

  std::vector<Nuisance> Take() { return std::move(nuisances_); }

 private:
  const Observed& observed_;
  std::vector<Nuisance> nuisances_{};
};

/// Homing sessions in the order of their first row (of touches alone).
std::vector<std::string> HomesOf(const Observed& o, bool only_touches);

/// What the machine's own kinematics may be off by: scale, backlash and pre-travel of a
/// gantry's axes; a delta's knobs; scale and backlash that all screws of a bed share;
/// the heights of a printer's station and where each homing left its zero.
void AddKinematics(const Observed& o, NuisanceList* builder);

}  // namespace caltwin
