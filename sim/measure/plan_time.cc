// Campaigns in which time passes: alternating faces, re-homing, drift.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

// Shares of a run from cold in which heat sources are on: the bed starts later, so that
// its temperature does not go along with the frame's.
constexpr double kSpindleOff = 0.5;
constexpr double kBedOn = 0.2;
constexpr double kBedOff = 0.65;

struct Spot {
  std::string setup{}, feature{};
  Vec3<double> at_mm = Vec3<double>::Zero();
  Vec3<double> n = Vec3<double>::UnitZ();
};

void TouchSpot(const Spot& spot,
               const PlannedCampaign& campaign,
               int rep,
               MeasuringSession* session) {
  for (const double feed_mm_s : campaign.options.Numbers("feeds_mm_s")) {
    Row row = TouchOf(spot.setup, spot.feature, spot.at_mm, spot.n);
    row.rep = rep;
    row.feed_mm_s = feed_mm_s;
    session->Touch(std::move(row));
  }
}

void HeatFor(double duration_s, double warm_up_k, MeasuringSession* session) {
  session->Heat({.spindle_on_s = 0,
                 .spindle_off_s = kSpindleOff * duration_s,
                 .bed_on_s = kBedOn * duration_s,
                 .bed_off_s = kBedOff * duration_s,
                 .screw_rise_k = warm_up_k,
                 .frame_rise_k = 0.4 * warm_up_k,
                 .bed_rise_k = 0.6 * warm_up_k});
}

// The two faces of something across an axis.
std::vector<Spot> BothFaces(const std::string& setup,
                            const std::string& id,
                            Axis axis,
                            const Vec3<double>& center_mm,
                            double half_mm) {
  std::vector<Spot> spots;
  for (const double sign : {-1.0, 1.0}) {
    const char* face = axis == Axis::kX   ? (sign < 0 ? "left" : "right")
                       : axis == Axis::kY ? (sign < 0 ? "front" : "back")
                                          : (sign < 0 ? "bottom" : "top");
    spots.push_back({.setup = setup,
                     .feature = fmt::format("{}.{}", id, face),
                     .at_mm = center_mm + sign * half_mm * Unit(axis),
                     .n = sign * Unit(axis)});
  }
  return spots;
}

Vec3<double> OnTable(const MeasuringSession& session, double height_mm) {
  Vec3<double> at_mm = session.Middle_mm();
  at_mm[2] = height_mm;
  return at_mm;
}

}  // namespace

void PlanAlternating(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const int pairs = options.Count("pairs");
  const double interval_s = options.Number("interval_s");
  const Axis axis = options.axis("axis");
  const std::string id = ArtefactId(campaign, "datum");
  // Across z only a lip has two faces: 8 mm thick, above the table.
  const bool is_lip = axis == Axis::kZ;
  const double half_mm = is_lip ? 4 : 25;
  session->Certify(
      id,
      is_lip
          ? CertifiedArtefact{.type = "ledge", .sizes_mm = {8}, .u_um = 0.5}
          : CertifiedArtefact{.type = "block", .sizes_mm = {50, 50, 25}, .u_um = 0.5});
  const auto spots =
      BothFaces(campaign.name, id, axis, OnTable(*session, is_lip ? 36 : 12), half_mm);
  if (options.Flag("from_cold")) HeatFor(pairs * interval_s, 10, session);
  for (int pair = 1; pair <= pairs; ++pair) {
    const double began_s = session->now_s();
    for (const Spot& spot : spots) TouchSpot(spot, campaign, pair, session);
    session->Wait(std::max(0.0, interval_s - (session->now_s() - began_s)));
  }
}

void PlanRehoming(const PlannedCampaign& campaign, MeasuringSession* session) {
  const std::string id = ArtefactId(campaign, "cube");
  session->Certify(id, {.type = "block", .sizes_mm = {50, 50, 25}, .u_um = 0.5});
  const Vec3<double> center_mm = OnTable(*session, 0);
  const std::vector<Spot> spots = {
      {campaign.name, id + ".left", center_mm + Vec3<double>(-25, 0, 12), {-1, 0, 0}},
      {campaign.name, id + ".front", center_mm + Vec3<double>(0, -25, 12), {0, -1, 0}},
      {campaign.name, id + ".top", center_mm + Vec3<double>(0, 0, 25), {0, 0, 1}}};
  for (int homing = 0; homing < campaign.options.Count("homings"); ++homing) {
    session->Home();
    for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
      for (const Spot& spot : spots) TouchSpot(spot, campaign, rep, session);
    }
  }
}

void PlanDrift(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const Axis axis = options.axis("axis");
  const double duration_s = options.Number("duration_s");
  const double interval_s = options.Number("interval_s");
  const double reach_mm = session->machine().axis(axis).travel_mm() / 2 - 30;
  if (reach_mm < 20) {
    session->Fail("has no room for two posts", "the axis is too short for it");
  }
  std::vector<Spot> round;
  for (const int post : {1, 2}) {
    const std::string id = fmt::format("post{}", post);
    session->Certify(id, {.type = "post"});
    const Vec3<double> at_mm =
        OnTable(*session, 15) + (post == 1 ? -reach_mm : reach_mm) * Unit(axis);
    const auto faces = BothFaces(campaign.name + "_" + id, id, axis, at_mm, 10);
    round.insert(round.end(), faces.begin(), faces.end());
  }
  const std::string lip = ArtefactId(campaign, "lip");
  session->Certify(lip, {.type = "ledge", .sizes_mm = {8}, .u_um = 0.5});
  const auto both =
      BothFaces(campaign.name + "_lip", lip, Axis::kZ, OnTable(*session, 36), 4);
  round.insert(round.end(), both.begin(), both.end());
  if (options.Flag("from_cold")) {
    HeatFor(duration_s, options.Number("warm_up_k"), session);
  }
  const double end_s = session->now_s() + duration_s;
  for (int rep = 1; session->now_s() < end_s; ++rep) {
    const double began_s = session->now_s();
    Shuffle(&round, session->rng());
    for (const Spot& spot : round) TouchSpot(spot, campaign, rep, session);
    session->Wait(std::max(0.0, interval_s - (session->now_s() - began_s)));
  }
}

}  // namespace caltwin
