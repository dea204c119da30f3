#include <algorithm>
#include <cmath>

#include "calibration/procedures/joint_estimate.h"
#include "calibration/procedures/ledge.h"
#include "calibration/procedures/plane_tilt.h"
#include "calibration/procedures/span.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

constexpr double kBesideMiddle_mm = 0.35;  // Of the size across: where corners are met.

Expected<void> TouchBothFeeds(Session* session,
                              const Face& face,
                              const JointOptions& o,
                              const std::string& campaign) {
  std::vector<double> feeds_mm_s = session->bench().machine.probe.speeds_mm_s;
  std::ranges::sort(feeds_mm_s);
  double push_on_mm = 1;
  for (const Axis axis : kAxes) {
    if (face.ApproachSense(axis) == 0) continue;
    push_on_mm = std::min(push_on_mm, PushOn_mm(session, axis));
  }
  for (const double feed_mm_s : feeds_mm_s) {
    const auto touched = session->probing().Touch(face,
                                                  {.repeats = o.repeats,
                                                   .feed_mm_s = feed_mm_s,
                                                   .release = true,
                                                   .push_on_mm = push_on_mm,
                                                   .campaign = campaign});
    if (!touched) return tl::unexpected(touched.error());
  }
  return {};
}

Expected<void> MeasureAxis(Session* session,
                           Artefact* block,
                           Axis axis,
                           const JointOptions& o) {
  const std::string campaign = "joint." + Name(axis);
  for (const double size_mm : {o.sizes_mm.back(), o.sizes_mm.front()}) {
    if (const auto laid = LayBlock(session, block, axis, size_mm); !laid) return laid;
    const bool releases = size_mm == o.sizes_mm.front();
    for (const Face& face : FacesForSpan(*block, {.axis = axis, .place = o.place})) {
      if (releases) {
        const auto done = TouchBothFeeds(session, face, o, campaign);
        if (!done) return done;
        continue;
      }
      const auto touched =
          session->probing().Touch(face, {.repeats = o.repeats, .campaign = campaign});
      if (!touched) return tl::unexpected(touched.error());
    }
  }
  return {};
}

Expected<void> MeasureSquareness(Session* session,
                                 Artefact* block,
                                 const JointOptions& o) {
  if (const auto laid = LayBlock(session, block, Axis::kX, o.sizes_mm.back()); !laid) {
    return laid;
  }
  for (const Face& face : FacesOf(*block)) {
    if (face.n[2] > 0) continue;
    for (const int side : {-1, +1}) {
      for (const Axis along : {Axis::kX, Axis::kY}) {
        if (face.ApproachSense(along) != 0) continue;
        Face beside = face;
        beside.at_mm[Index(along)] +=
            side * kBesideMiddle_mm * block->size_mm[Index(along)];
        const auto touched = session->probing().Touch(
            beside, {.repeats = o.repeats, .campaign = "joint.squareness"});
        if (!touched) return tl::unexpected(touched.error());
      }
    }
  }
  return {};
}

FreeParameter Free(std::string_view effect,
                   const std::string& axis,
                   std::size_t i = 0) {
  return {.effect = *FindEffect(effect), .axis = axis, .parameter = i};
}

}  // namespace

Expected<void> MeasureJointCampaign(Session* session, const JointOptions& o) {
  Bench& bench = session->bench();
  Artefact* block =
      FindArtefact(&bench, o.artefact, {ArtefactType::kBlock123}, o.place);
  for (const Axis axis : o.axes) {
    if (const auto done = MeasureAxis(session, block, axis, o); !done) return done;
  }
  if (o.squareness) {
    if (const auto done = MeasureSquareness(session, block, o); !done) return done;
  }
  const bool has_z = std::ranges::find(o.axes, Axis::kZ) != o.axes.end();
  const Artefact* ledge = SeekArtefact(&bench, "", {ArtefactType::kLedge}, o.place);
  if (has_z && ledge != nullptr) {
    const auto done = MeasureLedge(session,
                                   *ledge,
                                   {.axis = Axis::kZ,
                                    .repeats = o.repeats,
                                    .campaign = "joint.ledge",
                                    .place = o.place});
    if (!done) return tl::unexpected(done.error());
  }
  if (!o.tilt) return {};
  for (const Face& face : TiltGrid(session, {.place = o.place})) {
    const auto touched = session->probing().Touch(
        face, {.repeats = o.repeats, .campaign = "joint.tilt"});
    if (!touched) return tl::unexpected(touched.error());
  }
  return {};
}

JointProblem MakeJointProblem(Session* session,
                              const JointOptions& o,
                              const std::vector<Row>& rows) {
  Bench& bench = session->bench();
  JointProblem problem{.machine = bench.machine};
  for (const Axis axis : o.axes) {
    problem.free.push_back(Free("steps_per_mm", Name(axis)));
    // A gap that a hanging load keeps shut is no unknown: nothing shows it.
    if (!WeightKeepsGapShut(axis, bench.machine.axis(axis))) {
      problem.free.push_back(Free("backlash", Name(axis)));
    }
    problem.free.push_back(Free("probe_pretravel", Name(axis)));
  }
  if (o.tilt) {
    problem.free.push_back(Free("bed_tilt", "", 0));
    problem.free.push_back(Free("bed_tilt", "", 1));
  }
  if (o.squareness) problem.free.push_back(Free("squareness", "C0Y"));
  FreeParameter tip = Free("tip_size", "");
  const Given radius_mm = TipRadius(session, o.tip_radius_mm);
  tip.measured = Given{.value = radius_mm.value - bench.machine.probe.tip_radius_mm,
                       .sd = radius_mm.sd};
  problem.free.push_back(tip);
  problem.free.push_back(Free("trigger_latency", ""));
  const double hysteresis_mm = bench.machine.probe.hysteresis_mm;
  problem.nuisances["probe_hysteresis"] =
      o.hysteresis_mm.value_or(Given{.value = hysteresis_mm, .sd = hysteresis_mm / 4});
  problem.loss = o.robust ? Loss::kHuber : Loss::kSquares;
  RowTable table;
  table.rows = rows;
  problem.observations = ObservationsOf(table,
                                        bench.machine,
                                        {.settings = bench.ledger.settings,
                                         .default_sigma_mm = 0.001,
                                         .placement_turns = o.squareness});
  if (const Artefact* ledge =
          SeekArtefact(&bench, "", {ArtefactType::kLedge}, o.place)) {
    LevelLedge(*ledge, bench.machine.probe.disc_radius_mm, rows, &problem.observations);
  }
  return problem;
}

}  // namespace caltwin
