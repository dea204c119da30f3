#include "calibration/procedures/deflection.h"

#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/deflection.h"
#include "calibration/procedures/ledge.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kPublishedTolerance_mm = 0.01;  // NeXT 3.6, step 5.
constexpr double kKnown_mm = 0.1;  // A gap less sure than this is not known.

struct FromElsewhere {
  Given backlash_left_mm = kNotGiven;
  Given tip_radius_mm{};
  Given mm_per_commanded_mm{.value = 1};
};

// What the span is measured on: for z a ledge, which can be touched from both sides.
Artefact* ArtefactFor(Session* session, const DeflectionOptions& o) {
  const CommonOptions& c = o.common;
  if (c.axis == Axis::kZ) {
    return SeekArtefact(&session->bench(), c.artefact, {ArtefactType::kLedge}, c.place);
  }
  return FindArtefact(
      &session->bench(),
      c.artefact,
      {ArtefactType::kBlock123, ArtefactType::kWeb, ArtefactType::kPocket},
      c.place);
}

// The steps/mm believed, as well as somebody has measured them.
Given Scale(Session* session, Axis axis) {
  const std::string name = NameOf(Setting::kStepsPerMm, axis);
  const auto& known = session->bench().ledger.known;
  const auto steps = known.find(name);
  if (steps == known.end()) return {.value = 1};
  return {.value = 1,
          .sd = steps->second.sd / steps->second.value,
          .source = name,
          .sense = -1};
}

FromElsewhere WhatIsKnown(Session* session, const DeflectionOptions& o) {
  return {.backlash_left_mm =
              o.backlash_left_mm.value_or(BacklashLeft(session, o.common.axis)),
          .tip_radius_mm = TipRadius(session, o.tip_radius_mm),
          .mm_per_commanded_mm = Scale(session, o.common.axis)};
}

Expected<SpanReading> MeasureDeflection(Session* session,
                                        const Artefact& artefact,
                                        const DeflectionOptions& o) {
  const CommonOptions& c = o.common;
  const SpanPlan plan{.axis = c.axis,
                      .repeats = c.repeats,
                      .campaign = "deflection." + Name(c.axis),
                      .place = c.place};
  return artefact.type == ArtefactType::kLedge ? MeasureLedge(session, artefact, plan)
                                               : MeasureSpan(session, artefact, plan);
}

DeflectionSpan AsSpan(Session* session,
                      const SpanReading& span,
                      const FromElsewhere& known) {
  const double radius_mm = session->believed().tip_radius_mm;
  return {.kind = span.kind,
          .size_mm = span.size_mm,
          .span_mm = span.span_mm,
          .tip_radius_cfg_mm = radius_mm,
          .tip_radius_mm = known.tip_radius_mm,
          .backlash_mm = known.backlash_left_mm,
          .mm_per_commanded_mm = known.mm_per_commanded_mm};
}

void ExplainPlanOfDeflection(Session* session,
                             const Artefact& artefact,
                             const DeflectionOptions& o,
                             const FromElsewhere& known) {
  PlanModel plan(session);
  for (const Face& face :
       FacesForSpan(artefact, {.axis = o.common.axis, .place = o.common.place})) {
    plan.AddTouch(face, o.common.repeats, artefact.id);
  }
  plan.AddKnown(NameOf(Setting::kStepsPerMm, o.common.axis), 0.1);
  plan.AddKnown("tip_size", std::max(known.tip_radius_mm.sd, 1e-6));
  if (known.backlash_left_mm.sd < kKnown_mm) {
    plan.AddKnown(NameOf(Setting::kBacklash, o.common.axis),
                  std::max(known.backlash_left_mm.sd, 1e-6));
  }
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
}

// Z has one face only: pre-travel shifts every height alike, and so does the table.
Expected<void> SayNotIdentifiable(Session* session, Axis axis) {
  const std::string name = NameOf(Setting::kDeflection, axis);
  session->Tell(
      "Along z every height is read by the same pre-travel too low, which no "
      "touch from above tells from the table's height: pre-travel of z needs "
      "a ledge, touched from above and from below with the disc stylus.");
  PlanModel plan(session);
  plan.AddTouch(TableAt(0, 0), 1, "table");
  plan.AddKnown(NameOf(Setting::kStepsPerMm, axis), 0.1);
  plan.AddKnown(NameOf(Setting::kBacklash, axis), 0.001);
  plan.AddKnown("tip_size", kTipDoubt_mm);
  session->Explain(plan.Report());
  session->Conclude(name, "mm", {});
  session->End(Ending::kConfounded);
  return {};
}

Expected<void> SayGapUnknown(Session* session, Axis axis) {
  const std::string name = NameOf(Setting::kDeflection, axis);
  session->Measured(name,
                    session->Believed(Setting::kDeflection, axis),
                    "Not applied: the backlash is not known.");
  session->Tell(
      "Nobody has measured the backlash of this axis: half of it would be "
      "taken for pre-travel. Measure it first, or give backlash_left_mm.");
  session->Conclude(name, "mm", {});
  session->End(Ending::kConfounded);
  return {};
}

// No probe bends so far: what was entered is asked about, and nothing applied.
bool IsReasonable(Session* session,
                  const Artefact& artefact,
                  const SpanReading& span,
                  Axis axis,
                  const Uncertain& delta_mm) {
  UnlikelyPretravel pretravel{.found_mm = delta_mm.value,
                              .drawn_mm = session->bench().machine.probe.pretravel_mm,
                              .entered_radius_mm = session->believed().tip_radius_mm,
                              .entered_size_mm = span.size_mm.value};
  if (!IsUnlikely(pretravel, delta_mm.sd)) return true;
  if (session->bench().instruments.contains("calliper")) {
    const auto size_mm = session->bench().gauge->Read_mm(
        fmt::format("calliper.{}.{}", artefact.id, Name(axis)));
    if (size_mm) pretravel.calliper_size_mm = *size_mm;
  }
  session->Tell(Trouble::kUnreasonable, WhyUnlikelyPretravel(pretravel));
  session->Measured(
      NameOf(Setting::kDeflection, axis),
      session->Believed(Setting::kDeflection, axis),
      fmt::format("Not applied: {:.4f} mm is no pre-travel of this probe.",
                  delta_mm.value));
  session->Conclude(NameOf(Setting::kDeflection, axis), "mm", {});
  session->End(Ending::kRefused);
  return false;
}

Expected<void> RunAsPublished(Session* session,
                              const Artefact& artefact,
                              const DeflectionOptions& o) {
  const CommonOptions& c = o.common;
  const auto span = MeasureDeflection(session, artefact, o);
  if (!span) return tl::unexpected(span.error());
  const Uncertain deflection_mm = DeflectionAsPublished(AsSpan(session, *span, {}));
  const auto applied =
      session->Apply({.setting = Setting::kSingleDeflection,
                      .axis = c.axis,
                      .after = deflection_mm.value,
                      .why = fmt::format("{:.4f} mm measured, {:.4f} mm actual.",
                                         span->span_mm.value,
                                         span->size_mm.value)});
  if (!applied) return tl::unexpected(applied.error());
  session->Conclude(
      NameOf(Setting::kDeflection, c.axis), "mm", deflection_mm, *applied);
  if (!*applied && session->rules().apply) session->End(Ending::kRefused);
  if (!*applied || !c.verify) return {};
  const auto again = MeasureDeflection(session, artefact, o);
  if (!again) return tl::unexpected(again.error());
  // G6512 takes its stored deflection off each face, in the sense of the formula.
  const double compensated_mm =
      again->span_mm.value -
      2 * session->believed()
              .probe_deflection_mm[static_cast<std::size_t>(Index(c.axis))];
  const double off_mm = compensated_mm - again->size_mm.value;
  session->Tell(
      fmt::format("Step 5: reads {:+.4f} mm off after compensation, {} within 0.01 mm: "
                  "the formula agrees with itself, whatever its sign.",
                  off_mm,
                  std::abs(off_mm) <= kPublishedTolerance_mm ? "so" : "not"));
  return {};
}

// How far a size is off [mm] with this deflection taken off each face, and what is
// known of gap and tip.
double Off_mm(Session* session,
              const FromElsewhere& known,
              const SpanReading& span,
              double deflection_mm) {
  const double sign = span.kind == SpanKind::kExternal ? 1 : -1;
  const double tips_mm =
      2 * (known.tip_radius_mm.value - session->believed().tip_radius_mm);
  const double taken_off_mm =
      2 * deflection_mm + known.backlash_left_mm.value - tips_mm;
  return span.error_mm() + sign * taken_off_mm;
}

}  // namespace

Expected<void> RunDeflection(Session* session, const DeflectionOptions& o) {
  const CommonOptions& c = o.common;
  Artefact* artefact = ArtefactFor(session, o);
  if (artefact == nullptr) return SayNotIdentifiable(session, c.axis);
  if (const auto laid = LayBlock(session, artefact, c.axis, o.size_mm); !laid) {
    return laid;
  }
  if (c.as_published) return RunAsPublished(session, *artefact, o);
  const FromElsewhere known = WhatIsKnown(session, o);
  ExplainPlanOfDeflection(session, *artefact, o, known);
  const auto span = MeasureDeflection(session, *artefact, o);
  if (!span) return tl::unexpected(span.error());
  const Deflection found = DeflectionFromSpan(AsSpan(session, *span, known));
  const std::string name = NameOf(Setting::kDeflection, c.axis);
  const double before_mm = session->Believed(Setting::kDeflection, c.axis);
  session->Tell(fmt::format("{}: pre-travel + backlash / 2 - tip radius is {:.4f} mm.",
                            Letter(c.axis),
                            found.combination_mm.value));
  if (known.backlash_left_mm.sd > kKnown_mm) return SayGapUnknown(session, c.axis);
  const Uncertain delta_mm = found.pretravel_mm;
  if (!IsReasonable(session, *artefact, *span, c.axis, delta_mm)) return {};
  const Proposal proposal{
      .setting = Setting::kDeflection,
      .axis = c.axis,
      .after = delta_mm.value,
      .sd = delta_mm.sd,
      .why = fmt::format(
          "{:.4f} mm reads {:.4f} mm.", span->size_mm.value, span->span_mm.value)};
  const auto applied = session->Apply(proposal);
  if (!applied) return tl::unexpected(applied.error());
  if (!*applied || !c.verify) {
    if (!*applied && session->rules().apply) session->End(Ending::kRefused);
    session->Conclude(name, "mm", delta_mm, *applied);
    return {};
  }
  const auto again = MeasureDeflection(session, *artefact, o);
  if (!again) return tl::unexpected(again.error());
  const double now_mm = session->Believed(Setting::kDeflection, c.axis);
  const auto good =
      session->KeepOrRollBack(proposal,
                              before_mm,
                              {.error_before = Off_mm(session, known, *span, before_mm),
                               .error_after = Off_mm(session, known, *again, now_mm),
                               .sd = again->span_mm.sd});
  if (!good) return tl::unexpected(good.error());
  session->Conclude(name, "mm", delta_mm, *good);
  return {};
}

namespace {

PreparedProcedure PrepareDeflection(YamlMap map, const Machine& /*drawing*/) {
  DeflectionOptions o;
  o.common = ReadCommon(&map);
  o.size_mm = map.NumberOr("dimension", 25.4, {0.1, 1000});
  if (map.Has("backlash_left_mm")) {
    o.backlash_left_mm = Given{.value = map.Number("backlash_left_mm", {-2, 2}),
                               .sd = map.NumberOr("backlash_u_mm", 0.001, {0, 2})};
  }
  if (map.Has("tip_radius_mm")) {
    o.tip_radius_mm = Given{.value = map.Number("tip_radius_mm", {0.05, 20}),
                            .sd = map.NumberOr("tip_radius_u_mm", 0.001, {0, 1})};
  }
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "next_deflection", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunDeflection(&session, o));
  };
}

}  // namespace

constinit const Procedure kDeflection{
    .name = "next_deflection",
    .about = "NeXT phase 4: pre-travel of the probe from one known size.",
    .source = "NeXT machine calibration guide 1.0, sections 2.2 and 3.6.",
    .published =
        "deflection = (measured - actual) / 2, stored as one number "
        "global.nxtProbeDeflection.",
    .physics =
        "The machine moves on by delta after contact, so a block reads small: S = D - "
        "2 delta - b + 2 (R - R_cfg), and the formula's sign is wrong. delta + b / 2 - "
        "R always appear together, in blocks and in bores: the tip's radius comes from "
        "its certificate or a calliper, the backlash from trigger against release or a "
        "dial, and without them the procedure says that it cannot tell. One value an "
        "axis. Along z only a ledge touched from both sides tells.",
    .has_variants = true,
    .prepare = PrepareDeflection};

}  // namespace caltwin
