#include "scenarios/kinds/motor_stage_trial.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace caltwin {
namespace {

constexpr double kHolds = 5;  // Standard uncertainties that an estimate may be off.

// Figures that add up over procedures.
const std::map<std::string, double>& CountsAtNought() {
  static const std::map<std::string, double> kCounts = {{"alerts", 0},
                                                        {"retries", 0},
                                                        {"warnings", 0},
                                                        {"safe_modes", 0},
                                                        {"positions_lost", 0}};
  return kCounts;
}

}  // namespace

MotorStageTrial::MotorStageTrial(const MotorStageScenario& scenario,
                                 const std::filesystem::path& file,
                                 const Chance& chance)
    : motor_(scenario),
      file_(file),
      chance_(chance),
      rig_(DrawMotorStage(motor_, chance.seed, chance.sample),
           chance.fidelity == Fidelity::kPhysics,
           chance.seed,
           chance.sample),
      factory_(MotorFirmwareOf(motor_.drawing)),
      firmware_(std::make_unique<MotorStageFirmware>(factory_, &rig_, &flash_)),
      wire_(firmware_.get()),
      gauge_(&rig_, motor_.laser_sigma_unit.value_or(0), chance.seed, chance.sample),
      figures_(CountsAtNought()) {
  bench_.gauge = &gauge_;
  bench_.person = &hands_;
}

void MotorStageTrial::Connect(Link* link) {
  bench_.link = link;
  MotorBench bench{.link = link, .drawing = motor_.drawing};
  if (motor_.laser_sigma_unit) {
    bench.gauge = &gauge_;
    bench.gauge_sigma_unit = *motor_.laser_sigma_unit;
  }
  SetFields(motor_, file_, bench_.kept.Put(MotorAxes(bench)));
}

void MotorStageTrial::EndStep(const CalibrationStep& /*step*/, ProcedureResult* done) {
  for (const auto& [name, value] : done->figures) {
    figures_[name] = value + (CountsAtNought().contains(name) ? figures_[name] : 0);
  }
  for (const Estimate& estimate : done->estimates) {
    const auto truth = BuiltOf(estimate.name, done->estimates);
    if (!truth) continue;
    std::erase_if(
        told_, [&](const ParameterResult& had) { return had.name == estimate.name; });
    told_.push_back({.name = estimate.name,
                     .unit = estimate.unit,
                     .injected = *truth,
                     .recovered = estimate.value,
                     .error = estimate.value - *truth,
                     .identifiable = true});
    SetUncertainty(estimate, &told_.back());
  }
}

// The power goes while the lines are obeyed, after so many bytes that they store, and
// comes back: what the flash holds is in force, and no axis is homed.
ProcedureResult MotorStageTrial::CutPower(const PowerCut& cut) {
  ProcedureResult done;
  Rng marks(chance_.seed, chance_.sample, "power_cut");
  const std::uint64_t before = flash_.bytes_done();
  flash_.CutAfter(cut.after_bytes, &marks);
  for (const std::string& line : cut.lines) {
    const auto answer = bench_.link->Send(line, std::chrono::milliseconds(600'000));
    if (answer) continue;
    const std::string& said = answer.error().reply;
    done.messages.push_back(MachineSaid(said));
    const bool is_cut = said.find("the power went") != std::string::npos;
    if (!is_cut) done.ending = Ending::kRefused;
    break;
  }
  done.messages.push_back(
      fmt::format("the power went, {} bytes of the flash had been written since; it "
                  "is back, and no axis is homed",
                  flash_.bytes_done() - before));
  flash_.PowerUp();
  earlier_s_ += firmware_->machine_time_s();
  MotorStageOptions again = factory_;
  again.clock_unix_s += std::llround(earlier_s_);  // A clock with a battery.
  firmware_ = std::make_unique<MotorStageFirmware>(again, &rig_, &flash_);
  wire_.Connect(firmware_.get());
  return done;
}

// The built value of an estimate, at once: homes move. nullopt: not known here.
std::optional<double> MotorStageTrial::BuiltOf(
    const std::string& name, const std::vector<Estimate>& together) const {
  const std::size_t dot = name.find('.');
  const auto axis = MotorAxisNamed(name.substr(dot + 1));
  if (!axis) return std::nullopt;
  const BuiltMotorStage& built = rig_.built();
  const MotorAxisDrawing& d = built.motors[*axis].drawing;
  const std::string what = name.substr(0, dot);
  if (what == "backlash") return built.motors[*axis].gap_unit;
  if (what == "home_offset") return TrueHome(*firmware_, rig_, *axis);
  if (what == "travel") {
    return d.max_switch_unit - d.min_switch_unit - TrueHome(*firmware_, rig_, *axis);
  }
  if (what != "start_lead") return std::nullopt;
  double latest_s = 0;
  for (const Estimate& other : together) {
    const auto named = MotorAxisNamed(other.name.substr(other.name.find('.') + 1));
    latest_s = std::max(latest_s, built.faults[*named].start_delay_s);
  }
  return latest_s - built.faults[*axis].start_delay_s;
}

void MotorStageTrial::Finish(RunResult* result) {
  const auto history = bench_.link->Send("M504", std::chrono::milliseconds(1000));
  if (history) history_ = history->size();
  result->machine_time_s = earlier_s_ + firmware_->machine_time_s();
}

void MotorStageTrial::AddParameters(const Expectation& /*expect*/,
                                    const std::vector<ProcedureResult>& /*results*/,
                                    RunResult* result) {
  result->parameters = told_;
}

TrueEnd MotorStageTrial::End(const std::vector<ProcedureResult>& /*results*/,
                             RunResult* result) {
  const bool hold =
      std::ranges::all_of(result->parameters, [](const ParameterResult& row) {
        const double allowed =
            std::max(kHolds * row.sd.value_or(0), row.tolerance.value_or(0));
        return std::abs(*row.error) <= allowed;
      });
  return {.told_wrong = !hold};
}

double MotorStageTrial::Figure(const std::string& name, const RunResult& /*result*/) {
  if (name == "history_entries") return static_cast<double>(history_);
  if (const auto found = figures_.find(name); found != figures_.end()) {
    return found->second;
  }
  const auto axis = MotorAxisNamed(name.substr(name.find('.') + 1));
  if (axis && name.starts_with("home.")) return TrueHome(*firmware_, rig_, *axis);
  if (axis) {
    const AxisCalibration& record = firmware_->record(*axis);
    return record.backlash_pulses / record.pulses_per_unit;
  }
  return name == "index_edges" ? -1 : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace caltwin
