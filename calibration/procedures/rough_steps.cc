#include "calibration/procedures/rough_steps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/steps.h"
#include "calibration/procedures/plan_model.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kFromEnds_mm = 15;  // Kept clear of both ends, lead-in included.
constexpr double kPublished = 0.01;  // 100 mm commanded must move 99 to 101.

double Sd_mm(Session* session, const RoughOptions& o) {
  double sd_mm = session->probing().Noise(o.common.axis).step_mm / std::sqrt(12.0);
  const auto found = session->bench().instruments.find(o.instrument);
  if (found == session->bench().instruments.end()) return sd_mm;
  return std::hypot(sd_mm,
                    MmFromUm(found->second.sigma_um),
                    MmFromUm(found->second.resolution_um) / std::sqrt(12.0));
}

// Room is kept for steps/mm that move the axis too far.
double Distance_mm(Session* session, const RoughOptions& o) {
  const AxisDrawing& drawing = session->bench().machine.axis(o.common.axis);
  const double room_mm = drawing.travel_mm() - 2 * kFromEnds_mm;
  const double above_mm = o.common.axis == Axis::kZ
                              ? drawing.max_mm - session->probing().SafeHeight_mm()
                              : room_mm;
  return std::min({o.distance_mm, room_mm, std::max(above_mm - kFromEnds_mm, 1.0)});
}

Expected<MeasuredMove> MeasureRoughSteps(Session* session, const RoughOptions& o) {
  const CommonOptions& c = o.common;
  const AxisDrawing& drawing = session->bench().machine.axis(c.axis);
  const std::string id = o.instrument + "." + Name(c.axis);
  const double way_mm = Distance_mm(session, o);
  const double lead_mm = session->probing().LeadIn_mm(Unit(c.axis));
  if (const auto raised = session->probing().Raise(); !raised) {
    return tl::unexpected(raised.error());
  }
  Vec3<double> from_mm = session->controller().position_mm();
  from_mm[Index(c.axis)] = c.axis == Axis::kZ
                               ? session->probing().SafeHeight_mm() + lead_mm
                               : drawing.mid_mm() - way_mm / 2;
  const auto go = [&](double by_mm) {
    Vec3<double> target_mm = from_mm;
    target_mm[Index(c.axis)] += by_mm;
    return session->controller().MoveTo(target_mm, drawing.max_feed_mm_s / 4);
  };
  double sum_mm = 0;
  for (int i = 0; i < c.repeats; ++i) {
    // Led in, so that the move itself loses no gap.
    const double back_mm = -lead_mm;
    for (const double by_mm : {back_mm, 0.0}) {
      if (const auto gone = go(by_mm); !gone) return tl::unexpected(gone.error());
    }
    const auto start_mm = session->bench().gauge->Read_mm(id);
    if (!start_mm) return tl::unexpected(start_mm.error());
    if (const auto gone = go(way_mm); !gone) return tl::unexpected(gone.error());
    const auto end_mm = session->bench().gauge->Read_mm(id);
    if (!end_mm) return tl::unexpected(end_mm.error());
    sum_mm += *end_mm - *start_mm;
  }
  const double sd_mm = Sd_mm(session, o) * std::sqrt(2.0 / c.repeats);
  return MeasuredMove{.steps_per_mm = session->Believed(Setting::kStepsPerMm, c.axis),
                      .commanded_mm = way_mm,
                      .actual_mm = {.value = sum_mm / c.repeats, .sd = sd_mm}};
}

double Error(const MeasuredMove& move) {
  return move.actual_mm.value / move.commanded_mm - 1;
}

// The published check, and whether the move is nearer to its command than before.
Expected<bool> CheckAgain(Session* session,
                          const RoughOptions& o,
                          const MeasuredMove& move,
                          const Proposal& proposal,
                          double before) {
  const auto again = MeasureRoughSteps(session, o);
  if (!again) return tl::unexpected(again.error());
  session->Tell(fmt::format("{:.3f} mm commanded now move {:.4f} mm, {} within 1 %.",
                            again->commanded_mm,
                            again->actual_mm.value,
                            std::abs(Error(*again)) <= kPublished ? "so" : "not"));
  return session->KeepOrRollBack(proposal,
                                 before,
                                 {.error_before = Error(move) * move.commanded_mm,
                                  .error_after = Error(*again) * again->commanded_mm,
                                  .sd = again->actual_mm.sd});
}

}  // namespace

Expected<void> RunRoughSteps(Session* session, const RoughOptions& o) {
  const CommonOptions& c = o.common;
  PlanModel plan(session);
  plan.AddReading(c.axis, 0, +1, Sd_mm(session, o));
  plan.AddReading(c.axis, Distance_mm(session, o), +1, Sd_mm(session, o));
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
  const std::string name = NameOf(Setting::kStepsPerMm, c.axis);
  bool applied_any = false;
  for (int pass = 1; pass <= c.iterations; ++pass) {
    const auto move = MeasureRoughSteps(session, o);
    if (!move) return tl::unexpected(move.error());
    const Uncertain steps = StepsFromMove(*move);
    const double before = session->Believed(Setting::kStepsPerMm, c.axis);
    const Proposal proposal{.setting = Setting::kStepsPerMm,
                            .axis = c.axis,
                            .after = steps.value,
                            .sd = steps.sd,
                            .iteration = pass,
                            .why = fmt::format("{:.3f} mm commanded moved {:.4f} mm.",
                                               move->commanded_mm,
                                               move->actual_mm.value)};
    const auto applied = session->Apply(proposal);
    if (!applied) return tl::unexpected(applied.error());
    if (!*applied) {
      if (!applied_any && session->rules().apply) session->End(Ending::kRefused);
      if (!applied_any) session->Conclude(name, "1/mm", steps);
      return {};
    }
    applied_any = true;
    const auto kept = c.verify ? CheckAgain(session, o, *move, proposal, before)
                               : Expected<bool>(true);
    if (!kept) return tl::unexpected(kept.error());
    session->Conclude(name, "1/mm", steps, *kept);
    if (!*kept) return {};
  }
  return {};
}

namespace {

PreparedProcedure PrepareRoughSteps(YamlMap map, const Machine& /*drawing*/) {
  RoughOptions o;
  o.common = ReadCommon(&map, {.repeats = 1});
  o.distance_mm = map.NumberOr("distance_mm", 100, {1, 2000});
  o.instrument = map.WordOr("instrument", "laser", {"laser", "dial"});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "next_rough_steps", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunRoughSteps(&session, o));
  };
}

}  // namespace

constinit const Procedure kRoughSteps{
    .name = "next_rough_steps",
    .about = "NeXT phase 1: steps/mm within 1 % from one long move.",
    .source = "NeXT machine calibration guide 1.0, section 3.3.",
    .published =
        "s_new = s * commanded / actual for a move of 100 mm read by callipers "
        "or a dial; then 100 mm must move 99 to 101 mm.",
    .physics =
        "Right: actual = s / s_true * commanded. The start must be come to in "
        "the sense of the move, else the gap is lost on the way: 0.05 mm of "
        "100 mm is 0.05 %.",
    .has_variants = false,
    .prepare = PrepareRoughSteps};

}  // namespace caltwin
