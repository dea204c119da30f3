#include "scenarios/kinds/delta_trial.h"

#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/delta/calibrate.h"
#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/procedures.h"
#include "scenarios/kinds/delta_g33.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

bool IsProcedure(const CalibrationStep& step) {
  return FindProcedure(step.name, ProceduresOf("delta")) != nullptr;
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
  truth_.said_mm = 0;
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = machine_;
}

void DeltaTrial::Connect(Link* link) {
  bench_.link = link;
  bench_.kept.Put(DeltaBench{.calliper = CalliperOf(&*twin_),
                             .probe_sigma_mm = delta_.probe_sigma_mm,
                             .believed =
                                 [this] {
                                   return BelievedDelta{
                                       twin_->marlin().settings(),
                                       twin_->marlin().probe_offset_mm()};
                                 },
                             .fit = &truth_.fit});
  const Vec3<double>& offset_mm = delta_.probe_offset_mm;
  if (offset_mm.isZero(0)) return;
  DeltaLinkProbe(link, DeltaOf(machine_).model, twin_->marlin().settings())
      .Say(fmt::format(
          "M851 X{:.2f} Y{:.2f} Z{:.3f}", offset_mm[0], offset_mm[1], offset_mm[2]));
}

void DeltaTrial::BeginStep(const CalibrationStep& step) {
  twin_->BeginRecord(step.name);
  if (step.name == "g33") {
    twin_->SetG33(
        MarlinG33(VariantOf(step.variant), DeltaOf(machine_).print_radius_mm));
  }
  if (IsProcedure(step)) truth_.fit.reset();
}

void DeltaTrial::EndStep(const CalibrationStep& step, ProcedureResult* done) {
  if (std::exchange(is_first_, false)) {
    truth_.after_first = twin_->marlin().settings();
  }
  if (!IsProcedure(step)) return;
  // What an earlier step knew is no uncertainty of this one's.
  const auto figure = [&](const char* name) {
    const auto found = done->figures.find(name);
    return found == done->figures.end() ? 0 : found->second;
  };
  truth_.said_mm = step.name == "g33" ? twin_->said_mm() : figure("said_mm");
  truth_.tilt_x = figure("tilt_x");
  truth_.tilt_y = figure("tilt_y");
  truth_.correlations = done->correlations;
  truth_.settings_told.clear();
  // What a joint estimate found of them is in its fit.
  if (!truth_.fit) truth_.settings_told = done->estimates;
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
