#include "calibration/procedures/span.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "calibration/estimate/clusters.h"
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
  if (const auto up = session->probing().RaiseToTop(); !up) return up;
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
  return {};
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

TouchNoise NoiseOf(Session* session, Axis axis, std::span<const Touched> faces) {
  std::vector<std::span<const double>> groups_mm;
  for (const Touched& touched : faces) groups_mm.emplace_back(touched.trigger_mm);
  return NoiseSeen(session->probing().Noise(axis), groups_mm);
}

std::string SizeOf(const Artefact& artefact, Axis axis) {
  return fmt::format("size of {} along {}", artefact.id, Name(axis));
}

Expected<SpanReading> MeasureSpan(Session* session,
                                  const Artefact& artefact,
                                  const SpanPlan& plan) {
  SpanReading reading;
  reading.size_mm = {.value = artefact.size_mm[Index(plan.axis)],
                     .sd = MmFromUm(artefact.u_um),
                     .source = SizeOf(artefact, plan.axis)};
  double variance_mm2 = 0;
  double outward_mm = 0;
  for (const Face& face : FacesForSpan(artefact, plan)) {
    const auto touched = session->probing().Touch(
        face, {.repeats = plan.repeats, .campaign = plan.campaign});
    if (!touched) return tl::unexpected(touched.error());
    if (face.internal) reading.kind = SpanKind::kInternal;
    reading.faces.push_back(*touched);
  }
  const TouchNoise noise = NoiseOf(session, plan.axis, reading.faces);
  for (const Touched& touched : reading.faces) {
    const Uncertain mean = MeanTouch_mm(touched.trigger_mm, noise);
    outward_mm += mean.value;
    variance_mm2 += mean.sd * mean.sd;
  }
  reading.is_height = reading.faces.size() == 1;
  // Values are along the outward normals: a hole is as much smaller as a block larger.
  const double sign = reading.kind == SpanKind::kExternal ? 1 : -1;
  reading.span_mm = {.value = reading.size_mm.value + sign * outward_mm,
                     .sd = std::sqrt(variance_mm2),
                     .dof = noise.dof};
  reading.scatter_mm = Pooled_mm(reading.faces);
  std::vector<std::vector<double>> faces_mm;
  for (const Touched& touched : reading.faces) faces_mm.push_back(touched.trigger_mm);
  WarnOfScatter(session, artefact.id, reading.scatter_mm, faces_mm);
  return reading;
}

void WarnOfScatter(Session* session,
                   const std::string& what,
                   double scatter_mm,
                   std::span<const std::vector<double>> faces_mm) {
  if (scatter_mm <= kScatterWarning_mm) return;
  session->Tell(fmt::format("Repeated touches of {} scatter by {:.1f} um, more than 5.",
                            what,
                            UmFromMm(scatter_mm)));
  session->Tell(Trouble::kInconsistent, WhyInconsistent(faces_mm));
}

Given TipRadius(Session* session, const std::optional<Given>& told) {
  if (told) return *told;
  const Given entered{.value = session->believed().tip_radius_mm,
                      .sd = kTipDoubt_mm,
                      .source = kTipRadius};
  const auto calliper = session->bench().instruments.find("calliper");
  if (calliper == session->bench().instruments.end()) return entered;
  const auto diameter_mm = session->bench().gauge->Read_mm("calliper.tip");
  if (!diameter_mm) return entered;
  const Instrument& instrument = calliper->second;
  const double sd_mm = std::hypot(MmFromUm(instrument.sigma_um),
                                  MmFromUm(instrument.resolution_um) / std::sqrt(12.0),
                                  MmFromUm(instrument.u_um)) /
                       2;
  const Given read{.value = *diameter_mm / 2, .sd = sd_mm};
  constexpr double kSigmas = 4;
  const double off_mm = std::abs(read.value - entered.value);
  if (off_mm > kSigmas * std::hypot(read.sd, entered.sd)) {
    session->Tell(
        fmt::format("The calliper reads a tip radius of {:.3f} mm, entered are {:.3f}: "
                    "was the diameter entered as the radius?",
                    read.value,
                    entered.value));
    return read;
  }
  return read.sd < entered.sd ? read : entered;
}

double PushOn_mm(Session* session, Axis axis) {
  constexpr double kWanted_mm = 0.05;
  const ProbeDrawing& probe = session->bench().machine.probe;
  const double friction_n = session->bench().machine.axis(axis).rail_friction_n;
  const double force_n = probe.stiffness_n_per_mm * (probe.pretravel_mm + kWanted_mm);
  return force_n < friction_n / 2 ? kWanted_mm : 0;
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
          .sd = gap->second.sd,
          .source = gap->first};
}

}  // namespace caltwin
