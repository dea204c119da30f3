#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/diagnosis/nuisances.h"

namespace caltwin {

/// How far a placement may be off [mm].
inline constexpr double kPlacementSd_mm = 100;
/// @name How far a machine may be off before another word than calibration is needed
inline constexpr double kScaleSd_ppm = 1e4;
inline constexpr double kBacklashSd_mm = 0.2;

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

/// @name The bed's plane, one of every homing where its screws make it anew
void AddBedPlane(const Observed& o, NuisanceList* list);
void AddBedPlanes(const Observed& o, NuisanceList* list);
/// Where everything that is touched lies, how large it is within its certificate, and
/// the probe's hysteresis.
void AddWhatIsTouched(const Observed& o, NuisanceList* list);
/// A tracker reads in a frame of its own, which nobody has turned to the machine's: its
/// turns about x, y and z. Instruments of `kind: tracker` alone.
void AddFrameOfTracker(const Observed& o, NuisanceList* list);

}  // namespace caltwin
