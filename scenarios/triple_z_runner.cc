#include "scenarios/triple_z_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/doing.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/judging.h"
#include "scenarios/triple_z_link.h"
#include "sim/base/units.h"
#include "sim/kinds/triple_z/record.h"
#include "sim/link/transcript.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;     // Of the tilt as it was.
constexpr double kFlat_mm = 0.01;      // Less is as good as flat.
constexpr double kPublished_mm = 0.1;  // The published target of the mean error.

/// A run on its way.
class TripleZRun {
 public:
  TripleZRun(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario),
        triple_z_(*scenario.triple_z),
        options_(options),
        seed_(options.seed.value_or(scenario.seed)),
        built_(DrawTripleZ(triple_z_, scenario.machine.machine, seed_, options.sample)),
        fidelity_(options.fidelity.value_or(scenario.fidelity)),
        plant_(built_, fidelity_ == Fidelity::kPhysics, seed_, options.sample),
        firmware_(FirmwareOf(built_.machine, triple_z_.believed_mm), &plant_),
        wire_(&firmware_) {}

  RunResult Perform() {
    const std::clock_t start = std::clock();
    RunResult result{.scenario = scenario_.file.string(),
                     .about = scenario_.about,
                     .verbatim = scenario_.verbatim,
                     .machine = built_.machine.name,
                     .fidelity = ToString(fidelity_),
                     .seed = seed_,
                     .messages = scenario_.machine.notes};
    const TrueLevel was = TrueLevelOf(built_, Vec3<double>::Zero(), /*reference_mm=*/0);
    result.position_error_before_p95_mm =
        TripleZPositionP95_mm(built_, Vec3<double>::Zero());
    InterruptibleLink link(&wire_);
    std::unique_ptr<RecordingLink> recorder;
    if (!options_.transcript.empty()) {
      recorder = std::make_unique<RecordingLink>(&link, options_.transcript);
    }
    TripleZPrinter printer(
        BenchOf(built_.machine,
                recorder ? static_cast<Link*>(recorder.get()) : &link,
                triple_z_.probe_sigma_mm));
    TripleZRecord record(built_.machine, triple_z_.probe_sigma_mm);
    for (const TripleZStep& step : triple_z_.calibrate) {
      options_.progress(step.name);
      const std::size_t before = firmware_.touched().size();
      Take(step, &printer, &result);
      record.Add(step.name, std::span(firmware_.touched()).subspan(before));
      if (InterruptRequested()) result.interrupted = true;
      const bool goes_on =
          last_.ending == Ending::kDone || last_.ending == Ending::kConfounded;
      if (!goes_on || result.interrupted) break;
    }
    if (recorder) recorder->Save();
    result.header = record.header();
    result.rows = record.rows();
    result.touches = firmware_.touches();
    result.machine_time_s = firmware_.machine_time_s();
    result.lost = last_.ending == Ending::kLinkLost;
    const TrueLevel after = TrueLevelOf(built_, firmware_.raised_mm(), reference_mm_);
    result.position_error_after_p95_mm =
        TripleZPositionP95_mm(built_, firmware_.raised_mm());
    Judge(was, after, &result);
    result.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return result;
  }

 private:
  static TripleZResult Sent(const TripleZStep& step, TripleZPrinter* printer) {
    TripleZResult done;
    for (const std::string& line : step.lines) {
      const auto said = printer->bench().link->Send(line, std::chrono::minutes(10));
      if (!said) return Failed(said.error(), step, printer);
      printer->Heard(line);
      for (const std::string& text : *said) done.result.messages.push_back(text);
    }
    return done;
  }

  static TripleZResult Moved(const TripleZStep& step, TripleZPrinter* printer) {
    const auto moved =
        printer->MoveTripleZ(step.at_mm[0], step.at_mm[1], step.heights_mm);
    return moved ? TripleZResult{} : Failed(moved.error(), step, printer);
  }

  static TripleZResult Failed(const MachineFault& fault,
                              const TripleZStep& step,
                              TripleZPrinter* printer) {
    Doing doing(step.name, step.options, printer);
    doing.Fail(fault);
    return doing.Take();
  }

  static TripleZResult Do(const TripleZStep& step, TripleZPrinter* printer) {
    const TripleZOptions& o = step.options;
    if (step.name == "move_triple_z") return Moved(step, printer);
    if (step.name == "gcode") return Sent(step, printer);
    if (step.name == "plane_tilt") return RunPlaneTilt(printer, o);
    if (step.name == "rrf_levelling") return RunRrfLevelling(printer, o);
    if (step.name == "pivots_and_wiring") return RunPivotsAndWiring(printer, o);
    return RunBedTilt(printer, o);
  }

  TripleZResult RanBy(const ExternalCommand& command,
                      TripleZPrinter* printer,
                      RunResult* result) const {
    NoGauges gauges;
    NoHands hands;
    Bench bench{.link = printer->bench().link,
                .gauge = &gauges,
                .person = &hands,
                .machine = built_.machine};
    const ExternalRun run = RunExternal(command, &bench);
    printer->LoseHeights();
    TripleZResult done;
    done.result = run.result;
    if (!run.passed() && done.result.ending == Ending::kDone) {
      done.result.ending = Ending::kRefused;
    }
    result->checks.push_back({.name = "external",
                              .expected = "exited with 0",
                              .found = ToString(run.end),
                              .passed = run.passed()});
    return done;
  }

  void Take(const TripleZStep& step, TripleZPrinter* printer, RunResult* result) {
    const TripleZOptions& o = step.options;
    const std::size_t first = firmware_.touched().size();
    const TripleZResult done =
        step.external ? RanBy(*step.external, printer, result) : Do(step, printer);
    last_ = done.result;
    const bool is_grid = step.name == "plane_tilt" && !o.at_screws && !o.holds_out &&
                         last_.ending == Ending::kDone;
    if (is_grid) {
      last_.messages.push_back(TimingWords(
          o.columns, o.rows, std::span(firmware_.touched()).subspan(first)));
    }
    const bool levels = step.name.starts_with("bed_tilt") ||
                        step.name == "rrf_levelling" || step.external.has_value();
    has_levelled_ = has_levelled_ || levels;
    if (levels) reference_mm_ = o.reference_mm;
    if (done.predicted_factor) predicted_factor_ = *done.predicted_factor;
    if (done.level) validation_mm_ = done.level->mean_mm;
    if (done.hold_out) hold_out_mm_ = done.hold_out->mean_mm;
    grew_ += static_cast<int>(
        std::ranges::count_if(done.steeper, [](double times) { return times > 1; }));
    confounded_ = confounded_ || last_.ending == Ending::kConfounded;
    AddDone(last_, result);
    result->messages.insert(
        result->messages.end(), last_.messages.begin(), last_.messages.end());
    for (const Estimate& estimate : last_.estimates) {
      const auto same = [&](const Estimate& had) {
        return had.name == estimate.name;
      };
      // What was found first: later ones are of the levelled bed.
      if (std::ranges::none_of(estimates_, same)) estimates_.push_back(estimate);
    }
  }

  // The published times: 15 to 20 s for 3x3 touches, 45 to 60 s for 5x5. From touch to
  // touch, one more for the first: homing and the way there are not the grid's.
  static std::string TimingWords(int columns,
                                 int rows,
                                 std::span<const TripleZTouch> touches) {
    const auto count = static_cast<double>(touches.size());
    const double took_s =
        (touches.back().at_s - touches.front().at_s) * count / (count - 1);
    const std::string words =
        fmt::format("{}x{} touches took {:.1f} s", columns, rows, took_s);
    const bool is_3x3 = columns == 3 && rows == 3, is_5x5 = columns == 5 && rows == 5;
    if (!is_3x3 && !is_5x5) return words;
    const double least_s = is_3x3 ? 15 : 45, most_s = is_3x3 ? 20 : 60;
    return fmt::format("{}: {} the published {:g} to {:g} s",
                       words,
                       took_s < least_s   ? "sooner than"
                       : took_s <= most_s ? "as"
                                          : "later than",
                       least_s,
                       most_s);
  }

  // The built value of "cause.axis.parameter".
  double BuiltOf(const std::string& name) const {
    double value = 0;
    for (const Injected& effect : built_.effects) {
      const auto count = EffectAt(effect.effect).parameters.size();
      for (std::size_t i = 0; i < count; ++i) {
        if (ParameterName(effect.effect, effect.axis, i) == name) {
          value += effect.values[i];
        }
      }
    }
    return value;
  }

  void AddEstimates(RunResult* result) const {
    for (const Estimate& estimate : estimates_) {
      ParameterResult row{.name = estimate.name,
                          .unit = estimate.unit,
                          .injected = BuiltOf(estimate.name),
                          .identifiable = estimate.identifiable};
      if (estimate.identifiable) {
        row.recovered = estimate.value;
        SetUncertainty(estimate, &row);
        row.error = estimate.value - row.injected;
      }
      result->parameters.push_back(row);
    }
  }

  bool MeetValues(RunResult* result) const {
    bool all_met = true;
    for (const DeltaExpectedValue& expected : triple_z_.values) {
      const auto row =
          std::ranges::find(result->parameters, expected.name, &ParameterResult::name);
      if (row == result->parameters.end()) {
        result->checks.push_back({.name = expected.name,
                                  .expected = "a value",
                                  .found = "not estimated",
                                  .passed = false});
        all_met = false;
        continue;
      }
      bool passed =
          !expected.identifiable || row->identifiable == *expected.identifiable;
      if (expected.truth_within) {
        row->tolerance = expected.truth_within;
        passed =
            passed && row->error && std::abs(*row->error) <= *expected.truth_within;
      }
      row->passed = passed;
      all_met = all_met && passed;
    }
    return all_met;
  }

  double FigureOf(const std::string& name,
                  const TrueLevel& after,
                  const RunResult& result) const {
    if (name == "level_error_mm.mean") return after.mean_mm;
    if (name == "level_error_mm.max") return after.max_mm;
    if (name == "flatness_mm.rms") return after.flat_rms_mm;
    if (name == "validation_mm.mean") return validation_mm_;
    if (name == "hold_out_mm.mean") return hold_out_mm_;
    if (name == "machine_time_s") return result.machine_time_s;
    if (name == "position_error_mm.p95") return result.position_error_after_p95_mm;
    return predicted_factor_;
  }

  void AddChecks(const TrueLevel& after, RunResult* result) const {
    for (const auto& [name, within] : triple_z_.figures) {
      CheckFigure(name, within, FigureOf(name, after, *result), result);
    }
    CheckMessages(triple_z_.messages, result);
  }

  std::string OutcomeOf(bool all_met,
                        const TrueLevel& before,
                        const TrueLevel& after) const {
    if (last_.ending == Ending::kAlarm) return "alarm";
    if (last_.ending == Ending::kNoTrigger) return "no_trigger";
    if (grew_ >= 2) return "diverges";
    if (last_.ending == Ending::kRefused) return "refused";
    if (confounded_) return "confounded";
    const bool is_level =
        after.flat_rms_mm <= std::max(kRecovered * before.flat_rms_mm, kFlat_mm) &&
        after.mean_mm <= kPublished_mm;
    return all_met && (!has_levelled_ || is_level) ? "recovers" : "misses";
  }

  void Judge(const TrueLevel& before, const TrueLevel& after, RunResult* result) {
    AddEstimates(result);
    const bool all_met = MeetValues(result);
    if (!firmware_.is_homed()) {
      result->messages.push_back(
          "nothing was homed: the bed still stands at the lower endstops");
    }
    result->messages.push_back(
        fmt::format("the bed truly stands {:.4f} mm off its reference in the mean "
                    "({:.4f} at most), "
                    "{:.1f} um rms from flat; {:.1f} before",
                    after.mean_mm,
                    after.max_mm,
                    UmFromMm(after.flat_rms_mm),
                    UmFromMm(before.flat_rms_mm)));
    AddChecks(after, result);
    result->outcome = OutcomeOf(all_met, before, after);
    CheckOutcome(triple_z_.outcome, result);
    result->passed =
        !result->interrupted &&
        std::ranges::all_of(result->checks, &CheckResult::passed) &&
        std::ranges::none_of(result->parameters, [](const ParameterResult& row) {
          return row.passed == false;
        });
  }

  const Scenario& scenario_;
  const TripleZScenario& triple_z_;
  const RunOptions& options_;
  std::uint64_t seed_;
  BuiltTripleZ built_;
  Fidelity fidelity_;
  TripleZTwinPlant plant_;
  RrfTripleZ firmware_;
  RrfTripleZWire wire_;
  ProcedureResult last_{};
  std::vector<Estimate> estimates_{};
  double reference_mm_ = 0;
  double predicted_factor_ = std::numeric_limits<double>::quiet_NaN();
  double validation_mm_ = std::numeric_limits<double>::quiet_NaN();
  double hold_out_mm_ = std::numeric_limits<double>::quiet_NaN();
  int grew_ = 0;
  bool has_levelled_ = false, confounded_ = false;
};

}  // namespace

RunResult RunTripleZScenario(const Scenario& scenario, const RunOptions& options) {
  return TripleZRun(scenario, options).Perform();
}

}  // namespace caltwin
