#include "scenarios/delta_runner.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "calibration/delta/g33.h"
#include "calibration/delta/joint.h"
#include "scenarios/delta_link.h"
#include "scenarios/delta_procedures.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;  // Of the heights as they were.
// Of a touch inside the firmware: travel, descent and lift; with E, the probe stowed
// and deployed.
constexpr double kG33Touch_s = 3, kG33Stow_s = 2;

/// One value of the settings, as the results' table names it.
std::optional<double> SettingOf(const DeltaModel<double>& model,
                                const DeltaModel<double>& drawn,
                                std::string_view name) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string tower = TowerName(static_cast<int>(i));
    if (name == "endstop." + tower) return model.endstop_mm[i];
    if (name == "tower_angle." + tower) {
      return DegFromRad(model.angle_rad[i] - drawn.angle_rad[i]);
    }
  }
  if (name == "delta_radius") return MeanOfTowers(model.radius_mm);
  if (name == "arm_length") return MeanOfTowers(model.arm_mm);
  return std::nullopt;
}

constexpr std::array kSettingNames = {"endstop.a",
                                      "endstop.b",
                                      "endstop.c",
                                      "delta_radius",
                                      "tower_angle.a",
                                      "tower_angle.b",
                                      "arm_length"};

/// A run on its way.
class DeltaRun {
 public:
  DeltaRun(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario),
        delta_(*scenario.delta),
        machine_(scenario.machine.machine),
        options_(options),
        seed_(options.seed.value_or(scenario.seed)),
        built_(DrawDelta(delta_, machine_, seed_, options.sample)),
        fidelity_(options.fidelity.value_or(scenario.fidelity)),
        plant_(
            machine_, built_, fidelity_ == Fidelity::kPhysics, seed_, options.sample),
        marlin_(machine_.delta->model,
                delta_.settings,
                TowerStepsPerMm(machine_),
                &plant_,
                [this](const GcodeCommand& words, DeltaModel<double>* settings) {
                  return AnswerG33(words, settings);
                }),
        wire_(&marlin_) {}

  RunResult Perform() {
    const std::clock_t start = std::clock();
    RunResult result{.scenario = scenario_.file.string(),
                     .about = scenario_.about,
                     .verbatim = scenario_.verbatim,
                     .machine = machine_.name,
                     .fidelity = ToString(fidelity_),
                     .seed = seed_};
    const DeltaAccuracy before = Accuracy();
    result.position_error_before_p95_mm = PositionP95_mm();
    InterruptibleLink link(&wire_);
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&link, options_.transcript);
    }
    Link* wire = recorder ? static_cast<Link*>(recorder.get()) : &link;
    if (!delta_.probe_offset_mm.isZero(0)) {
      const Vec3<double>& offset_mm = delta_.probe_offset_mm;
      DeltaLinkProbe(wire, machine_.delta->model, marlin_.settings())
          .Say(fmt::format("M851 X{:.2f} Y{:.2f} Z{:.3f}",
                           offset_mm[0],
                           offset_mm[1],
                           offset_mm[2]));
    }
    for (const DeltaStep& step : delta_.calibrate) {
      options_.progress(step.name);
      Take(step, wire, &result);
      if (InterruptRequested()) result.interrupted = true;
      if (was_out_of_reach_ || fault_ || result.interrupted) break;
    }
    if (recorder) recorder->Save();
    result.touches = marlin_.touches() + g33_touches_;
    result.machine_time_s =
        marlin_.machine_time_s() + kG33Touch_s * g33_touches_ + kG33Stow_s * g33_stows_;
    result.position_error_after_p95_mm = PositionP95_mm();
    Judge(before, Accuracy(), &result);
    result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return result;
  }

 private:
  std::vector<std::string> AnswerG33(const GcodeCommand& words,
                                     DeltaModel<double>* settings) {
    G33Options options{.probe_offset_mm = marlin_.probe_offset_mm(),
                       .variant = g33_variant_};
    options.printable_radius_mm = machine_.delta->print_radius_mm;
    try {
      options = ReadG33(words, options);
    } catch (const InputError& implausible) {
      return {implausible.what()};
    }
    const DeltaProbe probe =
        [this](const DeltaModel<double>& at, double x_mm, double y_mm) {
          ++g33_touches_;
          return plant_.Touch(at, x_mm, y_mm);
        };
    const int before = g33_touches_;
    const DeltaOutcome outcome = CalibrateG33(probe, *settings, options);
    if (options.engages_probe) g33_stows_ += g33_touches_ - before;
    *settings = outcome.settings;
    said_mm_ = outcome.said_mm;
    return outcome.messages;
  }

  void Take(const DeltaStep& step, Link* wire, RunResult* result) {
    fit_.reset();  // What an earlier step knew is no uncertainty of this one's.
    const DeltaModel<double> before = marlin_.settings();
    DeltaLinkProbe probe(wire, machine_.delta->model, before);
    if (step.name == "g33") {
      g33_variant_ = step.variant == "as_published" ? G33Variant::kAsPublished
                                                    : G33Variant::kCorrected;
      if (const auto blind = BlindnessOfG33(step.points)) {
        result->observability.push_back(*blind);
      }
      const auto lines = probe.Say(fmt::format("G33 P{}{}", step.points, step.words));
      result->messages.insert(result->messages.end(), lines.begin(), lines.end());
    } else {
      const DeltaOutcome outcome =
          PerformDeltaStep(step, delta_, machine_, probe.AsProbe(), before, &fit_);
      if (!probe.fault()) {
        probe.Set(outcome.settings);
        probe.Say("M500");
      }
      said_mm_ = outcome.said_mm;
      result->messages.insert(
          result->messages.end(), outcome.messages.begin(), outcome.messages.end());
    }
    was_out_of_reach_ = probe.was_out_of_reach();
    fault_ = probe.fault();
    if (fault_) result->messages.push_back("the machine said: " + *fault_);
    for (const char* name : kSettingNames) {
      const double was = *SettingOf(before, machine_.delta->model, name);
      const double is = *SettingOf(marlin_.settings(), machine_.delta->model, name);
      if (was == is) continue;
      result->steps.push_back({.procedure = step.name,
                               .variant = step.variant,
                               .name = name,
                               .before = was,
                               .after = is,
                               .verdict = Verdict::kApplied});
    }
  }

  DeltaAccuracy Accuracy() const {
    return DeltaAccuracyOf(
        built_.build, built_.bed, marlin_.settings(), machine_.delta->print_radius_mm);
  }

  // At 1000 seeded poses up to half the height, the mean offset removed.
  double PositionP95_mm() const {
    constexpr int kPoses = 1000;
    Rng rng(1, 0, "position_error_mm");
    std::vector<Vec3<double>> errors_mm;
    Vec3<double> mean_mm = Vec3<double>::Zero();
    for (int i = 0; i < kPoses; ++i) {
      const double out_mm = machine_.delta->print_radius_mm * std::sqrt(rng.Uniform());
      const double angle = 2 * std::numbers::pi * rng.Uniform();
      const Vec3<double> sent(out_mm * std::cos(angle),
                              out_mm * std::sin(angle),
                              machine_.delta->print_radius_mm * rng.Uniform());
      const auto pose =
          DeltaPoseOf(built_.build, DeltaMotors_mm(marlin_.settings(), sent));
      if (!pose) return std::numeric_limits<double>::infinity();
      errors_mm.push_back(pose->nozzle_mm - sent);
      mean_mm += errors_mm.back() / kPoses;
    }
    std::vector<double> sizes_mm;
    for (const Vec3<double>& error : errors_mm) {
      sizes_mm.push_back((error - mean_mm).norm());
    }
    const auto p95 = sizes_mm.begin() + kPoses * 95 / 100 - 1;
    std::nth_element(sizes_mm.begin(), p95, sizes_mm.end());
    return *p95;
  }

  void AddSettings(RunResult* result) const {
    for (const char* name : kSettingNames) {
      ParameterResult row{.name = name,
                          .unit = std::string(name).starts_with("tower") ? "deg" : "mm",
                          .identifiable = true,
                          .is_setting = true};
      row.injected = *SettingOf(built_.build.model, machine_.delta->model, name);
      row.recovered = *SettingOf(marlin_.settings(), machine_.delta->model, name);
      row.error = *row.recovered - row.injected;
      result->parameters.push_back(row);
    }
  }

  // What the joint estimate knows and no setting holds, and how sure it is of the rest.
  void AddEstimates(RunResult* result) const {
    constexpr double kSaidNothing = 0.9;  // Of the prior's standard deviation.
    if (!fit_) return;
    const bool has_tower_radii =
        std::ranges::any_of(fit_->estimates, [](const DeltaEstimate& estimate) {
          return kDeltaKnobs[static_cast<std::size_t>(estimate.knob)].name.starts_with(
              "tower_radius");
        });
    for (const DeltaEstimate& estimate : fit_->estimates) {
      const std::string told_name(
          kDeltaKnobs[static_cast<std::size_t>(estimate.knob)].name);
      if (estimate.sd_over_prior >= kSaidNothing) {
        result->observability.push_back(
            {.statement = told_name +
                          " is not told by these touches: its uncertainty is "
                          "still that of its prior",
             .blind_direction = {{told_name, 1}}});
      }
      const DeltaKnob& knob = kDeltaKnobs[static_cast<std::size_t>(estimate.knob)];
      const bool is_told = estimate.sd_over_prior < kSaidNothing;
      const auto known = std::ranges::find(
          result->parameters, std::string(knob.name), &ParameterResult::name);
      if (known != result->parameters.end()) {
        // With a radius for each tower the common one is tower c's, no setting.
        if (knob.name == "delta_radius" && has_tower_radii) continue;
        // What was found; the settings made of it stand among the steps.
        known->recovered =
            SettingOf(fit_->build.model, machine_.delta->model, std::string(knob.name));
        known->error = *known->recovered - known->injected;
        known->sd = estimate.sd;
        known->identifiable = is_told;
        known->is_setting = false;
        continue;
      }
      ParameterResult row{.name = std::string(knob.name),
                          .unit = std::string(knob.unit),
                          .identifiable = is_told};
      row.injected =
          KnobValue(estimate.knob, built_.build, built_.bed, machine_.delta->Build());
      if (is_told) {
        row.recovered = estimate.value;
        row.sd = estimate.sd;
        row.error = estimate.value - row.injected;
      }
      result->parameters.push_back(row);
    }
  }

  void AddCheck(const std::string& name,
                double found,
                const Within& within,
                RunResult* result) const {
    const bool is_above = !within.above || found > *within.above;
    const bool is_below = !within.below || found < *within.below;
    std::string expected;
    if (within.above) expected += fmt::format("above {:g}", *within.above);
    if (within.below) {
      expected +=
          fmt::format("{}below {:g}", expected.empty() ? "" : ", ", *within.below);
    }
    result->checks.push_back({.name = name,
                              .expected = expected,
                              .found = fmt::format("{:.5g}", found),
                              .passed = is_above && is_below});
  }

  // Whether every value that was expected came out.
  bool MeetValues(RunResult* result) const {
    bool all_met = true;
    for (const DeltaExpectedValue& expected : delta_.values) {
      const auto row =
          std::ranges::find(result->parameters, expected.name, &ParameterResult::name);
      bool passed = row != result->parameters.end();
      if (passed && expected.identifiable) {
        passed = row->identifiable == *expected.identifiable;
      }
      if (passed && expected.truth_within) {
        row->tolerance = expected.truth_within;
        passed = row->error && std::abs(*row->error) <= *expected.truth_within;
      }
      if (row != result->parameters.end()) {
        row->passed = passed;
      } else {
        result->checks.push_back({.name = expected.name,
                                  .expected = "a value",
                                  .found = "not estimated",
                                  .passed = false});
      }
      all_met = all_met && passed;
    }
    return all_met;
  }

  void Judge(const DeltaAccuracy& before,
             const DeltaAccuracy& after,
             RunResult* result) {
    AddSettings(result);
    AddEstimates(result);
    const bool all_met = MeetValues(result);
    result->messages.push_back(fmt::format(
        "the nozzle stands {:.1f} um rms off the bed ({:.1f} at most), {:.1f} before; "
        "prints are {:+.2f} um/mm wrong; the procedure says {:.4f} mm",
        UmFromMm(after.z_rms_mm),
        UmFromMm(after.z_most_mm),
        UmFromMm(before.z_rms_mm),
        UmFromMm(after.xy_scale),
        said_mm_));
    for (const auto& [name, within] : delta_.figures) {
      const double found = name == "height_error_mm.rms"    ? after.z_rms_mm
                           : name == "height_error_mm.most" ? after.z_most_mm
                           : name == "said_mm"              ? said_mm_
                           : name == "xy_scale_um_per_mm"
                               ? UmFromMm(after.xy_scale)
                               : result->position_error_after_p95_mm;
      AddCheck(name, found, within, result);
    }
    for (const std::string& text : delta_.messages) {
      const bool is_there =
          std::ranges::any_of(result->messages, [&](const std::string& line) {
            return line.find(text) != std::string::npos;
          });
      result->checks.push_back({.name = "message",
                                .expected = text,
                                .found = is_there ? "said" : "not said",
                                .passed = is_there});
    }
    result->outcome = fault_                                 ? "alarm"
                      : was_out_of_reach_                    ? "no_trigger"
                      : after.z_rms_mm > 2 * before.z_rms_mm ? "diverges"
                      : all_met && after.z_rms_mm < kRecovered * before.z_rms_mm
                          ? "recovers"
                          : "misses";
    result->checks.insert(result->checks.begin(),
                          {.name = "outcome",
                           .expected = delta_.outcome,
                           .found = result->outcome,
                           .passed = result->outcome == delta_.outcome});
    result->passed =
        !result->interrupted &&
        std::ranges::all_of(result->checks, &CheckResult::passed) &&
        std::ranges::none_of(result->parameters, [](const ParameterResult& row) {
          return row.passed == false;
        });
  }

  const Scenario& scenario_;
  const DeltaScenario& delta_;
  const Machine& machine_;
  const RunOptions& options_;
  std::uint64_t seed_;
  BuiltDelta built_;
  Fidelity fidelity_;
  DeltaTwinPlant plant_;
  MarlinDelta marlin_;
  MarlinDeltaWire wire_;
  G33Variant g33_variant_ = G33Variant::kCorrected;
  std::optional<DeltaJointFit> fit_{};
  double said_mm_ = 0;
  int g33_touches_ = 0, g33_stows_ = 0;
  bool was_out_of_reach_ = false;
  std::optional<std::string> fault_{};
};

}  // namespace

RunResult RunDeltaScenario(const Scenario& scenario, const RunOptions& options) {
  return DeltaRun(scenario, options).Perform();
}

}  // namespace caltwin
