#include "calibration/procedures/joint_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/profile.h"
#include "calibration/procedures/joint_uncertainty.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Changed by a joint estimate, with what stood there before.
struct Change {
  Proposal proposal{};
  double before = 0;
};

// Off while the campaign runs, back on afterwards, whatever came of it.
Expected<void> MeasureWithoutCompensation(Session* session, const JointOptions& o) {
  const Settings kept = session->believed();
  for (const Axis axis : kAxes) {
    if (ValueOf(kept, Setting::kBacklash, axis) == 0) continue;
    const auto off = session->controller().WriteBacklash(axis, 0);
    if (!off) return off;
  }
  auto measured = MeasureJointCampaign(session, o);
  for (const Axis axis : kAxes) {
    const double gap_mm = ValueOf(kept, Setting::kBacklash, axis);
    if (gap_mm == 0.0) continue;
    const auto on = session->controller().WriteBacklash(axis, gap_mm);
    if (!on && measured) measured = on;
  }
  return measured;
}

// What the joint estimate says of the settings of one axis, where it says anything.
std::vector<Change> ChangesOf(Session* session, const JointFit& fit, Axis axis) {
  std::vector<Change> changes;
  for (const Setting setting :
       {Setting::kStepsPerMm, Setting::kBacklash, Setting::kDeflection}) {
    const JointEstimate* found = fit.Find(NameOf(setting, axis));
    if (found == nullptr || !found->identifiable) continue;
    Change& change = changes.emplace_back();
    change.before = session->Believed(setting, axis);
    change.proposal.setting = setting;
    change.proposal.axis = axis;
    change.proposal.sd = found->sd;
    // Noise may read a gap below none; no firmware takes that.
    const bool is_gap = setting == Setting::kBacklash;
    change.proposal.after = is_gap ? std::max(0.0, found->value) : found->value;
    change.proposal.why =
        fmt::format("Joint estimate, sd {:.2g} {}.", found->sd, found->unit);
  }
  return changes;
}

// Error of one size with all that is believed taken into account.
Expected<double> SpanError_mm(Session* session, Axis axis, const JointOptions& o) {
  Artefact* block =
      FindArtefact(&session->bench(), o.artefact, {ArtefactType::kBlock123}, o.place);
  double error_mm = 0;
  double first_mm = 0;
  for (const double size_mm : {o.sizes_mm.front(), o.sizes_mm.back()}) {
    if (const auto laid = LayBlock(session, block, axis, size_mm); !laid) {
      return tl::unexpected(laid.error());
    }
    const auto span = MeasureSpan(session,
                                  *block,
                                  {.axis = axis,
                                   .repeats = o.repeats,
                                   .campaign = "joint_check." + Name(axis),
                                   .place = o.place});
    if (!span) return tl::unexpected(span.error());
    const double off_mm =
        span->error_mm() + 2 * session->Believed(Setting::kDeflection, axis);
    // Heights have no datum: the smaller one is it.
    if (span->is_height && size_mm == o.sizes_mm.front()) first_mm = off_mm;
    error_mm = std::max(error_mm, std::abs(off_mm - first_mm));
  }
  return error_mm;
}

Expected<bool> ApplyAxis(Session* session,
                         const JointFit& fit,
                         Axis axis,
                         const JointOptions& o) {
  double error_before_mm = 0;
  if (o.verify) {
    const auto error_mm = SpanError_mm(session, axis, o);
    if (!error_mm) return tl::unexpected(error_mm.error());
    error_before_mm = *error_mm;
  }
  std::vector<Change> done;
  for (const Change& change : ChangesOf(session, fit, axis)) {
    const auto applied = session->Apply(change.proposal);
    if (!applied) return tl::unexpected(applied.error());
    if (*applied) done.push_back(change);
  }
  if (done.empty() || !o.verify) return !done.empty();
  const auto error_mm = SpanError_mm(session, axis, o);
  if (!error_mm) return tl::unexpected(error_mm.error());
  constexpr double kSame_mm = 0.001;
  session->Tell(fmt::format("{}: sizes are off by {:.4f} mm at most, before {:.4f} mm.",
                            Letter(axis),
                            *error_mm,
                            error_before_mm));
  if (*error_mm <= error_before_mm + kSame_mm || !session->rules().roll_back) {
    return true;
  }
  std::ranges::reverse(done);
  for (const Change& change : done) {
    const auto back = session->RollBack(change.proposal, change.before, "");
    if (!back) return tl::unexpected(back.error());
  }
  return false;
}

void PrintProfiles(Session* session, const JointProblem& problem, const JointFit& fit) {
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const JointEstimate& estimate = fit.estimates[i];
    if (!estimate.identifiable) continue;
    const ProfileInterval interval = ProfileJoint(problem, fit, i);
    session->Tell(fmt::format(
        "{}: 95 % by profile likelihood {:+.3g} .. {:+.3g} {} about {:.6g}, by 1.96 sd "
        "+-{:.3g}{}.",
        estimate.name,
        interval.low - estimate.value,
        interval.high - estimate.value,
        estimate.unit,
        estimate.value,
        1.96 * estimate.sd,
        interval.is_closed ? "" : "; open beyond 20 sd"));
  }
}

void Print(Session* session, const JointProblem& problem, const JointFit& fit) {
  session->Tell(
      fmt::format("{} readings, {} unknowns: residuals {:.2f} um rms, chi2 per "
                  "dof {:.2f}.",
                  problem.observations.size(),
                  fit.estimates.size(),
                  UmFromMm(fit.rms_mm),
                  fit.chi2_per_dof));
  const HoldOutError held_out = HoldOut(problem);
  if (held_out.predicted > 0) {
    session->Tell(
        fmt::format("Faces left out of the fit are predicted to {:.2f} um rms "
                    "({} readings of {} faces); fitted ones to {:.2f} um.",
                    UmFromMm(held_out.held_out_rms_mm),
                    held_out.predicted,
                    held_out.groups,
                    UmFromMm(held_out.in_sample_rms_mm)));
  }
}

std::vector<Row> RowsFor(Session* session, const JointOptions& o) {
  const RowTable* record = session->bench().record;
  const bool recorded = o.use_recorded || !o.measure;
  if (!recorded || record == nullptr) return session->probing().rows();
  return record->rows;  // What was measured now is among them.
}

}  // namespace

Expected<void> RunJoint(Session* session, const JointOptions& o) {
  if (o.measure) {
    const auto measured = MeasureWithoutCompensation(session, o);
    if (!measured) return measured;
  }
  const std::vector<Row> rows = RowsFor(session, o);
  if (rows.empty()) {
    session->Tell("There are no rows to estimate from: measure first.");
    session->End(Ending::kRefused);
    return {};
  }
  JointProblem problem = MakeJointProblem(session, o, rows);
  problem.with_robust = o.scatter != JointOptions::Scatter::kStated;
  JointFit fit = FitJoint(problem);
  if (o.profile && fit.converged) PrintProfiles(session, problem, fit);
  if (problem.with_robust) {
    TakeRobust(session, o.scatter, &fit);
  } else {
    BelieveScatter(session, &fit);
  }
  session->Explain(fit.observability);
  session->Tell({InWords(fit.observability), Message::Kind::kOpen});
  if (!fit.converged) {
    session->Tell("The joint estimate did not converge: " + fit.message);
    session->End(Ending::kConfounded);
    return {};
  }
  Print(session, problem, fit);
  // What a model leaves out it cannot see, however well it fits.
  session->Tell(
      fmt::format("Not in this model, and so not looked for: {}wind-up of the "
                  "drive, errors that change along an axis.",
                  o.squareness ? "" : "squareness (squareness: true), "));
  std::array<bool, 3> applied{};
  for (const Axis axis : o.axes) {
    const auto kept = ApplyAxis(session, fit, axis, o);
    if (!kept) return tl::unexpected(kept.error());
    applied[static_cast<std::size_t>(Index(axis))] = *kept;
  }
  ConcludeAll(session, o, fit, applied);
  ConcludeCorrelations(session, o, fit);
  const bool any = std::ranges::find(applied, true) != applied.end();
  if (!any && session->rules().apply) session->End(Ending::kRefused);
  return {};
}

namespace {

PreparedProcedure PrepareJointEstimate(YamlMap map, const Machine& /*drawing*/) {
  JointOptions o;
  o.place = map.place();
  map.WordOr("variant", "corrected", {"as_published", "corrected"});
  o.axes = ReadAxes(&map);
  o.artefact = map.TextOr("artefact", "");
  o.sizes_mm = ReadDimensions(&map, o.sizes_mm);
  o.repeats = static_cast<int>(map.IntegerOr("repeats", 5, 1, 1000));
  o.measure = map.FlagOr("measure", true);
  o.use_recorded = map.FlagOr("use_recorded", false);
  o.tilt = map.FlagOr("tilt", true);
  o.squareness = map.FlagOr("squareness", false);
  o.robust = map.FlagOr("robust", false);
  o.profile = map.FlagOr("profile", false);
  const std::string scatter =
      map.WordOr("scatter", "stated", {"stated", "rows", "faces"});
  o.scatter = scatter == "rows"    ? JointOptions::Scatter::kRows
              : scatter == "faces" ? JointOptions::Scatter::kGroups
                                   : JointOptions::Scatter::kStated;
  const double hundred = PercentFromFraction(1.0);
  o.steps_doubt =
      map.NumberOr("steps_u_percent", hundred * kScaleDoubt, {1e-4, 20}) / hundred;
  o.verify = map.FlagOr("verify", true);
  if (map.Has("hysteresis_mm")) {
    o.hysteresis_mm = Given{.value = map.Number("hysteresis_mm", {0, 1}),
                            .sd = map.NumberOr("hysteresis_u_mm", 0.0005, {1e-9, 1})};
  }
  if (map.Has("tip_radius_mm")) {
    o.tip_radius_mm = Given{.value = map.Number("tip_radius_mm", {0.05, 20}),
                            .sd = map.NumberOr("tip_radius_u_mm", 0.001, {1e-9, 1})};
  }
  o.rules.apply = map.FlagOr("apply", true);
  o.rules.roll_back = map.FlagOr("rollback", true);
  o.rules.keep_within_sd = map.NumberOr("keep_within_sd", kKeepWithinSd, {0, 100});
  o.rules.steps_limit = map.NumberOr("steps_limit", 0.05, {1e-4, 0.5});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "joint_estimate", "corrected", o.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunJoint(&session, o));
  };
}

}  // namespace

constinit const Procedure kJointEstimate{
    .name = "joint_estimate",
    .about = "Everything from all readings at once, with covariance.",
    .source = "This project; least squares as in JCGM 100 and 102.",
    .published =
        "minimise sum (value - Predict(parameters) - placements)^2 / sigma^2 + "
        "sum (parameter - prior)^2 / sd^2.",
    .physics =
        "One measurement model for all rows, so spans, releases and the table's "
        "heights "
        "help each other, and what no row tells is named with the measurement that "
        "would. Compensation is off while it measures. Also prints how well faces are "
        "predicted that were not fitted.",
    .has_variants = false,
    .prepare = PrepareJointEstimate};

}  // namespace caltwin
