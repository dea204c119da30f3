#include "scenarios/delta_procedures.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "calibration/delta/klipper_descent.h"
#include "calibration/delta/rrf_least_squares.h"
#include "calibration/delta/settings.h"
#include "scenarios/delta_link.h"

namespace caltwin {
namespace {

constexpr double kBest_mm = 1e-3;  // Less than this no touch is believed to scatter.

/// What a procedure left behind.
struct Performed {
  DeltaOutcome outcome{};
  std::optional<DeltaJointFit> fit{};
};

DeltaReadings TouchAll(const DeltaProbe& probe,
                       const DeltaModel<double>& settings,
                       const std::vector<Eigen::Vector2d>& points,
                       double sigma_mm) {
  DeltaReadings readings;
  for (const Eigen::Vector2d& at : points) {
    if (const auto motors = probe(settings, at[0], at[1])) {
      readings.touches.push_back({*motors, 0, sigma_mm});
    }
  }
  return readings;
}

// A touch is counted in whole steps: as uniform as its scatter is normal.
double TouchSigma_mm(const DeltaScenario& scenario, const Machine& machine) {
  const double step_mm = 1 / TowerStepsPerMm(machine)[0];
  return std::max(std::hypot(scenario.probe_sigma_mm, step_mm / std::sqrt(12.0)),
                  kBest_mm);
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

Performed PerformJoint(const DeltaStep& step,
                       const DeltaScenario& scenario,
                       const Machine& machine,
                       const DeltaProbe& probe,
                       const DeltaModel<double>& start) {
  const double radius_mm = machine.delta->print_radius_mm;
  DeltaBuild<double> believed = machine.delta->Build();
  believed.model = start;
  const DeltaReadings readings = TouchAll(probe,
                                          start,
                                          DiscPoints(step.points, radius_mm),
                                          TouchSigma_mm(scenario, machine));
  Performed performed;
  performed.fit = FitDeltaJointly(
      believed,
      readings,
      {.knobs = step.unknowns == "machine" ? MachineKnobs() : FirmwareKnobs()});
  const DeltaJointFit& fit = *performed.fit;
  performed.outcome = {
      .settings = BestDeltaSettings(
          fit.build, fit.bed, start, radius_mm, {.has_radius_per_tower = false}),
      .touches = static_cast<int>(readings.touches.size()),
      .is_done = fit.converged,
      .said_mm = fit.hold_out_mm,
      .messages = {fmt::format("joint estimate of {} unknowns from {} touches: {:.4f} "
                               "mm rms, {:.4f} mm of points left out",
                               fit.estimates.size(),
                               readings.touches.size(),
                               fit.rms_mm,
                               fit.hold_out_mm)}};
  const Vec3<double> next =
      BestNextTouch(fit, start, radius_mm, TouchSigma_mm(scenario, machine));
  std::vector<std::string>& messages = performed.outcome.messages;
  messages.push_back(fmt::format(
      "one touch more would tell most at X{:.1f} Y{:.1f}", next[0], next[1]));
  const DeltaModel<double>& drawn = machine.delta->model;
  AddLines("before, Marlin: ", AsMarlin(start, drawn), &messages);
  AddLines("after, Marlin: ", AsMarlin(performed.outcome.settings, drawn), &messages);
  AddLines(
      "after, RepRapFirmware: ", AsRrf(performed.outcome.settings, drawn), &messages);
  AddLines("after, printer.cfg: ", AsKlipper(performed.outcome.settings), &messages);
  return performed;
}

}  // namespace

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
                              const DeltaScenario& scenario,
                              const Machine& machine,
                              const DeltaProbe& probe,
                              const DeltaModel<double>& start,
                              std::optional<DeltaJointFit>* fit) {
  const double radius_mm = machine.delta->print_radius_mm;
  if (step.name == "rrf_least_squares") {
    return CalibrateRrf(
        probe, start, {.factors = step.factors, .points = RrfProbePoints(radius_mm)});
  }
  if (step.name == "klipper_descent") {
    return CalibrateKlipper(probe, start, {.points = KlipperProbePoints(radius_mm)});
  }
  const Performed performed = PerformJoint(step, scenario, machine, probe, start);
  *fit = performed.fit;
  return performed.outcome;
}

}  // namespace caltwin
