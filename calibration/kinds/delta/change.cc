#include "calibration/kinds/delta/change.h"

#include <array>
#include <cmath>

#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {
namespace {

constexpr double kSigmas = 2;

using Slopes = std::array<double, kNumDeltaKnobs>;

// Of what has these slopes by all knobs, as the fit leaves it open.
double Variance(const DeltaJointFit& fit, const Slopes& all) {
  Eigen::VectorXd slopes(static_cast<Eigen::Index>(fit.estimates.size()));
  for (Eigen::Index k = 0; k < slopes.size(); ++k) {
    const int knob = fit.estimates[static_cast<std::size_t>(k)].knob;
    slopes[k] = all[static_cast<std::size_t>(knob)];
  }
  return slopes.dot(fit.covariance * slopes);
}

// Sums over the places of a disc.
struct Sums {
  double height2 = 0, height_var = 0, place2 = 0, place_var = 0;
  double outward = 0, radius2 = 0;  ///< Moved outward times radius, radius squared.
  Slopes outward_slopes{};
  int num = 0;

  void Add(const DeltaJointFit& fit,
           const Vec3<double>& sent,
           const ClosedDelta& before,
           const ClosedDelta& after) {
    Slopes by_height{}, unused{};
    const double rise_mm =
        after.HeightOver(fit.bed, &by_height) - before.HeightOver(fit.bed, &unused);
    const Vec3<double> by_mm = after.pose().nozzle_mm - before.pose().nozzle_mm;
    height2 += rise_mm * rise_mm;
    height_var += Variance(fit, by_height);
    place2 += by_mm.head<2>().squaredNorm();
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      const Slopes along = after.Slopes(Unit(axis));
      place_var += Variance(fit, along);
      for (std::size_t k = 0; k < along.size(); ++k) {
        outward_slopes[k] += sent[Index(axis)] * along[k];
      }
    }
    outward += by_mm.head<2>().dot(sent.head<2>());
    radius2 += sent.head<2>().squaredNorm();
    ++num;
  }
};

}  // namespace

bool DeltaMoved::IsTold() const {
  return std::abs(by) > kSigmas * sd;
}

bool DeltaChange::IsTold() const {
  return height_mm.IsTold() || place_mm.IsTold() || scale.IsTold();
}

DeltaChange ChangeOf(const DeltaJointFit& fit,
                     const DeltaModel<double>& from,
                     const DeltaModel<double>& to,
                     double radius_mm) {
  constexpr int kSteps = 3;
  Sums sums;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j > kSteps * kSteps) continue;
      const Vec3<double> sent(radius_mm * i / kSteps, radius_mm * j / kSteps, 0);
      const auto before = ClosedDelta::At(fit.build, DeltaMotors_mm(from, sent));
      const auto after = ClosedDelta::At(fit.build, DeltaMotors_mm(to, sent));
      if (before && after) sums.Add(fit, sent, *before, *after);
    }
  }
  if (sums.num == 0) return {};
  const auto rms = [&](double square) {
    return std::sqrt(square / sums.num);
  };
  return {.height_mm = {rms(sums.height2), rms(sums.height_var)},
          .place_mm = {rms(sums.place2), rms(sums.place_var)},
          .scale = {sums.outward / sums.radius2,
                    std::sqrt(Variance(fit, sums.outward_slopes)) / sums.radius2}};
}

}  // namespace caltwin
