#include "scenarios/kinds/delta_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/setting_names.h"
#include "scenarios/position_error.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;    // Of the heights as they were.
constexpr double kNoise_mm = 0.01;    // Of heights, from one calibration to the next.
constexpr double kSaidNothing = 0.9;  // Of the prior's standard deviation.

const DeltaKnob& KnobOf(const DeltaEstimate& estimate) {
  return kDeltaKnobs[static_cast<std::size_t>(estimate.knob)];
}

void AddSettings(const DeltaTruth& trial, RunResult* result) {
  const DeltaModel<double>& drawn = DeltaOf(trial.machine).model;
  for (const char* name : kDeltaSettingNames) {
    ParameterResult row{.name = name,
                        .unit = std::string(name).starts_with("tower") ? "deg" : "mm",
                        .identifiable = true,
                        .is_setting = true};
    row.injected = *DeltaSettingNamed(trial.built.build.model, drawn, name);
    row.recovered = DeltaSettingNamed(trial.after, drawn, name);
    row.error = *row.recovered - row.injected;
    const auto told = std::ranges::find(trial.settings_told, name, &Estimate::name);
    if (told != trial.settings_told.end()) SetUncertainty(*told, &row);
    result->parameters.push_back(row);
  }
}

// Of what is a setting too: what was found; the settings made of it stand among the
// steps.
void TakeEstimate(const DeltaTruth& trial,
                  const DeltaEstimate& estimate,
                  ParameterResult* row) {
  row->recovered = DeltaSettingNamed(
      trial.fit->build.model, DeltaOf(trial.machine).model, row->name);
  row->error = *row->recovered - row->injected;
  row->sd = estimate.sd;
  row->budget = estimate.budget;
  row->identifiable = estimate.sd_over_prior < kSaidNothing;
  row->is_setting = false;
}

ParameterResult RowOf(const DeltaTruth& trial, const DeltaEstimate& estimate) {
  const DeltaKnob& knob = KnobOf(estimate);
  ParameterResult row{.name = std::string(knob.name),
                      .unit = std::string(knob.unit),
                      .identifiable = estimate.sd_over_prior < kSaidNothing};
  row.injected = KnobValue(estimate.knob,
                           trial.built.build,
                           trial.built.bed,
                           DeltaOf(trial.machine).Build());
  if (row.identifiable) {
    row.recovered = estimate.value;
    row.sd = estimate.sd;
    row.budget = estimate.budget;
    row.error = estimate.value - row.injected;
  }
  return row;
}

// What the joint estimate knows and no setting holds, and how sure it is of the rest.
void AddEstimates(const DeltaTruth& trial, RunResult* result) {
  if (!trial.fit) return;
  const bool has_tower_radii =
      std::ranges::any_of(trial.fit->estimates, [](const DeltaEstimate& estimate) {
        return KnobOf(estimate).name.starts_with("tower_radius");
      });
  for (const DeltaEstimate& estimate : trial.fit->estimates) {
    const std::string name(KnobOf(estimate).name);
    if (estimate.sd_over_prior >= kSaidNothing) {
      result->observability.push_back(
          {.statement = name + " is not told by these readings: its uncertainty is "
                               "still that of its prior",
           .blind_direction = {{name, 1}}});
    }
    const auto known =
        std::ranges::find(result->parameters, name, &ParameterResult::name);
    if (known == result->parameters.end()) {
      result->parameters.push_back(RowOf(trial, estimate));
    } else if (name != "delta_radius" || !has_tower_radii) {
      // With a radius for each tower the common one is tower c's, no setting.
      TakeEstimate(trial, estimate, &*known);
    }
  }
}

// By how much the nozzle's height over the disc has moved since the first step, rms.
double Drift_mm(const DeltaTruth& trial) {
  return DeltaHeightChange_mm(trial.built.build,
                              trial.after_first,
                              trial.after,
                              DeltaOf(trial.machine).print_radius_mm);
}

}  // namespace

double DeltaPositionP95_mm(const DeltaTruth& trial,
                           const DeltaModel<double>& settings,
                           const DeltaMesh& mesh) {
  constexpr int kPoses = 1000;
  const double radius_mm = DeltaOf(trial.machine).print_radius_mm;
  Rng rng(1, 0, "position_error_mm"), senses(1, 0, "position_error_mm.senses");
  std::vector<Vec3<double>> errors_mm;
  for (int i = 0; i < kPoses; ++i) {
    const double out_mm = radius_mm * std::sqrt(rng.Uniform());
    const double angle = 2 * std::numbers::pi * rng.Uniform();
    const Vec3<double> sent(
        out_mm * std::cos(angle), out_mm * std::sin(angle), radius_mm * rng.Uniform());
    const Vec3<double> lifted = sent + mesh.Lift_mm(sent[0], sent[1]) * Unit(Axis::kZ);
    Vec3<double> motor_dir = Vec3<double>::Zero();
    for (double& dir : motor_dir) dir = senses.Uniform() < 0.5 ? -1 : 1;
    const auto nozzle_mm = NozzleOfDelta(
        trial.machine, trial.built, DeltaMotors_mm(settings, lifted), motor_dir);
    if (!nozzle_mm) return std::numeric_limits<double>::infinity();
    errors_mm.push_back(*nozzle_mm - sent);
  }
  return P95AboutMean_mm(errors_mm);
}

double DeltaReversal_mm(const DeltaTruth& trial) {
  constexpr int kPoints = 200;
  double most_mm = 0;
  for (const Eigen::Vector2d& at :
       DiscPoints(kPoints, DeltaOf(trial.machine).print_radius_mm)) {
    const Vec3<double> motors_mm =
        DeltaMotors_mm<double>(trial.after, Vec3<double>(at[0], at[1], 0));
    const auto after = [&](double sense) {
      return NozzleOfDelta(trial.machine,
                           trial.built,
                           motors_mm,
                           Vec3<double>(sense * Vec3<double>::Ones()));
    };
    const auto down_mm = after(1), up_mm = after(-1);
    if (!down_mm || !up_mm) return std::numeric_limits<double>::infinity();
    most_mm = std::max(most_mm, std::abs((*down_mm)[2] - (*up_mm)[2]));
  }
  return most_mm;
}

namespace {

// Heights as touches find them: every carriage has come down.
DeltaAccuracy AccuracyOn(const DeltaTruth& trial,
                         const DeltaBed<double>& bed,
                         const DeltaModel<double>& settings,
                         const DeltaMesh& mesh) {
  const auto nozzle_of = [&](const Vec3<double>& motors_mm) {
    return NozzleOfDelta(
        trial.machine, trial.built, motors_mm, Vec3<double>(Vec3<double>::Ones()));
  };
  return DeltaAccuracyOf(
      nozzle_of, bed, settings, DeltaOf(trial.machine).print_radius_mm, mesh);
}

// What a firmware that knows the bed's tilt would make of the same settings.
void AddTiltCommanded(const DeltaTruth& trial, RunResult* result) {
  if (trial.tilt_x == 0 && trial.tilt_y == 0) return;
  DeltaBed<double> bed = trial.built.bed;
  bed.slope_x -= trial.tilt_x;
  bed.slope_y -= trial.tilt_y;
  const DeltaAccuracy with = AccuracyOn(trial, bed, trial.after, trial.mesh);
  result->messages.push_back(fmt::format(
      "with the tilt commanded beside these settings, as RepRapFirmware's M666 A and B "
      "do, the nozzle would stand {:.1f} um rms off the bed",
      UmFromMm(with.z_rms_mm)));
}

}  // namespace

DeltaAccuracy AccuracyBefore(const DeltaTruth& trial) {
  return AccuracyOn(trial, trial.built.bed, trial.before, {});
}

DeltaAccuracy AccuracyAfter(const DeltaTruth& trial) {
  return AccuracyOn(trial, trial.built.bed, trial.after, trial.mesh);
}

void AddDeltaTable(const DeltaTruth& trial, RunResult* result) {
  AddSettings(trial, result);
  AddEstimates(trial, result);
  result->correlations = trial.correlations;
}

TrueEnd EndOfDelta(const DeltaTruth& trial, RunResult* result) {
  const DeltaAccuracy before = AccuracyBefore(trial), after = AccuracyAfter(trial);
  if (!std::isfinite(after.z_rms_mm)) {
    result->messages.push_back(
        "with these settings the machine does not reach all of its bed");
  }
  result->messages.push_back(fmt::format(
      "the nozzle stands {:.1f} um rms off the bed ({:.1f} at most), {:.1f} before; "
      "prints are {:+.2f} um/mm wrong{}",
      UmFromMm(after.z_rms_mm),
      UmFromMm(after.z_most_mm),
      UmFromMm(before.z_rms_mm),
      UmFromMm(after.xy_scale),
      trial.said_mm ? fmt::format("; the procedure says {:.4f} mm", *trial.said_mm)
                    : ""));
  AddTiltCommanded(trial, result);
  if (HasPlay(trial.built.play_mm)) {
    result->messages.push_back(fmt::format(
        "carriages have play: up to {:.1f} um lie between the nozzle's height after a "
        "move down, as every touch comes, and after a move up",
        UmFromMm(DeltaReversal_mm(trial))));
  }
  return {.figure =
              TrueFigure{.before = before.z_rms_mm,
                         .after = after.z_rms_mm,
                         .noise = kNoise_mm,
                         .is_met = after.z_rms_mm <
                                   std::max(kRecovered * before.z_rms_mm, kNoise_mm)}};
}

double FigureOfDelta(const DeltaTruth& trial,
                     const std::string& name,
                     const RunResult& result) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (name == "height_error_mm.rms") return AccuracyAfter(trial).z_rms_mm;
  if (name == "height_reversal_mm") return DeltaReversal_mm(trial);
  if (name == "height_error_mm.most") return AccuracyAfter(trial).z_most_mm;
  if (name == "height_drift_mm") return Drift_mm(trial);
  if (name == "said_mm") return trial.said_mm.value_or(kNone);
  if (name == "xy_scale_um_per_mm") return UmFromMm(AccuracyAfter(trial).xy_scale);
  return result.position_error_after_p95_mm;
}

}  // namespace caltwin
