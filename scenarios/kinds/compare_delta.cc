#include "scenarios/kinds/compare_delta.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "calibration/kinds/delta/foretold_mesh.h"
#include "calibration/kinds/delta/g33.h"
#include "calibration/kinds/delta/joint.h"
#include "calibration/kinds/delta/klipper_descent.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "calibration/kinds/delta/settings.h"
#include "scenarios/host_lost.h"
#include "scenarios/interrupt.h"
#include "scenarios/kinds/delta_shipped.h"
#include "scenarios/study/summary.h"
#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {
namespace {

// A fraction is mm per mm.
double UmPerMm(double scale) {
  return UmFromMm(scale);
}

template <int points>
DeltaOutcome G33(const DeltaProbe& probe, const DeltaModel<double>& start) {
  return CalibrateG33(probe,
                      start,
                      {.points = points,
                       .printable_radius_mm = kCompareRadius_mm,
                       .variant = G33Variant::kAsPublished});
}

template <int factors>
DeltaOutcome Rrf(const DeltaProbe& probe, const DeltaModel<double>& start) {
  return CalibrateRrf(
      probe, start, {.factors = factors, .points = RrfProbePoints(kCompareRadius_mm)});
}

DeltaOutcome Klipper(const DeltaProbe& probe, const DeltaModel<double>& start) {
  return CalibrateKlipper(
      probe, start, {.points = KlipperProbePoints(kCompareRadius_mm)});
}

/// What the firmware is told beside its settings, which otherwise bend the machine to
/// the bed as far as they can.
enum class Beside { kNothing, kTilt, kMesh };

// RRF's sixteen points; everything about the machine is unknown, within its priors.
template <Beside beside>
DeltaOutcome Joint(const DeltaProbe& probe, const DeltaModel<double>& start) {
  constexpr int kNodes = 7;
  DeltaReadings readings;
  DeltaOutcome outcome{.settings = start};
  for (const Eigen::Vector2d& at : RrfProbePoints(kCompareRadius_mm)) {
    const auto motors_mm = probe(start, at[0], at[1]);
    if (!motors_mm) return outcome;
    readings.touches.push_back(
        {.motors_mm = *motors_mm, .sigma_mm = kCompareTouchSigma_mm});
    ++outcome.touches;
  }
  const DeltaJointFit fit =
      FitDeltaJointly({.model = start}, readings, {.knobs = MachineKnobs()});
  outcome.is_done = fit.converged;
  outcome.said_mm = fit.hold_out_mm;
  DeltaBed<double> bed = fit.bed;
  if (beside == Beside::kTilt) {
    outcome.tilt_x = std::exchange(bed.slope_x, 0);
    outcome.tilt_y = std::exchange(bed.slope_y, 0);
  }
  // One radius for all towers: what every firmware here can hold.
  outcome.settings = BestDeltaSettings(
      fit.build, bed, start, kCompareRadius_mm, {.has_radius_per_tower = false});
  if (beside == Beside::kMesh) {
    outcome.mesh = ForetoldMesh(fit, outcome.settings, kCompareRadius_mm, kNodes);
  }
  return outcome;
}

DeltaOutcome Kalico(const DeltaCase& machine, std::uint64_t seed) {
  return CalibrateByKalico(
      {.build = machine.build, .bed = machine.bed, .scatter_mm = kCompareTouchSigma_mm},
      kCompareRadius_mm,
      seed);
}

constexpr std::array kRivals = {
    DeltaRival{"g33", "Marlin's G33 P4, as published", G33<4>},
    DeltaRival{"g33_p10", "Marlin's G33 P10, as published", G33<10>},
    DeltaRival{"rrf_least_squares", "RepRapFirmware's, 6 factors, 16 points", Rrf<6>},
    DeltaRival{"rrf_8_factors", "the same with the bed's tilt", Rrf<8>},
    DeltaRival{"klipper_descent", "Klipper's, 6 parameters, 7 points", Klipper},
    DeltaRival{"delta_joint",
               "caltwin's, 29 unknowns with priors, 16 points",
               Joint<Beside::kNothing>},
    DeltaRival{
        "delta_joint_tilt", "the same with the bed's tilt", Joint<Beside::kTilt>},
    DeltaRival{"delta_joint_mesh",
               "the same with a mesh of heights, foretold",
               Joint<Beside::kMesh>},
    DeltaRival{.name = "kalico",
               .about = "Klipper's own host, as shipped, over steps of 12.5 um",
               .calibrate_shipped = Kalico}};

std::vector<const DeltaRival*> RivalsNamed(const std::vector<std::string>& names) {
  std::vector<const DeltaRival*> rivals;
  for (const DeltaRival& rival : kRivals) {
    if (names.empty() && rival.calibrate != nullptr) rivals.push_back(&rival);
  }
  for (const std::string& name : names) {
    const auto* const found = std::ranges::find(kRivals, name, &DeltaRival::name);
    if (found == kRivals.end()) {
      throw InputError({.file = "--engines"},
                       "there is no engine '" + name + "'",
                       DeltaRivalNames());
    }
    if (std::ranges::find(rivals, found) == rivals.end()) rivals.push_back(found);
  }
  return rivals;
}

// Of the processor, programs that it has started and that have ended included [s].
double Spent_s() {
  double spent_s = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage of{};
    getrusage(who, &of);
    for (const timeval& part : {of.ru_utime, of.ru_stime}) {
      spent_s +=
          static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
    }
  }
  return spent_s;
}

struct Trial {
  int touches = 0;
  bool has_failed = false;
  DeltaAccuracy after{};
  double time_s = 0;
};

Trial Try(const DeltaRival& rival, const DeltaCase& machine, std::uint64_t seed) {
  const DeltaModel<double> drawn = SymmetricDelta(300, 130, 250);
  SimulatedDelta touched(machine.build, machine.bed, kCompareTouchSigma_mm, seed);
  const DeltaProbe probe =
      [&](const DeltaModel<double>& settings, double x_mm, double y_mm) {
        return touched.Touch(settings, x_mm, y_mm);
      };
  const double start_s = Spent_s();
  const DeltaOutcome outcome = rival.calibrate != nullptr
                                   ? rival.calibrate(probe, drawn)
                                   : rival.calibrate_shipped(machine, seed);
  Trial trial{.touches = outcome.touches};
  trial.time_s = Spent_s() - start_s;
  // A tilt that the firmware knows of is commanded too.
  DeltaBed<double> bed = machine.bed;
  bed.slope_x -= outcome.tilt_x;
  bed.slope_y -= outcome.tilt_y;
  trial.after = DeltaAccuracyOf(
      machine.build, bed, outcome.settings, kCompareRadius_mm, outcome.mesh);
  const double before_mm =
      DeltaAccuracyOf(machine.build, machine.bed, drawn, kCompareRadius_mm).z_rms_mm;
  trial.has_failed = !outcome.is_done || !(trial.after.z_rms_mm < before_mm);
  return trial;
}

DeltaStanding StandingOf(const DeltaRival& rival, const std::vector<Trial>& trials) {
  DeltaStanding standing{.name = rival.name};
  std::vector<double> z_um, scale, time_s;
  for (const Trial& trial : trials) {
    standing.touches +=
        static_cast<double>(trial.touches) / static_cast<double>(trials.size());
    standing.failures += trial.has_failed ? 1 : 0;
    time_s.push_back(trial.time_s);
    // What never reached the bed has no accuracy; it stands among the failures.
    if (!std::isfinite(trial.after.z_rms_mm)) continue;
    z_um.push_back(UmFromMm(trial.after.z_rms_mm));
    scale.push_back(UmPerMm(std::abs(trial.after.xy_scale)));
  }
  standing.z_rms_um = SpreadOf(z_um);
  standing.xy_scale_um_per_mm = SpreadOf(scale);
  standing.time_s = SpreadOf(time_s).median;
  return standing;
}

nlohmann::ordered_json SpreadJson(const Spread& spread) {
  return {{"median", spread.median},
          {"p95", spread.p95},
          {"ci95", {spread.low, spread.high}}};
}

}  // namespace

std::span<const DeltaRival> DeltaRivals() {
  return kRivals;
}

std::string DeltaRivalNames() {
  std::vector<std::string_view> names;
  for (const DeltaRival& rival : kRivals) names.push_back(rival.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

DeltaCase RandomDelta(std::uint64_t seed, int machine) {
  Rng rng(seed, static_cast<std::uint64_t>(machine), "compare.delta");
  const auto within = [&rng](double most) {
    return most * (2 * rng.Uniform() - 1);
  };
  DeltaCase random{.build = {.model = SymmetricDelta(300, 130 + within(1), 250)}};
  for (double& endstop_mm : random.build.model.endstop_mm) endstop_mm += within(1);
  for (std::size_t i = 0; i < 2; ++i) {
    random.build.model.angle_rad[i] += RadFromDeg(within(0.5));
  }
  for (double& error_mm : random.build.rod_error_mm) error_mm = within(0.3);
  random.bed.slope_x = RadFromMrad(within(3));
  random.bed.slope_y = RadFromMrad(within(3));
  return random;
}

DeltaComparison CompareDelta(int machines,
                             std::uint64_t seed,
                             const std::function<void(int)>& progress,
                             const std::vector<std::string>& engines) {
  Require(machines > 0, "machines to compare on");
  const std::vector<const DeltaRival*> rivals = RivalsNamed(engines);
  std::vector<std::vector<Trial>> trials(rivals.size());
  DeltaComparison comparison{.seed = seed};
  for (int i = 0; i < machines && !InterruptRequested(); ++i) {
    progress(i);
    const DeltaCase machine = RandomDelta(seed, i);
    const std::uint64_t touch_seed =
        Rng(seed, static_cast<std::uint64_t>(i), "compare.delta.touch").Next();
    std::vector<Trial> here;
    try {
      for (const DeltaRival* rival : rivals) {
        here.push_back(Try(*rival, machine, touch_seed));
      }
    } catch (const HostLost&) {
      if (!InterruptRequested()) throw;
      break;  // Machines that all engines have done stay.
    }
    for (std::size_t k = 0; k < rivals.size(); ++k) trials[k].push_back(here[k]);
    ++comparison.machines;
  }
  comparison.is_interrupted = comparison.machines < machines;
  if (comparison.machines == 0) return comparison;
  for (std::size_t k = 0; k < rivals.size(); ++k) {
    comparison.engines.push_back(StandingOf(*rivals[k], trials[k]));
  }
  return comparison;
}

std::vector<Contender> ContendersOf(const DeltaComparison& comparison) {
  return Contenders(comparison, DeltaRivals(), &DeltaStanding::z_rms_um);
}

std::string DeltaComparisonText(const DeltaComparison& comparison) {
  std::string text = fmt::format(
      "{} random deltas, seed {}; touches scatter by {:.0f} um; judged at unseen "
      "points "
      "within {:.0f} mm\n\n{:<18} {:>8} {:>15} {:>28} {:>28} {:>9}\n",
      comparison.machines,
      comparison.seed,
      UmFromMm(kCompareTouchSigma_mm),
      kCompareRadius_mm,
      "engine",
      "touches",
      "failed [95 %]",
      "z rms um: median [95 %] p95",
      "scale um/mm: the same",
      "time");
  const auto spread = [](const Spread& of, int digits) {
    if (std::isnan(of.low)) {
      return fmt::format(
          "{:.{}f} [too few] {:.{}f}", of.median, digits, of.p95, digits);
    }
    return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}] {:.{}f}",
                       of.median,
                       digits,
                       of.low,
                       digits,
                       of.high,
                       digits,
                       of.p95,
                       digits);
  };
  for (const DeltaStanding& engine : comparison.engines) {
    const Rate failed = RateOf(engine.failures, comparison.machines);
    text += fmt::format("{:<18} {:>8.1f} {:>15} {:>28} {:>28} {:>7.2g} s\n",
                        engine.name,
                        engine.touches,
                        fmt::format("{} [{:.1f}, {:.1f} %]",
                                    engine.failures,
                                    PercentFromFraction(failed.low),
                                    PercentFromFraction(failed.high)),
                        spread(engine.z_rms_um, 1),
                        spread(engine.xy_scale_um_per_mm, 2),
                        engine.time_s);
  }
  return text;
}

nlohmann::ordered_json DeltaComparisonJson(const DeltaComparison& comparison) {
  nlohmann::ordered_json engines = nlohmann::ordered_json::array();
  for (const DeltaStanding& engine : comparison.engines) {
    const Rate failed = RateOf(engine.failures, comparison.machines);
    engines.push_back({{"name", engine.name},
                       {"touches", engine.touches},
                       {"failures", engine.failures},
                       {"failures_ci95", {failed.low, failed.high}},
                       {"z_rms_um", SpreadJson(engine.z_rms_um)},
                       {"xy_scale_um_per_mm", SpreadJson(engine.xy_scale_um_per_mm)},
                       {"time_s", engine.time_s}});
  }
  return {{"format", 1},
          {"kind", "delta"},
          {"machines", comparison.machines},
          {"seed", comparison.seed},
          {"engines", engines}};
}

}  // namespace caltwin
