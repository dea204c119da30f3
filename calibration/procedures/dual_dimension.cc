#include "calibration/procedures/dual_dimension.h"

#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/steps.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/span.h"

namespace caltwin {
namespace {

constexpr double kPublishedTolerance_mm = 0.02;  // NeXT 3.4, step 6.
constexpr double kMacroBeside_mm = 5;            // Where G9000 aims: beside the face.
constexpr double kMacroJog_mm = 20;              // Where the person jogged to.

struct TwoSizes {
  SpanReading first{};
  SpanReading second{};

  double change_error_mm() const { return second.error_mm() - first.error_mm(); }
  double sd_mm() const { return std::hypot(first.span_mm.sd, second.span_mm.sd); }
};

Expected<TwoSizes> MeasureDualDimension(Session* session,
                                        Artefact* block,
                                        const DualDimensionOptions& o) {
  const SpanPlan plan{.axis = o.common.axis,
                      .repeats = o.common.repeats,
                      .campaign = "dual_dimension." + Name(o.common.axis),
                      .place = o.common.place};
  TwoSizes sizes;
  for (const bool second : {false, true}) {
    const double size_mm = second ? o.sizes_mm.back() : o.sizes_mm.front();
    if (const auto laid = LayBlock(session, block, o.common.axis, size_mm); !laid) {
      return tl::unexpected(laid.error());
    }
    const auto span = MeasureSpan(session, *block, plan);
    if (!span) return tl::unexpected(span.error());
    (second ? sizes.second : sizes.first) = *span;
  }
  return sizes;
}

TwoSpans AsTwoSpans(const TwoSizes& sizes, double steps_per_mm) {
  return {.steps_per_mm = steps_per_mm,
          .size1_mm = sizes.first.size_mm,
          .size2_mm = sizes.second.size_mm,
          .span1_mm = sizes.first.span_mm,
          .span2_mm = sizes.second.span_mm};
}

void ExplainPlanOfDualDimension(Session* session,
                                Artefact block,
                                const DualDimensionOptions& o) {
  PlanModel plan(session);
  for (const double size_mm : {o.sizes_mm.front(), o.sizes_mm.back()}) {
    block.size_mm = BlockLying(o.common.axis, size_mm);
    for (const Face& face :
         FacesForSpan(block, {.axis = o.common.axis, .place = o.common.place})) {
      // On the table, a block stands as high as it is: its place along z stays.
      const bool same = o.common.axis == Axis::kZ;
      plan.AddTouch(
          face, o.common.repeats, same ? "table" : fmt::format("{}", size_mm));
    }
  }
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
}

void CheckAsPublished(Session* session, const TwoSizes& sizes) {
  const bool within = std::abs(sizes.first.error_mm()) <= kPublishedTolerance_mm &&
                      std::abs(sizes.second.error_mm()) <= kPublishedTolerance_mm;
  session->Tell(fmt::format(
      "Step 6: {:.4g} mm reads {:+.4f} mm off, {:.4g} mm {:+.4f} mm: {}. Before "
      "backlash and pre-travel are compensated both read 2 delta + b too small.",
      sizes.first.size_mm.value,
      sizes.first.error_mm(),
      sizes.second.size_mm.value,
      sizes.second.error_mm(),
      within ? "within 0.02 mm" : "not within 0.02 mm"));
}

// G9000 line by line: G6512 probes from where the machine stands to its target, and
// nothing lifts the probe between the two faces.
Expected<void> RunMacro(Session* session,
                        const Artefact& block,
                        const DualDimensionOptions& o) {
  const SpanPlan plan{.axis = o.common.axis, .place = o.common.place};
  const std::vector<Face> faces = FacesForSpan(block, plan);
  const int i = Index(o.common.axis);
  const double fast_mm_s = session->bench().machine.probe.speeds_mm_s.front();
  const double half_mm = block.size_mm[i] / 2;
  if (const auto gone = session->probing().GoBefore(faces.front(), kMacroJog_mm);
      !gone) {
    return gone;
  }
  Vec3<double> target_mm = session->controller().position_mm();
  target_mm[i] = block.at_mm[i] - half_mm - kMacroBeside_mm;
  const auto left = session->controller().ProbeTowards(target_mm, fast_mm_s);
  if (!left) return left;
  target_mm[i] = block.at_mm[i] + half_mm + kMacroBeside_mm;
  return session->controller().ProbeTowards(target_mm, fast_mm_s);
}

Uncertain NewSteps(const TwoSizes& sizes, double believed, bool as_published) {
  const TwoSpans spans = AsTwoSpans(sizes, believed);
  return as_published ? StepsFromTwoSpansAsPublished(spans) : StepsFromTwoSpans(spans);
}

}  // namespace

Expected<void> RunDualDimension(Session* session, const DualDimensionOptions& o) {
  const CommonOptions& c = o.common;
  Artefact* block =
      FindArtefact(&session->bench(), c.artefact, {ArtefactType::kBlock123}, c.place);
  if (o.macro) return RunMacro(session, *block, o);
  ExplainPlanOfDualDimension(session, *block, o);
  auto sizes = MeasureDualDimension(session, block, o);
  if (!sizes) return tl::unexpected(sizes.error());
  const std::string name = NameOf(Setting::kStepsPerMm, c.axis);
  bool applied_any = false;
  for (int pass = 1; pass <= c.iterations; ++pass) {
    const double before = session->Believed(Setting::kStepsPerMm, c.axis);
    const Uncertain steps = NewSteps(*sizes, before, c.as_published);
    const Proposal proposal{
        .setting = Setting::kStepsPerMm,
        .axis = c.axis,
        .after = steps.value,
        .sd = steps.sd,
        .iteration = pass,
        .why = fmt::format("{:.4g} and {:.4g} mm read {:.4f} and {:.4f} mm.",
                           sizes->first.size_mm.value,
                           sizes->second.size_mm.value,
                           sizes->first.span_mm.value,
                           sizes->second.span_mm.value)};
    const auto applied = session->Apply(proposal);
    if (!applied) return tl::unexpected(applied.error());
    if (!*applied) {
      if (!applied_any) {
        if (session->rules().apply) session->End(Ending::kRefused);
        session->Conclude(name, "1/mm", steps);
      }
      break;
    }
    applied_any = true;
    Uncertain kept = steps;
    kept.value = session->Believed(Setting::kStepsPerMm, c.axis);
    if (!c.verify && pass == c.iterations) {
      session->Conclude(name, "1/mm", kept, true);
      break;
    }
    const double error_before_mm = sizes->change_error_mm();
    sizes = MeasureDualDimension(session, block, o);
    if (!sizes) return tl::unexpected(sizes.error());
    if (c.as_published) CheckAsPublished(session, *sizes);
    const auto good = session->KeepOrRollBack(proposal,
                                              before,
                                              {.error_before = error_before_mm,
                                               .error_after = sizes->change_error_mm(),
                                               .sd = sizes->sd_mm()});
    if (!good) return tl::unexpected(good.error());
    session->Conclude(name, "1/mm", *good ? kept : steps, *good);
    if (!*good) break;
  }
  return {};
}

namespace {

PreparedProcedure PrepareDualDimension(YamlMap map, const Machine& /*drawing*/) {
  DualDimensionOptions o;
  o.common = ReadCommon(&map);
  o.sizes_mm = ReadDimensions(
      &map, o.common.as_published ? std::vector{25.4, 50.8} : std::vector{25.4, 76.2});
  if (map.Has("macro")) {
    map.WordOr("macro", "G9000", {"G9000"});
    o.macro = true;
  }
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "next_dual_dimension", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunDualDimension(&session, o));
  };
}

}  // namespace

constinit const Procedure kDualDimension{
    .name = "next_dual_dimension",
    .about = "NeXT phase 2: steps/mm from two sizes of one block.",
    .source = "NeXT machine calibration guide 1.0, section 3.4 and macro G9000.",
    .published =
        "s_new = s (D2 - D1) / (D2_meas - D1_meas) with D1 = 25.4, D2 = 50.8 mm; then "
        "both sizes must read within 0.02 mm. Macro G9000 probes to center - D/2 - 5 "
        "and center + D/2 + 5.",
    .physics =
        "Touching a size D reads S = (D + 2R - 2 delta - b) / k - 2 R_cfg with k = s / "
        "s_true, so the formula is upside down: from 808 (truth 800) it goes to 816, "
        "832, 866, the error doubling, until the 5 % limit stops it. Correct: s_new = "
        "s (S2 - S1) / (D2 - D1), right in one pass; what is constant cancels, so the "
        "order of steps and backlash does not matter. Both sizes cannot read within "
        "0.02 mm before pre-travel and backlash are compensated: check their "
        "difference. The macro's targets lie before the faces (no trigger), and "
        "nothing lifts the probe between them.",
    .has_variants = true,
    .prepare = PrepareDualDimension};

}  // namespace caltwin
