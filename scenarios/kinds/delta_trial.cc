#include "scenarios/kinds/delta_trial.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/procedures.h"
#include "calibration/kinds/delta/setting_names.h"
#include "scenarios/kinds/delta_g33.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

void AddStep(const DeltaStep& step,
             const std::string& name,
             double was,
             double is,
             ProcedureResult* done) {
  done->steps.push_back({.procedure = step.name,
                         .variant = step.variant,
                         .name = name,
                         .before = was,
                         .after = is,
                         .verdict = Verdict::kApplied});
}

}  // namespace

DeltaTrial::DeltaTrial(const DeltaScenario& scenario,
                       const Machine& machine,
                       const Chance& chance)
    : delta_(scenario),
      machine_(machine),
      built_(DrawDelta(delta_, machine_, chance.seed, chance.sample)),
      twin_(std::make_unique<DeltaTwin>(
          DeltaTwinConfig{.machine = machine_,
                          .built = built_,
                          .settings = delta_.settings,
                          .calliper_sigma_mm = delta_.calliper_sigma_mm,
                          .fidelity = chance.fidelity,
                          .seed = chance.seed,
                          .sample = chance.sample})),
      truth_{.machine = machine_, .built = built_} {
  twin_->SetG33(MarlinG33(G33Variant::kCorrected, DeltaOf(machine_).print_radius_mm));
  truth_.before = twin_->marlin().settings();
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = machine_;
}

void DeltaTrial::Connect(Link* link) {
  bench_.link = link;
  const Vec3<double>& offset_mm = delta_.probe_offset_mm;
  if (offset_mm.isZero(0)) return;
  DeltaLinkProbe(link, DeltaOf(machine_).model, twin_->marlin().settings())
      .Say(fmt::format(
          "M851 X{:.2f} Y{:.2f} Z{:.3f}", offset_mm[0], offset_mm[1], offset_mm[2]));
}

void DeltaTrial::BeginStep(const CalibrationStep& step) {
  twin_->BeginRecord(step.name);
}

void DeltaTrial::EndStep(const CalibrationStep& /*step*/, ProcedureResult* /*done*/) {
  if (std::exchange(is_first_, false)) {
    truth_.after_first = twin_->marlin().settings();
  }
}

// An engine at this end of the wire, and what it sets.
void DeltaTrial::PerformHere(const DeltaStep& step,
                             DeltaLinkProbe* probe,
                             ProcedureResult* done) {
  const DeltaDoors doors{.probe = probe->AsProbe(), .calliper = CalliperOf(&*twin_)};
  DeltaOutcome outcome = PerformDeltaStep(step,
                                          delta_.probe_sigma_mm,
                                          machine_,
                                          doors,
                                          twin_->marlin().settings(),
                                          &truth_.fit);
  if (!probe->fault()) {
    probe->Set(outcome.settings);
    if (outcome.mesh.nodes > 0) probe->Set(outcome.mesh);
    probe->Say("M500");
  }
  truth_.said_mm = outcome.said_mm;
  truth_.settings_told = outcome.estimates;
  truth_.correlations = outcome.correlations;
  truth_.tilt_x = outcome.tilt_x;
  truth_.tilt_y = outcome.tilt_y;
  done->messages = std::move(outcome.messages);
}

ProcedureResult DeltaTrial::Take(const DeltaStep& step) {
  ProcedureResult done;
  // What an earlier step knew is no uncertainty of this one's.
  truth_.settings_told.clear();
  truth_.correlations.clear();
  truth_.tilt_x = truth_.tilt_y = 0;
  truth_.fit.reset();
  const DeltaModel<double> before = twin_->marlin().settings();
  DeltaLinkProbe probe(bench_.link, DeltaOf(machine_).model, before);
  if (step.name == "g33") {
    twin_->SetG33(MarlinG33(VariantOf(step), DeltaOf(machine_).print_radius_mm));
    if (const auto blind = BlindnessOfG33(step.points)) {
      done.observability.push_back(*blind);
    }
    done.messages = probe.Say(fmt::format("G33 P{}{}", step.points, step.words));
    truth_.said_mm = twin_->said_mm();
  } else {
    PerformHere(step, &probe, &done);
  }
  if (probe.fault()) {
    // The machine stopped in the middle of it, whatever it calls that.
    done.fault = *probe.fault();
    done.ending = probe.fault_itself()->kind == MachineFault::Kind::kLinkLost
                      ? Ending::kLinkLost
                      : Ending::kAlarm;
  } else if (probe.was_out_of_reach()) {
    done.ending = Ending::kNoTrigger;
  }
  AddSteps(step, before, &done);
  return done;
}

void DeltaTrial::AddSteps(const DeltaStep& step,
                          const DeltaModel<double>& before,
                          ProcedureResult* done) const {
  const DeltaModel<double>& drawn = DeltaOf(machine_).model;
  for (const char* name : kDeltaSettingNames) {
    const double was = *DeltaSettingNamed(before, drawn, name);
    const double is = *DeltaSettingNamed(twin_->marlin().settings(), drawn, name);
    if (was != is) AddStep(step, name, was, is, done);
  }
  AddTrims(step, before, done);
}

// What M665 A B C and Z set beside the mean rod and the angles of towers a and b.
void DeltaTrial::AddTrims(const DeltaStep& step,
                          const DeltaModel<double>& before,
                          ProcedureResult* done) const {
  const DeltaModel<double>& after = twin_->marlin().settings();
  constexpr double kRounding = 1e-9;
  const auto add = [&](const std::string& name, double was, double is) {
    if (std::abs(is - was) > kRounding) AddStep(step, name, was, is, done);
  };
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    add(fmt::format("arm_length.{}", "abc"[i]),
        before.arm_mm[i] - MeanOfTowers(before.arm_mm),
        after.arm_mm[i] - MeanOfTowers(after.arm_mm));
  }
  const double drawn_rad = DeltaOf(machine_).model.angle_rad[2];
  add("tower_angle.c",
      DegFromRad(before.angle_rad[2] - drawn_rad),
      DegFromRad(after.angle_rad[2] - drawn_rad));
}

void DeltaTrial::Finish(RunResult* result) {
  result->touches = twin_->touches();
  result->machine_time_s = twin_->machine_time_s();
  result->header = twin_->record().header;
  result->rows = twin_->record().rows;
  truth_.after = twin_->marlin().settings();
  truth_.mesh = twin_->marlin().mesh();
  result->position_error_before_p95_mm = DeltaPositionP95_mm(truth_, truth_.before, {});
  result->position_error_after_p95_mm =
      DeltaPositionP95_mm(truth_, truth_.after, truth_.mesh);
}

void DeltaTrial::AddParameters(const Expectation& /*expect*/,
                               const std::vector<ProcedureResult>& /*results*/,
                               RunResult* result) {
  AddDeltaTable(truth_, result);
}

TrueEnd DeltaTrial::End(const std::vector<ProcedureResult>& /*results*/,
                        RunResult* result) {
  return EndOfDelta(truth_, result);
}

double DeltaTrial::Figure(const std::string& name, const RunResult& result) {
  return FigureOfDelta(truth_, name, result);
}

}  // namespace caltwin
