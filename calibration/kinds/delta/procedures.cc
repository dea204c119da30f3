#include "calibration/kinds/delta/procedures.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "calibration/kinds/delta/change.h"
#include "calibration/kinds/delta/engine_uncertainty.h"
#include "calibration/kinds/delta/foretold_mesh.h"
#include "calibration/kinds/delta/klipper_descent.h"
#include "calibration/kinds/delta/klipper_fit.h"
#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "calibration/kinds/delta/setting_names.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr int kMeshNodes = 7;      // As the firmware on the wire has them.
constexpr double kBest_mm = 1e-3;  // Less than this no touch is believed to scatter.

/// What a procedure left behind.
struct Performed {
  DeltaOutcome outcome{};
  std::optional<DeltaJointFit> fit{};
};

// A touch scatters, and each tower counts it in whole steps of its own:
//
//   sigma^2 = probe^2 + sum (dz / d(motor_i) step_i)^2 / 12
//
// The slopes add up to 1, so rounding weighs a third where all towers pull alike and
// the whole of it under one tower.
double TouchSigma_mm(double probe_sigma_mm,
                     const Machine& machine,
                     const DeltaModel<double>& settings,
                     const Vec3<double>& motors_mm) {
  constexpr double kMove_mm = 1e-3;
  const DeltaBuild<double> build{.model = settings};
  const auto steps_per_mm = TowerStepsPerMm(machine);
  const auto here = DeltaPoseOf(build, motors_mm);
  double variance_mm2 = std::pow(probe_sigma_mm, 2);
  for (int i = 0; i < 3; ++i) {
    const Vec3<double> moved_mm = motors_mm + kMove_mm * Vec3<double>::Unit(i);
    const auto there = DeltaPoseOf(build, moved_mm);
    const double slope =
        here && there ? (there->nozzle_mm - here->nozzle_mm)[2] / kMove_mm : 1;
    variance_mm2 += std::pow(slope / steps_per_mm[static_cast<std::size_t>(i)], 2) / 12;
  }
  return std::max(std::sqrt(variance_mm2), kBest_mm);
}

DeltaReadings TouchAll(const DeltaProbe& probe,
                       double probe_sigma_mm,
                       const Machine& machine,
                       const DeltaModel<double>& settings,
                       const std::vector<Eigen::Vector2d>& points) {
  DeltaReadings readings;
  for (const Eigen::Vector2d& at : points) {
    if (const auto motors = probe(settings, at[0], at[1])) {
      readings.touches.push_back(
          {*motors, 0, TouchSigma_mm(probe_sigma_mm, machine, settings, *motors)});
    }
  }
  return readings;
}

// Every line of a firmware's settings that is not blank, behind whose they are.
void AddLines(const std::string& whose,
              const std::string& text,
              std::vector<std::string>* messages) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) messages->push_back(whose + line);
  }
}

// The twelve distances of Klipper's print, made with these settings.
std::vector<DeltaDistance> ReadPrint(const DeltaCalliper& calliper,
                                     const DeltaModel<double>& settings) {
  std::vector<DeltaDistance> distances;
  for (const KlipperRidge& ridge : KlipperPrint()) {
    DeltaDistance distance{.sigma_mm = std::max(calliper.sigma_mm, kBest_mm)};
    distance.from_mm =
        DeltaMotors_mm<double>(settings, {ridge.first_mm[0], ridge.first_mm[1], 0});
    distance.to_mm =
        DeltaMotors_mm<double>(settings, {ridge.second_mm[0], ridge.second_mm[1], 0});
    const auto length_mm = calliper.between_mm(distance.from_mm, distance.to_mm);
    if (!length_mm) continue;
    distance.length_mm = *length_mm;
    distances.push_back(distance);
  }
  return distances;
}

DeltaReadings ReadAll(const DeltaStep& step,
                      double probe_sigma_mm,
                      const Machine& machine,
                      const DeltaDoors& doors,
                      const DeltaModel<double>& start) {
  DeltaReadings readings =
      TouchAll(doors.probe,
               probe_sigma_mm,
               machine,
               start,
               DiscPoints(step.points, DeltaOf(machine).print_radius_mm));
  if (step.reads_print) readings.distances = ReadPrint(doors.calliper, start);
  for (int rod = 0; step.reads_rods && rod < kNumRods; ++rod) {
    const auto length_mm = doors.calliper.rod_mm(rod);
    if (!length_mm) continue;
    readings.rods.push_back({.rod = rod,
                             .length_mm = *length_mm,
                             .sigma_mm = std::max(doors.calliper.sigma_mm, kBest_mm)});
  }
  return readings;
}

// Knobs are counted from the settings that the touches were made with; what was stated
// of one that is a setting is its value.
DeltaJointOptions JointOptions(const DeltaStep& step,
                               const DeltaModel<double>& start,
                               const DeltaBuild<double>& drawn) {
  constexpr double kNothingBelieved_mm = 2;
  DeltaJointOptions options{.knobs = step.knobs};
  options.prior_mean.assign(kNumDeltaKnobs, 0);
  for (int knob = 0; knob < kNumDeltaKnobs; ++knob) {
    options.prior_sd.push_back(PriorSdOf(knob, drawn) /
                               kDeltaKnobs[static_cast<std::size_t>(knob)].per_unit);
  }
  // Rods that somebody reads need no belief in their length.
  if (step.reads_rods || step.reads_print) {
    options.prior_sd[kArmKnob] = kNothingBelieved_mm;
  }
  for (const DeltaPrior& prior : step.priors) {
    const auto at = static_cast<std::size_t>(prior.knob);
    options.prior_sd[at] = prior.sd;
    if (!prior.value) continue;
    const auto set = DeltaSettingNamed(start, drawn.model, kDeltaKnobs[at].name);
    options.prior_mean[at] = *prior.value - set.value_or(0);
  }
  return options;
}

// What the estimate says of itself, and settings as firmwares take them.
void AddReport(const DeltaJointFit& fit,
               const DeltaReadings& readings,
               const DeltaModel<double>& start,
               const Machine& machine,
               DeltaOutcome* outcome) {
  std::vector<std::string>& messages = outcome->messages;
  std::string lengths;
  if (!readings.distances.empty()) {
    lengths += fmt::format(", {} distances on a print", readings.distances.size());
  }
  if (!readings.rods.empty()) {
    lengths += fmt::format(", {} rods by calliper", readings.rods.size());
  }
  messages.push_back(fmt::format(
      "joint estimate of {} unknowns from {} touches{}: {:.4f} mm rms, {:.4f} mm of "
      "points left out",
      fit.estimates.size(),
      readings.touches.size(),
      lengths,
      fit.rms_mm,
      fit.hold_out_mm));
  const Vec3<double> next = BestNextTouch(
      fit, start, DeltaOf(machine).print_radius_mm, readings.touches.front().sigma_mm);
  messages.push_back(fmt::format(
      "one touch more would tell most at X{:.1f} Y{:.1f}", next[0], next[1]));
  const DeltaModel<double>& drawn = DeltaOf(machine).model;
  AddLines("before, Marlin: ", AsMarlin(start, drawn), &messages);
  AddLines("after, Marlin: ", AsMarlin(outcome->settings, drawn), &messages);
  AddLines("after, RepRapFirmware: ", AsRrf(outcome->settings, drawn), &messages);
  AddLines("after, printer.cfg: ", AsKlipper(outcome->settings), &messages);
  if (outcome->mesh.nodes > 0) {
    AddLines("after, printer.cfg: ", MeshAsKlipper(outcome->mesh), &messages);
  }
}

Performed PerformJoint(const DeltaStep& step,
                       double probe_sigma_mm,
                       const Machine& machine,
                       const DeltaDoors& doors,
                       const DeltaModel<double>& start) {
  const double radius_mm = DeltaOf(machine).print_radius_mm;
  const DeltaBuild<double> drawn = DeltaOf(machine).Build();
  const DeltaBuild<double> believed = WithSettings(drawn, start);
  const DeltaReadings readings = ReadAll(step, probe_sigma_mm, machine, doors, start);
  Performed performed{.outcome = {.settings = start}};
  performed.outcome.touches = static_cast<int>(readings.touches.size());
  if (readings.touches.empty()) return performed;
  performed.fit = FitDeltaJointly(believed, readings, JointOptions(step, start, drawn));
  const DeltaJointFit& fit = *performed.fit;
  const DeltaModel<double> best = BestDeltaSettings(
      fit.build, fit.bed, start, radius_mm, {.has_radius_per_tower = false});
  const DeltaChange change = ChangeOf(fit, start, best, radius_mm);
  performed.outcome.is_done = fit.converged;
  performed.outcome.said_mm = fit.hold_out_mm;
  performed.outcome.correlations = CorrelationsOfDelta(fit);
  if (change.IsTold()) performed.outcome.settings = best;
  if (step.makes_mesh) {
    performed.outcome.mesh =
        ForetoldMesh(fit, performed.outcome.settings, radius_mm, kMeshNodes);
  }
  AddReport(fit, readings, start, machine, &performed.outcome);
  if (!change.IsTold()) {
    performed.outcome.messages.push_back(fmt::format(
        "the settings are kept: others would move the nozzle by {:.4f} mm in z, {:.4f} "
        "mm in the plane and {:.3f} um/mm in size, less than twice what these readings "
        "leave open ({:.4f}, {:.4f}, {:.3f})",
        change.height_mm.by,
        change.place_mm.by,
        UmFromMm(change.scale.by),
        change.height_mm.sd,
        change.place_mm.sd,
        UmFromMm(change.scale.sd)));
  }
  return performed;
}

// What an engine moves, in the words of the joint estimate.
std::vector<int> KnobsOfEngine(const DeltaStep& step) {
  std::vector<int> knobs = {kEndstopKnob, kEndstopKnob + 1, kEndstopKnob + 2};
  const int factors = step.name == "rrf_least_squares" ? step.factors : kKlipperSix;
  if (factors >= 4) knobs.push_back(kRadiusKnob);
  if (factors >= 6) knobs.insert(knobs.end(), {kAngleKnob, kAngleKnob + 1});
  if (factors == 7 || factors == 9) knobs.push_back(kArmKnob);
  if (factors >= 8) knobs.insert(knobs.end(), {kBedKnob, kBedKnob + 1});
  return knobs;
}

// Neither firmware says how sure its settings are: told beside them.
void AddUncertainty(const DeltaStep& step,
                    const DeltaBuild<double>& drawn,
                    std::vector<DeltaTouch> touches,
                    DeltaOutcome* outcome) {
  if (!outcome->is_done) return;
  EngineUncertainty sure = UncertaintyOfHeightSquares(outcome->settings,
                                                      {.procedure = step.name,
                                                       .knobs = KnobsOfEngine(step),
                                                       .touches = std::move(touches),
                                                       .drawn = drawn});
  outcome->correlations = std::move(sure.correlations);
  for (Estimate& estimate : sure.estimates) {
    const auto set = DeltaSettingNamed(outcome->settings, drawn.model, estimate.name);
    if (!set) continue;  // A tilt, which is no setting.
    estimate.value = *set;
    outcome->estimates.push_back(std::move(estimate));
  }
}

// Eight and nine factors find the bed's tilt, which the firmware on the wire has no
// number for.
DeltaOutcome WithTiltTold(DeltaOutcome outcome) {
  if (outcome.tilt_x == 0 && outcome.tilt_y == 0) return outcome;
  outcome.messages.push_back(fmt::format(
      "the bed's tilt that was found, {:.3f} and {:.3f} mrad, is not commanded: Marlin "
      "has no setting for it, so the nozzle errs by it",
      MradFromRad(outcome.tilt_x),
      MradFromRad(outcome.tilt_y)));
  return outcome;
}

}  // namespace

G33Variant VariantOf(std::string_view variant) {
  return variant == "as_published" ? G33Variant::kAsPublished : G33Variant::kCorrected;
}

std::optional<Observability> BlindnessOfG33(int points) {
  constexpr int kAngles = 3;  // From this grid on.
  if (points >= kAngles) return std::nullopt;
  return Observability{
      .statement = fmt::format(
          "G33 P{} touches too few places to tell tower angles{}: its deviation says "
          "nothing of them",
          points,
          points < 2 ? ", endstops and radius" : ""),
      .blind_direction = {{"tower_angle.a", 1}, {"tower_angle.b", 1}}};
}

DeltaOutcome PerformDeltaStep(const DeltaStep& step,
                              double probe_sigma_mm,
                              const Machine& machine,
                              const DeltaDoors& doors,
                              const DeltaModel<double>& start,
                              std::optional<DeltaJointFit>* fit) {
  const double radius_mm = DeltaOf(machine).print_radius_mm;
  const DeltaBuild<double> drawn = DeltaOf(machine).Build();
  std::vector<DeltaTouch> touches;
  const DeltaProbe probe =
      [&](const DeltaModel<double>& settings, double x_mm, double y_mm) {
        const auto motors_mm = doors.probe(settings, x_mm, y_mm);
        if (motors_mm) {
          const double sigma_mm =
              TouchSigma_mm(probe_sigma_mm, machine, settings, *motors_mm);
          touches.push_back({.motors_mm = *motors_mm, .sigma_mm = sigma_mm});
        }
        return motors_mm;
      };
  if (step.name == "rrf_least_squares") {
    DeltaOutcome outcome = WithTiltTold(CalibrateRrf(
        probe, start, {.factors = step.factors, .points = RrfProbePoints(radius_mm)}));
    AddUncertainty(step, drawn, std::move(touches), &outcome);
    return outcome;
  }
  if (step.name == "klipper_descent") {
    KlipperOptions options{.points = KlipperProbePoints(radius_mm)};
    if (step.reads_print) options.distances = ReadPrint(doors.calliper, start);
    DeltaOutcome outcome = CalibrateKlipper(probe, start, options);
    // With a print it weighs lengths by a rule of its own, no noise in it.
    if (!step.reads_print) AddUncertainty(step, drawn, std::move(touches), &outcome);
    return outcome;
  }
  const Performed performed = PerformJoint(step, probe_sigma_mm, machine, doors, start);
  *fit = performed.fit;
  return performed.outcome;
}

}  // namespace caltwin
