#include "scenarios/z_offset_runner.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "calibration/kinds/z_station/switch_offset.h"
#include "scenarios/judging.h"
#include "scenarios/z_offset_link.h"
#include "scenarios/z_offset_record.h"
#include "sim/base/units.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr double kRecovered_mm = 0.01;

class ZOffsetRun {
 public:
  ZOffsetRun(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario),
        z_(*scenario.z_offset),
        options_(options),
        seed_(options.seed.value_or(scenario.seed)),
        fidelity_(options.fidelity.value_or(scenario.fidelity)),
        twin_(Drawn(),
              fidelity_ == Fidelity::kPhysics,
              seed_,
              options.sample,
              z_.settings.middle_mm),
        klipper_(z_.settings, &twin_),
        record_(z_.settings,
                std::max(twin_.station()->endstop_scatter_mm,
                         twin_.station()->probe_scatter_mm)),
        wire_(&klipper_) {}

  RunResult Perform() {
    const std::clock_t start = std::clock();
    RunResult result{.scenario = scenario_.file.string(),
                     .about = scenario_.about,
                     .verbatim = scenario_.verbatim,
                     .machine = scenario_.machine.machine.name,
                     .fidelity = ToString(fidelity_),
                     .seed = seed_};
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&wire_, options_.transcript);
    }
    ZOffsetClient client(recorder ? static_cast<Link*>(recorder.get()) : &wire_,
                         {.before_switch_gcode = klipper_.config().before_switch_gcode,
                          .end_gcode = klipper_.config().end_gcode});
    for (const ZOffsetStep& step : z_.calibrate) {
      options_.progress(step.name);
      // As homing alone leaves it.
      const bool calibrates =
          step.name == "z_calibration" || step.name == "switch_offset";
      const bool is_first = calibrates && result.steps.empty();
      if (is_first) result.position_error_before_p95_mm = HeightError_mm();
      const std::size_t before = klipper_.touched().size();
      const ProcedureResult done = Take(step, &client);
      record_.AddTouches(
          step.name, std::span(klipper_.touched()).subspan(before), twin_.is_wiped());
      ending_ = done.ending;
      AddDone(done, &result);
      result.messages.insert(
          result.messages.end(), done.messages.begin(), done.messages.end());
      AddEstimates(done.estimates, &result);
      if (ending_ != Ending::kDone) break;
    }
    if (client.is_spoilt()) {
      result.messages.push_back(
          "Z was homed after CALIBRATE_Z: its offset no longer holds, calibrate again");
    }
    if (recorder) recorder->Save();
    result.header = record_.header();
    result.rows = record_.rows();
    result.touches = klipper_.touches();
    result.machine_time_s = klipper_.machine_time_s();
    result.position_error_after_p95_mm = HeightError_mm();
    result.is_error_of_nozzle = true;
    Judge(&result);
    result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return result;
  }

 private:
  ZStation Drawn() const {
    ZStation station;
    SetStation(z_.station, seed_, options_.sample, &station);
    return station;
  }

  ProcedureResult Take(const ZOffsetStep& step, ZOffsetClient* client) {
    if (step.name == "z_calibration") {
      return RunZCalibration(client, klipper_.config().switch_offset_mm);
    }
    if (step.name == "probe_accuracy") {
      return RunProbeAccuracy(client, step.is_endstop, step.samples);
    }
    if (step.name == "switch_offset") return FindSwitchOffset(step, client);
    if (step.name == "change") {
      SetStation(step.change, seed_, options_.sample, twin_.station());
      twin_.Wipe(false);
      return {};
    }
    ProcedureResult result;
    for (const std::string& line : step.lines) {
      const auto answer = client->Say(line);
      if (!answer) {
        FailZOffset(answer.error(), &result);
        return result;
      }
      for (const std::string& said : *answer) result.messages.push_back(said);
    }
    return result;
  }

  ProcedureResult FindSwitchOffset(const ZOffsetStep& step, ZOffsetClient* client) {
    const double before_mm = klipper_.config().switch_offset_mm;
    ProcedureResult result = RunSwitchOffset(
        client,
        {.is_as_published = step.is_as_published,
         .in_force_mm = before_mm,
         .at_mm = klipper_.BedPoint_mm().value_or(twin_.middle_mm())},
        {.gap_mm = [&](double) { return ReadGap_mm(step.name, client); },
         .wipe =
             [&] {
               twin_.Wipe();
               return true;
             }});
    if (result.estimates.empty() || !step.applies) return result;
    const double after_mm = result.estimates.back().value;
    // Klipper does not start with one below 0.
    const bool is_taken = after_mm >= 0;
    if (is_taken) {
      klipper_.SetSwitchOffset_mm(after_mm);
      record_.SetSwitchOffset_mm(after_mm);
    } else {
      result.ending = Ending::kRefused;
    }
    result.steps.push_back(
        {.procedure = "switch_offset",
         .variant = step.is_as_published ? "as_published" : "corrected",
         .name = "switch_offset",
         .before = before_mm,
         .after = is_taken ? after_mm : before_mm,
         .verdict = is_taken ? Verdict::kApplied : Verdict::kRefused,
         .message = is_taken ? "from the gap under the nozzle"
                             : "Klipper takes none below 0"});
    return result;
  }

  std::optional<double> ReadGap_mm(const std::string& campaign, ZOffsetClient* client) {
    const auto read = ReadFeeler(klipper_, twin_, client);
    if (!read) return std::nullopt;
    record_.AddGap(campaign, klipper_.now(), *read, twin_.is_wiped());
    return read->gap_mm;
  }

  // Of the clean nozzle over the middle of the bed.
  double Error_mm() const { return ErrorAt_mm(twin_.middle_mm()); }

  // 0 where nothing was homed: no height is known then.
  double HeightError_mm() const {
    return std::isfinite(Error_mm()) ? std::abs(Error_mm()) : 0;
  }

  double ErrorAt_mm(const Eigen::Vector2d& at_mm) const {
    const auto carriage_mm = klipper_.CarriageAtNought_mm(at_mm);
    return carriage_mm ? twin_.Gap_mm(*carriage_mm, at_mm)
                       : std::numeric_limits<double>::infinity();
  }

  // The worst of 11 by 11 places within 100 mm of the middle.
  double FirstLayer_mm() const {
    constexpr int kSide = 11;
    constexpr double kReach_mm = 100;
    double worst_mm = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const Eigen::Vector2d part(column / (kSide - 1.0) - 0.5,
                                 row / (kSide - 1.0) - 0.5);
      worst_mm = std::max(
          worst_mm, std::abs(ErrorAt_mm(twin_.middle_mm() + 2 * kReach_mm * part)));
    }
    return worst_mm;
  }

  double BuiltOf(const std::string& name) const {
    const ZStation& station = twin_.station();
    if (name == "switch_offset") return twin_.Trigger_mm();
    // Of a worn switch: the deviation of a product of two uniform numbers.
    const double worn_mm = station.worn_mm * std::sqrt(1.0 / 9 - 1.0 / 16);
    return UmFromMm(name == "endstop_scatter"
                        ? std::hypot(station.endstop_scatter_mm, worn_mm)
                        : station.probe_scatter_mm);
  }

  // Beside what is built, at once: it grows.
  void AddEstimates(const std::vector<Estimate>& estimates, RunResult* result) const {
    for (const Estimate& estimate : estimates) {
      ParameterResult row{.name = estimate.name,
                          .unit = estimate.unit,
                          .injected = BuiltOf(estimate.name),
                          .recovered = estimate.value,
                          .identifiable = estimate.identifiable};
      SetUncertainty(estimate, &row);
      row.error = estimate.value - row.injected;
      result->parameters.push_back(row);
    }
  }

  void AddError(RunResult* result) const {
    result->parameters.push_back({.name = "z_offset_error",
                                  .unit = "mm",
                                  .injected = 0,
                                  .recovered = Error_mm(),
                                  .error = Error_mm(),
                                  .identifiable = true,
                                  .is_setting = true});
  }

  double FigureOf(const std::string& name, const RunResult& result) const {
    if (name == "z_offset_error_mm") return std::abs(Error_mm());
    if (name == "first_layer_error_mm") return FirstLayer_mm();
    if (name == "machine_time_s") return result.machine_time_s;
    if (name == "switch_offset_mm") return klipper_.config().switch_offset_mm;
    const auto last =
        std::find_if(result.steps.rbegin(), result.steps.rend(), [](const Step& step) {
          return step.name == "gcode_offset.z";
        });
    return last == result.steps.rend() ? std::numeric_limits<double>::quiet_NaN()
                                       : last->after;
  }

  void Judge(RunResult* result) const {
    AddError(result);
    result->messages.push_back(
        std::isfinite(Error_mm())
            ? fmt::format("commanded to 0 the clean nozzle stands {:+.4f} mm over the "
                          "print surface",
                          Error_mm())
            : "Z is not homed: no height is known of the nozzle");
    for (const auto& [name, within] : z_.figures) {
      CheckFigure(name, within, FigureOf(name, *result), result);
    }
    CheckMessages(z_.messages, result);
    result->outcome = ending_ == Ending::kNoTrigger           ? "no_trigger"
                      : ending_ != Ending::kDone              ? "refused"
                      : std::abs(Error_mm()) <= kRecovered_mm ? "recovers"
                                                              : "misses";
    CheckOutcome(z_.outcome, result);
    result->passed = std::ranges::all_of(result->checks, &CheckResult::passed);
  }

  const Scenario& scenario_;
  const ZOffsetScenario& z_;
  const RunOptions& options_;
  std::uint64_t seed_;
  Fidelity fidelity_;
  ZStationTwin twin_;
  KlipperZ klipper_;
  ZOffsetRecord record_;
  KlipperZWire wire_;
  Ending ending_ = Ending::kDone;
};

}  // namespace

RunResult RunZOffsetScenario(const Scenario& scenario, const RunOptions& options) {
  return ZOffsetRun(scenario, options).Perform();
}

}  // namespace caltwin
