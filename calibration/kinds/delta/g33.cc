#include "calibration/kinds/delta/g33.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "calibration/kinds/delta/g33_trace.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kNotYet_mm = 999;
constexpr double kNoDeviation_mm = 1e-5;
constexpr int kMostIterations = 31;
constexpr std::array kTowerAngle_deg = {210.0, 330.0, 90.0};

double Radius_mm(const G33Options& options) {
  const double off_mm = options.probe_offset_mm.head<2>().norm();
  const double kept_mm = options.probes_at_offset ? std::max(off_mm, options.margin_mm)
                                                  : off_mm + options.margin_mm;
  return options.printable_radius_mm - kept_mm - std::max(options.reduce_mm, 0.0);
}

void RequirePlausible(const G33Options& options) {
  constexpr int kMostForced = 30;
  if (options.precision_mm < 0) {
    throw InputError({}, "?(C)alibration precision implausible (>=0).");
  }
  if (options.force_iterations < 0 || options.force_iterations > kMostForced) {
    throw InputError({}, "?(F)orce iteration implausible (0-30).");
  }
  if (!(Radius_mm(options) > 0)) {
    throw InputError({}, "?(R)educed to no radius at all.");
  }
}

// A letter alone, or with anything but 0, says yes.
bool Says(const GcodeCommand& command, char letter) {
  return command.Find(letter) != nullptr && command.Number(letter).value_or(1) != 0;
}

// Rms of the used points from the zero plane, in whole micrometres and never nought.
double Deviation_mm(const G33Heights& heights_mm, const G33Options& options) {
  if (options.points < 2) return kNoDeviation_mm;
  const bool is_full = options.points >= 3;
  double square = heights_mm[0] * heights_mm[0];
  int num = 1;
  for (int i = is_full || options.tower_angles ? 1 : 2; i < 7; i += is_full ? 1 : 2) {
    square += heights_mm[i] * heights_mm[i];
    ++num;
  }
  return MmFromUm(std::round(UmFromMm(std::sqrt(square / num)))) + kNoDeviation_mm;
}

// One G33 while it runs.
class Calibration {
 public:
  Calibration(const DeltaProbe& probe,
              const DeltaModel<double>& start,
              const G33Options& options)
      : probe_(probe),
        options_(options),
        radius_mm_(Radius_mm(options)),
        grid_(G33Grid(
            options.points, radius_mm_, !options.tower_angles, options.variant)),
        trace_(options),
        best_(start) {
    outcome_.settings = start;
    if (options.verbosity == G33Verbosity::kDryRun) deviation_mm_ = 0;
    least_mm_ = deviation_mm_;
  }

  DeltaOutcome Run() {
    trace_.Begin(radius_mm_, outcome_.settings);
    do {
      if (!Iterate()) {
        trace_.ProbeFailed();
        break;
      }
    } while (GoesOn());
    outcome_.said_mm = least_mm_;
    outcome_.messages = trace_.lines();
    return outcome_;
  }

 private:
  bool is_forced() const { return iterations_ <= options_.force_iterations; }

  bool GoesOn() const {
    return ((deviation_mm_ < limit_mm_ && iterations_ < kMostIterations) ||
            is_forced()) &&
           deviation_mm_ > options_.precision_mm;
  }

  bool Iterate() {
    limit_mm_ =
        earlier_mm_ == kNotYet_mm ? deviation_mm_ : (deviation_mm_ + earlier_mm_) / 2;
    ++iterations_;
    earlier_mm_ = deviation_mm_;
    const auto heights_mm = Touch();
    if (!heights_mm) return false;
    deviation_mm_ = Deviation_mm(*heights_mm, options_);
    if ((deviation_mm_ < limit_mm_ || is_forced()) &&
        deviation_mm_ > options_.precision_mm) {
      if (deviation_mm_ < least_mm_) {
        best_ = outcome_.settings;
      }
      if (options_.points < 2) limit_mm_ = 0;  // Once is all it can do.
      Correct(*heights_mm);
    } else if (deviation_mm_ >= limit_mm_) {
      outcome_.settings = best_;
    }
    if (options_.verbosity != G33Verbosity::kDryRun) NormaliseAngles();
    least_mm_ = std::min(least_mm_, deviation_mm_);
    Report(*heights_mm);
    return true;
  }

  std::optional<G33Heights> Touch() {
    G33Heights heights_mm = G33Heights::Zero();
    for (const G33Touch& touch : grid_) {
      Eigen::Vector2d nozzle_mm(touch.x_mm, touch.y_mm);
      if (options_.probes_at_offset) nozzle_mm -= options_.probe_offset_mm.head<2>();
      const auto motors_mm = probe_(outcome_.settings, nozzle_mm[0], nozzle_mm[1]);
      if (!motors_mm) return std::nullopt;
      ++outcome_.touches;
      const double nozzle_z_mm = DeltaNozzle_mm(outcome_.settings, *motors_mm)[2];
      heights_mm += touch.share * (nozzle_z_mm + options_.probe_offset_mm[2]);
    }
    const int per_sixth = G33PerSixth(options_.points, options_.variant);
    if (options_.variant == G33Variant::kCorrected && per_sixth > 1) {
      return G33Restored(heights_mm, per_sixth);
    }
    return heights_mm;
  }

  void Correct(const G33Heights& heights_mm) {
    constexpr int kThreeCircles = 8;
    constexpr double kMiddleCircle = 0.9;
    const double at_mm =
        radius_mm_ * (options_.points >= kThreeCircles ? kMiddleCircle : 1);
    const G33Matrix matrix = G33Correction(
        {.points = options_.points, .tower_angles = options_.tower_angles},
        G33Tuned(outcome_.settings, at_mm),
        options_.variant);
    const G33Heights by = matrix * heights_mm;
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      const auto tower = static_cast<Eigen::Index>(i);
      outcome_.settings.endstop_mm[i] -= by[tower];
      outcome_.settings.radius_mm[i] += by[3];
      outcome_.settings.angle_rad[i] += RadFromDeg(by[4 + tower]);
    }
  }

  void NormaliseAngles() {
    if (options_.points < 3 || !options_.tower_angles) return;
    std::array<double, 3>& angle_rad = outcome_.settings.angle_rad;
    const double common_rad =
        (std::accumulate(angle_rad.begin(), angle_rad.end(), 0.0) -
         RadFromDeg(
             std::accumulate(kTowerAngle_deg.begin(), kTowerAngle_deg.end(), 0.0))) /
        3;
    for (double& angle : angle_rad) angle -= common_rad;
  }

  void Report(const G33Heights& heights_mm) {
    trace_.Results(heights_mm);
    if (options_.verbosity == G33Verbosity::kDryRun) {
      outcome_.is_done = true;
      trace_.EndDryRun(deviation_mm_);
      return;
    }
    const bool is_worse = deviation_mm_ >= limit_mm_;
    const bool is_fine = deviation_mm_ <= options_.precision_mm;
    if ((is_worse && iterations_ > options_.force_iterations) || is_fine) {
      outcome_.is_done = true;
      trace_.End(is_worse && options_.points >= 2, least_mm_, outcome_.settings);
    } else {
      trace_.Iteration(iterations_, deviation_mm_, outcome_.settings);
    }
  }

  const DeltaProbe& probe_;
  const G33Options& options_;
  double radius_mm_;
  std::vector<G33Touch> grid_;
  G33Trace trace_;
  DeltaModel<double> best_;
  DeltaOutcome outcome_{};
  int iterations_ = 0;
  double deviation_mm_ = kNotYet_mm;
  double earlier_mm_ = kNotYet_mm;
  double least_mm_ = kNotYet_mm;
  double limit_mm_ = 0;  // Below it the next deviation must stay.
};

}  // namespace

G33Options ReadG33(const GcodeCommand& command, G33Options options) {
  constexpr double kMostVerbose = 3;
  constexpr double kMostPoints = 10;
  const double points = command.Number('P').value_or(options.points);
  if (!(points >= 0 && points <= kMostPoints)) {
    throw InputError({}, "?(P)oints implausible (0-10).");
  }
  const double verbosity =
      command.Number('V').value_or(static_cast<int>(options.verbosity));
  if (!(verbosity >= 0 && verbosity <= kMostVerbose)) {
    throw InputError({}, "?(V)erbose level implausible (0-3).");
  }
  // Whatever does not fit an int is refused as implausible, too.
  constexpr double kFar = 1000;
  const double forced = command.Number('F').value_or(options.force_iterations);
  options.points = static_cast<int>(points);
  options.verbosity = static_cast<G33Verbosity>(static_cast<int>(verbosity));
  options.force_iterations = static_cast<int>(std::clamp(forced, -kFar, kFar));
  options.precision_mm = command.Number('C').value_or(options.precision_mm);
  options.reduce_mm = command.Number('R').value_or(options.reduce_mm);
  if (command.Find('T') != nullptr) options.tower_angles = false;
  options.engages_probe = options.engages_probe || Says(command, 'E');
  options.probes_at_offset = options.probes_at_offset || Says(command, 'O');
  RequirePlausible(options);
  return options;
}

DeltaOutcome CalibrateG33(const DeltaProbe& probe,
                          const DeltaModel<double>& start,
                          const G33Options& options) {
  RequirePlausible(options);
  return Calibration(probe, start, options).Run();
}

}  // namespace caltwin
