#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "sim/machine/machine_kind.h"
#include "sim/measure/plan.h"

namespace caltwin {

class MeasuringSession;

/// What plans a campaign on one kind of machine.
struct PlannedOn {
  std::string_view kind{};  ///< Its word in files.
  /// Adds the campaign's readings to the session.
  void (*plan)(const PlannedCampaign& campaign, MeasuringSession* session) = nullptr;
};

/// A kind of measuring campaign: what `caltwin explain` says of it and how its readings
/// are planned.
struct CampaignKind {
  std::string_view id;
  std::string_view about;
  std::string_view shows;       ///< Causes it is for, and why.
  std::string_view instrument;  ///< Default id of the instrument.
  std::span<const PlanOption> options;
  std::array<PlannedOn, 2> on{};

  /// What plans it on that machine; null: nothing does.
  auto PlanOn(const MachineKind* kind) const {
    const std::array own = {kind->name()};
    const auto as = kind->plans_as().empty() ? std::span<const std::string_view>(own)
                                             : kind->plans_as();
    for (const PlannedOn& one : on) {
      const bool is_so = std::ranges::find(as, one.kind) != as.end();
      if (one.plan != nullptr && is_so) return one.plan;
    }
    return PlannedOn{}.plan;
  }
};

/// Every kind there is, gantry's first.
std::span<const CampaignKind> AllCampaignKinds();
/// Null where there is none.
const CampaignKind* FindCampaignKind(std::string_view id);

/// @name How each kind is performed: plan_gauge.cc, plan_touch.cc, plan_edges.cc,
/// plan_time.cc; kinds/
void PlanIso230(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDense(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanAbbe(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanBallbar(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanStraightedge(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanSquare(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanBlocks(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanPlate(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanPlateTurned90(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanRing(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanAlternating(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanRehoming(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDeltaGrid(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDeltaXy(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanZColumns(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDeltaRing(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanTzGrid(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanTzHeights(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanFixedPost(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanScrewsOneByOne(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanZOffset(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDiagonals(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanZGap(const PlannedCampaign& campaign, MeasuringSession* session);
void PlanDrift(const PlannedCampaign& campaign, MeasuringSession* session);

}  // namespace caltwin
