#include "scenarios/kinds/gantry_trial.h"

#include <algorithm>

#include "scenarios/parameter_name.h"
#include "scenarios/position_error.h"
#include "scenarios/record.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr int kPoses = 1000;

// What a program that reports no steps of its own has changed.
std::vector<Step> ChangesBetween(const MachineKind* kind,
                                 const Settings& before,
                                 const Settings& after) {
  std::vector<Step> steps;
  for (const std::string& name : SettingNames(kind)) {
    const double was = *SettingNamed(before, name);
    const double is = *SettingNamed(after, name);
    if (was == is) continue;
    steps.push_back({.procedure = "external",
                     .name = name,
                     .before = was,
                     .after = is,
                     .verdict = Verdict::kApplied,
                     .message = "set by the external program"});
  }
  return steps;
}

}  // namespace

TwinConfig MakeTwinConfig(const Scenario& scenario, const RunOptions& options) {
  const Chance chance = ChanceOf(scenario, options);
  const Machine& drawing = scenario.machine.machine;
  return {.machine = DrawBuilt(drawing, scenario.varied, chance.seed, chance.sample),
          .effects = DrawEffects(scenario.effects, chance.seed, chance.sample),
          .settings = DrawSettings(
              drawing.settings, scenario.settings, chance.seed, chance.sample),
          .artefacts = DrawArtefacts(
              scenario.artefacts, scenario.varied, chance.seed, chance.sample),
          .instruments = DrawInstruments(
              scenario.instruments, scenario.varied, chance.seed, chance.sample),
          .fidelity = chance.fidelity,
          .firmware = scenario.firmware,
          .seed = chance.seed,
          .sample = chance.sample};
}

Built BuiltUnderController(const TwinConfig& config) {
  const auto probe = config.instruments.find("probe");
  Built built{.machine = config.machine,
              .effects = config.effects,
              .probe_sigma_mm = probe == config.instruments.end()
                                    ? 0
                                    : MmFromUm(probe->second.sigma_um)};
  built.machine.settings = config.settings;
  built.Prepare();
  return built;
}

double PositionErrorP95_mm(const Twin& twin) {
  // The poses belong to the machine's travel and not to the run's chance, so that any
  // two runs are compared at the same places.
  Rng rng(1, 0, "position_error_mm");
  std::vector<Vec3<double>> errors_mm;
  for (int pose = 0; pose < kPoses; ++pose) {
    Vec3<double> q_mm;
    for (const Axis axis : kAxes) {
      const AxisDrawing& drawing = twin.config().machine.axis(axis);
      q_mm[Index(axis)] = drawing.min_mm + drawing.travel_mm() * rng.Uniform();
    }
    for (const double sense : {1.0, -1.0}) {
      errors_mm.push_back(twin.PositionError_mm(q_mm, Vec3<double>::Constant(sense)));
    }
  }
  return P95AboutMean_mm(errors_mm);
}

GantryTrial::GantryTrial(const Scenario& scenario, const Chance& chance)
    : twin_(MakeTwinConfig(scenario,
                           {.fidelity = chance.fidelity,
                            .seed = chance.seed,
                            .sample = chance.sample})) {
  constexpr std::size_t kUsualRows = 1024;
  rows_.rows.reserve(kUsualRows);
  bench_.gauge = &twin_.gauge();
  bench_.person = &twin_.person();
  bench_.machine = scenario.machine.machine;
  bench_.artefacts = scenario.artefacts;
  bench_.instruments = twin_.config().instruments;
  bench_.record = &rows_;
}

void GantryTrial::Before(RunResult* result) {
  result->settings_before = twin_.settings();
  result->position_error_before_p95_mm = PositionErrorP95_mm(twin_);
}

void GantryTrial::BeginStep(const CalibrationStep& /*step*/) {
  before_step_ = twin_.settings();
}

void GantryTrial::EndExternal(ProcedureResult* done) {
  done->steps = ChangesBetween(bench_.machine.kind, before_step_, twin_.settings());
  for (const Estimate& estimate : done->estimates) {
    if (SettingNamed(before_step_, estimate.name)) continue;  // Told by its change.
    done->steps.push_back({.procedure = "external",
                           .name = estimate.name,
                           .before = estimate.value,
                           .after = estimate.value,
                           .verdict = Verdict::kMeasured,
                           .message = "handed in by the external program"});
  }
}

void GantryTrial::Finish(RunResult* result) {
  result->header = HeaderOfRun(bench_);
  result->rows = std::move(rows_);
  result->settings_after = twin_.settings();
  result->position_error_after_p95_mm = PositionErrorP95_mm(twin_);
  result->machine_time_s = twin_.machine_time_s();
  result->touches = twin_.touches();
}

GantryTruth GantryTrial::TruthFor(const RunResult& result,
                                  const std::vector<ProcedureResult>& results) const {
  return {.machine = &twin_.config().machine,
          .effects = &twin_.config().effects,
          .before = result.settings_before,
          .after = result.settings_after,
          .results = results,
          .position_error_before_mm = result.position_error_before_p95_mm,
          .position_error_after_mm = result.position_error_after_p95_mm};
}

void GantryTrial::AddParameters(const Expectation& expect,
                                const std::vector<ProcedureResult>& results,
                                RunResult* result) {
  result->parameters = MakeTable(TruthFor(*result, results), expect);
}

TrueEnd GantryTrial::End(const std::vector<ProcedureResult>& results,
                         RunResult* result) {
  // What a plan could not tell is settled where a later reading has told it.
  std::erase_if(result->observability, [&](const Observability& blind) {
    return std::ranges::all_of(blind.blind_direction, [&](const auto& part) {
      const auto row =
          std::ranges::find(result->parameters, part.first, &ParameterResult::name);
      return row == result->parameters.end() || row->identifiable;
    });
  });
  return EndOfGantry(TruthFor(*result, results), result->parameters);
}

double GantryTrial::Figure(const std::string& /*name*/, const RunResult& result) {
  return result.position_error_after_p95_mm;
}

}  // namespace caltwin
