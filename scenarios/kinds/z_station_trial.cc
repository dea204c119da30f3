#include "scenarios/kinds/z_station_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kRecovered_mm = 0.01;
// Growth of the nozzle's height that touches and their scatter explain.
constexpr double kNoise_mm = 0.01;

}  // namespace

ZStationTrial::ZStationTrial(const ZStationScenario& scenario,
                             const Machine& machine,
                             const Chance& chance)
    : z_(scenario),
      chance_(chance),
      twin_(Drawn(),
            chance.fidelity == Fidelity::kPhysics,
            chance.seed,
            chance.sample,
            z_.settings.middle_mm),
      klipper_(z_.settings, &twin_),
      record_(z_.settings,
              std::max(twin_.station()->endstop_scatter_mm,
                       twin_.station()->probe_scatter_mm)),
      wire_(&klipper_) {
  bench_.machine = machine;
}

void ZStationTrial::Connect(Link* link) {
  client_.emplace(link,
                  ZStationClient::Macros{
                      .before_switch_gcode = klipper_.config().before_switch_gcode,
                      .end_gcode = klipper_.config().end_gcode});
  hands_.emplace(&klipper_, &twin_, &*client_);
  bench_.link = &*hands_;
  bench_.gauge = &*hands_;
  bench_.person = &*hands_;
  const FeelerHands hands{
      .gap_mm = [this](double) { return ReadGap_mm("switch_offset"); },
      .wipe =
          [this] {
            twin_.Wipe();
            return true;
          }};
  // Klipper does not start with a switch_offset below 0.
  const auto write = [this](double switch_offset_mm) {
    if (switch_offset_mm < 0) return false;
    klipper_.SetSwitchOffset_mm(switch_offset_mm);
    record_.SetSwitchOffset_mm(switch_offset_mm);
    return true;
  };
  desk_ = bench_.kept.Put(
      ZStationDesk{.client = &*client_, .hands = hands, .write = write});
}

void ZStationTrial::BeginStep(const CalibrationStep& step) {
  // As homing alone leaves it.
  const bool calibrates = step.name == "z_calibration" || step.name == "switch_offset";
  if (calibrates && !has_stepped_) before_mm_ = HeightError_mm();
  touched_before_ = klipper_.touched().size();
  desk_->switch_offset_mm = klipper_.config().switch_offset_mm;
  desk_->bed_at_mm = klipper_.BedPoint_mm().value_or(twin_.middle_mm());
}

void ZStationTrial::EndStep(const CalibrationStep& step, ProcedureResult* done) {
  has_stepped_ = has_stepped_ || !done->steps.empty();
  record_.AddTouches(step.name,
                     std::span(klipper_.touched()).subspan(touched_before_),
                     twin_.is_wiped());
  for (const Estimate& estimate : done->estimates) {
    ParameterResult row{.name = estimate.name,
                        .unit = estimate.unit,
                        .injected = BuiltOf(estimate.name),
                        .recovered = estimate.value,
                        .identifiable = estimate.identifiable};
    SetUncertainty(estimate, &row);
    row.error = estimate.value - row.injected;
    told_.push_back(row);
  }
}

void ZStationTrial::Finish(RunResult* result) {
  if (client_->is_spoilt()) {
    result->messages.push_back(
        "Z was homed after CALIBRATE_Z: its offset no longer holds, calibrate again");
  }
  result->header = record_.header();
  result->rows = record_.rows();
  result->touches = klipper_.touches();
  result->machine_time_s = klipper_.machine_time_s();
  result->position_error_after_p95_mm = HeightError_mm();
  result->position_error_before_p95_mm = before_mm_.value_or(HeightError_mm());
  result->is_error_of_nozzle = true;
}

void ZStationTrial::Change(const std::vector<StationSpec>& change) {
  SetStation(change, chance_.seed, chance_.sample, twin_.station());
  twin_.Wipe(false);
}

ZStation ZStationTrial::Drawn() const {
  ZStation station;
  SetStation(z_.station, chance_.seed, chance_.sample, &station);
  return station;
}

std::optional<double> ZStationTrial::ReadGap_mm(const std::string& campaign) {
  const auto read = ReadFeeler(klipper_, twin_, &*client_);
  if (!read) return std::nullopt;
  record_.AddGap(campaign, klipper_.now(), *read, twin_.is_wiped());
  return read->gap_mm;
}

// 0 where nothing was homed: no height is known then.
double ZStationTrial::HeightError_mm() const {
  return std::isfinite(Error_mm()) ? std::abs(Error_mm()) : 0;
}

// Of the clean nozzle.
double ZStationTrial::ErrorAt_mm(const Eigen::Vector2d& at_mm) const {
  const auto carriage_mm = klipper_.CarriageAtNought_mm(at_mm);
  return carriage_mm ? twin_.Gap_mm(*carriage_mm, at_mm)
                     : std::numeric_limits<double>::infinity();
}

// The worst of 11 by 11 places within 100 mm of the middle.
double ZStationTrial::FirstLayer_mm() const {
  constexpr int kSide = 11;
  constexpr double kReach_mm = 100;
  double worst_mm = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int column = i % kSide, row = i / kSide;
    const Eigen::Vector2d part(column / (kSide - 1.0) - 0.5, row / (kSide - 1.0) - 0.5);
    worst_mm = std::max(worst_mm,
                        std::abs(ErrorAt_mm(twin_.middle_mm() + 2 * kReach_mm * part)));
  }
  return worst_mm;
}

double ZStationTrial::BuiltOf(const std::string& name) const {
  const ZStation& station = twin_.station();
  if (name == "switch_offset") return twin_.Trigger_mm();
  // Of a worn switch: the deviation of a product of two uniform numbers.
  const double worn_mm = station.worn_mm * std::sqrt(1.0 / 9 - 1.0 / 16);
  return UmFromMm(name == "endstop_scatter"
                      ? std::hypot(station.endstop_scatter_mm, worn_mm)
                      : station.probe_scatter_mm);
}

void ZStationTrial::AddParameters(const Expectation& /*expect*/,
                                  const std::vector<ProcedureResult>& /*results*/,
                                  RunResult* result) {
  result->parameters = told_;
  ParameterResult row{.name = "z_offset_error", .unit = "mm", .is_setting = true};
  row.identifiable = std::isfinite(Error_mm());  // Else nothing was homed.
  if (row.identifiable) row.recovered = row.error = Error_mm();
  result->parameters.push_back(row);
}

TrueEnd ZStationTrial::End(const std::vector<ProcedureResult>& /*results*/,
                           RunResult* result) {
  result->messages.push_back(
      std::isfinite(Error_mm())
          ? fmt::format("commanded to 0 the clean nozzle stands {:+.4f} mm over the "
                        "print surface",
                        Error_mm())
          : "Z is not homed: no height is known of the nozzle");
  TrueFigure figure{.before = before_mm_.value_or(std::abs(Error_mm())),
                    .after = std::abs(Error_mm()),
                    .noise = kNoise_mm,
                    .is_met = std::abs(Error_mm()) <= kRecovered_mm};
  // Nothing to compare with: only homing, or not even that.
  if (!has_stepped_ || !std::isfinite(figure.after)) figure.before = figure.after;
  return {.figure = figure};
}

double ZStationTrial::Figure(const std::string& name, const RunResult& result) {
  if (name == "z_offset_error_mm") return std::abs(Error_mm());
  if (name == "first_layer_error_mm") return FirstLayer_mm();
  if (name == "switch_offset_mm") return klipper_.config().switch_offset_mm;
  const auto last =
      std::find_if(result.steps.rbegin(), result.steps.rend(), [](const Step& step) {
        return step.name == "gcode_offset.z";
      });
  return last == result.steps.rend() ? std::numeric_limits<double>::quiet_NaN()
                                     : last->after;
}

}  // namespace caltwin
