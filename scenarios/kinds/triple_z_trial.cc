#include "scenarios/kinds/triple_z_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;     // Of the tilt as it was.
constexpr double kFlat_mm = 0.01;      // Less is as good as flat.
constexpr double kPublished_mm = 0.1;  // The published target of the mean error.

// The published times: 15 to 20 s for 3x3 touches, 45 to 60 s for 5x5. From touch to
// touch, one more for the first: homing and the way there are not the grid's.
std::string TimingWords(int columns, int rows, std::span<const ProbedPoint> touches) {
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

FirmwareOptions FirmwareOf(const TripleZScenario& scenario) {
  FirmwareOptions options = FirmwareOnScrews(scenario.believed_mm);
  options.probe = scenario.probe;
  options.still_alone = scenario.still_alone;
  return options;
}

}  // namespace

Expected<std::vector<std::string>> HeardByPrinter::Send(
    std::string_view line, std::chrono::milliseconds patience) {
  auto said = link_->Send(line, patience);
  if (said) printer_->Heard(std::string(line));
  return said;
}

TripleZTrial::TripleZTrial(const TripleZScenario& scenario,
                           const Machine& machine,
                           const Chance& chance)
    : triple_z_(scenario),
      built_(DrawTripleZ(triple_z_, machine, chance.seed, chance.sample)),
      plant_(built_, chance.fidelity == Fidelity::kPhysics, chance.seed, chance.sample),
      firmware_(
          built_.machine, built_.machine.settings, FirmwareOf(triple_z_), &plant_),
      wire_(&firmware_),
      record_(built_.machine, triple_z_.probe_sigma_mm) {
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = built_.machine;
}

void TripleZTrial::Connect(Link* link) {
  printer_ = bench_.kept.Put(
      TripleZPrinter(BenchOf(built_.machine, link, triple_z_.probe_sigma_mm)));
  heard_.emplace(link, printer_);
  bench_.link = &*heard_;
}

void TripleZTrial::Before(RunResult* result) {
  was_ = TrueLevelOf(built_, Vec3<double>::Zero(), /*reference_mm=*/0);
  result->position_error_before_p95_mm =
      TripleZPositionP95_mm(built_, Vec3<double>::Zero());
}

void TripleZTrial::BeginStep(const CalibrationStep& /*step*/) {
  touched_before_ = firmware_.probed().size();
}

void TripleZTrial::EndStep(const CalibrationStep& step, ProcedureResult* done) {
  const auto touches = std::span(firmware_.probed()).subspan(touched_before_);
  record_.Add(step.name, touches);
  for (const auto& [name, value] : done->figures) figures_[name] = value;
  if (done->figures.contains("reference_mm")) has_levelled_ = true;
  if (done->figures.contains("rounds_steeper")) {
    grew_ += static_cast<int>(done->figures.at("rounds_steeper"));
  }
  if (done->figures.contains("grid.columns")) {
    done->messages.push_back(TimingWords(static_cast<int>(figures_["grid.columns"]),
                                         static_cast<int>(figures_["grid.rows"]),
                                         touches));
  }
  for (const Estimate& estimate : done->estimates) {
    const auto same = [&](const Estimate& had) {
      return had.name == estimate.name;
    };
    // What was found first: later ones are of the levelled bed.
    if (std::ranges::none_of(estimates_, same)) estimates_.push_back(estimate);
  }
}

void TripleZTrial::EndExternal(ProcedureResult* /*done*/) {
  printer_->LoseHeights();
  has_levelled_ = true;
  figures_["reference_mm"] = 0;
}

void TripleZTrial::Finish(RunResult* result) {
  result->header = record_.header();
  result->rows = record_.rows();
  result->touches = static_cast<int>(firmware_.probed().size());
  result->machine_time_s = firmware_.machine_time_s();
  result->position_error_after_p95_mm =
      TripleZPositionP95_mm(built_, firmware_.raised_mm());
}

// The built value of "cause.axis.parameter".
double TripleZTrial::BuiltOf(const std::string& name) const {
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

void TripleZTrial::AddParameters(const Expectation& /*expect*/,
                                 const std::vector<ProcedureResult>& /*results*/,
                                 RunResult* result) {
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

// The tilt is what a bed is levelled for; its height only where something levelled.
TrueEnd TripleZTrial::End(const std::vector<ProcedureResult>& /*results*/,
                          RunResult* result) {
  const TrueLevel after = LevelNow();
  if (!firmware_.is_homed(Axis::kZ)) {
    result->messages.push_back(
        "Z is not homed: its firmware does not know where the bed stands");
  }
  result->messages.push_back(
      fmt::format("the bed truly stands {:.4f} mm off its reference in the mean "
                  "({:.4f} at most), {:.1f} um rms from flat; {:.1f} before",
                  after.mean_mm,
                  after.max_mm,
                  UmFromMm(after.flat_rms_mm),
                  UmFromMm(was_.flat_rms_mm)));
  const bool is_level =
      after.flat_rms_mm <= std::max(kRecovered * was_.flat_rms_mm, kFlat_mm) &&
      after.mean_mm <= kPublished_mm;
  return {.figure = TrueFigure{.before = was_.flat_rms_mm,
                               .after = after.flat_rms_mm,
                               .noise = kFlat_mm,
                               .is_met = !has_levelled_ || is_level},
          .grew_twice = grew_ >= 2};
}

TrueLevel TripleZTrial::LevelNow() const {
  const auto reference = figures_.find("reference_mm");
  return TrueLevelOf(built_,
                     firmware_.raised_mm(),
                     reference == figures_.end() ? 0 : reference->second);
}

double TripleZTrial::Figure(const std::string& name, const RunResult& result) {
  const TrueLevel after = LevelNow();
  if (name == "level_error_mm.mean") return after.mean_mm;
  if (name == "level_error_mm.max") return after.max_mm;
  if (name == "flatness_mm.rms") return after.flat_rms_mm;
  if (name == "position_error_mm.p95") return result.position_error_after_p95_mm;
  const auto found = figures_.find(name);
  return found == figures_.end() ? std::numeric_limits<double>::quiet_NaN()
                                 : found->second;
}

}  // namespace caltwin
