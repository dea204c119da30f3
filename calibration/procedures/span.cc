#include "calibration/procedures/span.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "calibration/estimate/clusters.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSameSize_mm = 1e-6;

double Pooled_mm(const std::vector<Touched>& faces) {
  double sum_mm2 = 0;
  int dof = 0;
  for (const Touched& touched : faces) {
    const int n = static_cast<int>(touched.trigger_mm.size());
    const double scatter_mm = Scatter(touched.trigger_mm);
    sum_mm2 += (n - 1) * scatter_mm * scatter_mm;
    dof += n - 1;
  }
  return dof > 0 ? std::sqrt(sum_mm2 / dof) : 0;
}

}  // namespace

Expected<void> LayBlock(Session* session,
                        Artefact* block,
                        Axis axis,
                        double length_mm) {
  if (block->type != ArtefactType::kBlock123) return {};
  if (std::abs(block->size_mm[Index(axis)] - length_mm) < kSameSize_mm) return {};
  if (const auto raised = session->probing().Raise(); !raised) return raised;
  const auto done = session->bench().person->Do(
      {.kind = Act::Kind::kTurnBlock,
       .text = fmt::format("Turn the block '{}' so that its {} mm lie along {}.",
                           block->id,
                           length_mm,
                           Letter(axis)),
       .artefact = block->id,
       .axis = Letter(axis),
       .length_mm = length_mm});
  if (!done) return done;
  block->size_mm = BlockLying(axis, length_mm);
  block->side = axis;
  ++session->bench().ledger.placements[block->id];
  return session->probing().Raise();
}

std::vector<Face> FacesForSpan(const Artefact& artefact, const SpanPlan& plan) {
  std::vector<Face> faces = FacesAcross(artefact, plan.axis);
  if (plan.axis == Axis::kZ && faces.empty()) {
    if (const auto top = TopOf(artefact)) faces = {*top};
  }
  if (faces.empty()) {
    throw InputError(
        plan.place,
        fmt::format(
            "artefact '{}' has no faces across {}", artefact.id, Letter(plan.axis)),
        "a block, web, ring or pocket with turn_deg 0, 90, 180 or 270 has them");
  }
  return faces;
}

Uncertain MeanOf(Session* session, Axis axis, const std::vector<double>& readings) {
  TouchNoise noise = session->probing().Noise(axis);
  noise.sigma_mm = std::max(noise.sigma_mm, Scatter(readings));
  return MeanTouch_mm(readings, noise);
}

Expected<SpanReading> MeasureSpan(Session* session,
                                  const Artefact& artefact,
                                  const SpanPlan& plan) {
  SpanReading reading;
  reading.size_mm = {.value = artefact.size_mm[Index(plan.axis)],
                     .sd = MmFromUm(artefact.u_um)};
  double variance_mm2 = 0;
  double outward_mm = 0;
  for (const Face& face : FacesForSpan(artefact, plan)) {
    const auto touched = session->probing().Touch(
        face, {.repeats = plan.repeats, .campaign = plan.campaign});
    if (!touched) return tl::unexpected(touched.error());
    if (face.internal) reading.kind = SpanKind::kInternal;
    const Uncertain mean = MeanOf(session, plan.axis, touched->trigger_mm);
    outward_mm += mean.value;
    variance_mm2 += mean.sd * mean.sd;
    reading.faces.push_back(*touched);
  }
  reading.is_height = reading.faces.size() == 1;
  // Values are along the outward normals: a hole is as much smaller as a block larger.
  const double sign = reading.kind == SpanKind::kExternal ? 1 : -1;
  reading.span_mm = {
      .value = reading.size_mm.value + Mutant("bore_as_block", sign, 1.0) * outward_mm,
      .sd = std::sqrt(variance_mm2)};
  reading.scatter_mm = Pooled_mm(reading.faces);
  WarnOfScatter(session, artefact.id, reading.scatter_mm);
  return reading;
}

void WarnOfScatter(Session* session, const std::string& what, double scatter_mm) {
  if (scatter_mm <= kScatterWarning_mm) return;
  session->Tell(fmt::format("Repeated touches of {} scatter by {:.1f} um, more than 5.",
                            what,
                            UmFromMm(scatter_mm)));
  session->Tell(Trouble::kInconsistent);
}

Given BacklashLeft(Session* session, Axis axis) {
  // Under a hanging load the gap stays shut: nothing is lost, and a compensation adds.
  if (WeightKeepsGapShut(axis, session->bench().machine.axis(axis))) {
    return {.value = -session->Believed(Setting::kBacklash, axis)};
  }
  const auto& known = session->bench().ledger.known;
  const auto gap = known.find(NameOf(Setting::kBacklash, axis));
  if (gap == known.end()) return kNotGiven;
  return {.value = gap->second.value - session->Believed(Setting::kBacklash, axis),
          .sd = gap->second.sd};
}

}  // namespace caltwin
