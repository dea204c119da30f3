#include "sim/measure/plan_kinds.h"

#include <algorithm>
#include <array>

#include "sim/measure/kinds/corexy_options.h"
#include "sim/measure/kinds/delta_options.h"
#include "sim/measure/kinds/triple_z_options.h"
#include "sim/measure/kinds/z_station_options.h"
#include "sim/measure/plan_options_gauge.h"
#include "sim/measure/plan_options_touch.h"

namespace caltwin {
namespace {

namespace of = plan_options;

constexpr std::array kKinds = {
    CampaignKind{
        "iso230",
        "A laser reads one axis at many targets, from both senses (ISO 230-2).",
        "Scale, pitch, screw or pulley waves, backlash and worn backlash; with "
        "two loads wind-up.",
        "laser",
        of::kIso230,
        {{{"cartesian", PlanIso230}}}},
    CampaignKind{"dense",
                 "A laser reads one axis in fine steps over 2.5 turns of its screw.",
                 "Waves of screw, pulley and motor steps, and the reversal itself.",
                 "laser",
                 of::kDense,
                 {{{"cartesian", PlanDense}}}},
    CampaignKind{"abbe",
                 "The same laser line at two places of another axis.",
                 "Angular errors: pitch, yaw and roll act by their lever.",
                 "laser",
                 of::kAbbe,
                 {{{"cartesian", PlanAbbe}}}},
    CampaignKind{"straightedge",
                 "The probe touches both sides of a straight-edge along an axis.",
                 "Straightness; both sides tell the edge's own bow from the machine's.",
                 "probe",
                 of::kStraightedge,
                 {{{"cartesian", PlanStraightedge}}}},
    CampaignKind{"square",
                 "The probe touches both legs of a square, then the square turned.",
                 "Squareness, apart from the square's own error.",
                 "probe",
                 of::kSquare,
                 {{{"cartesian", PlanSquare}}}},
    CampaignKind{"blocks",
                 "The probe touches the five free faces of a 1-2-3 block laid in three "
                 "ways.",
                 "Scale against backlash, pre-travel and tip; with two blocks a wrong "
                 "block; with three feeds trigger latency.",
                 "probe",
                 of::kBlocks,
                 {{{"cartesian", PlanBlocks}}}},
    CampaignKind{"plate",
                 "The probe touches a flat plate on a grid.",
                 "Bed plane and shape, sag of the gantry; with two probe offsets a "
                 "twist of the beam.",
                 "probe",
                 of::kPlate,
                 {{{"cartesian", PlanPlate}, {"triple_z", PlanPlate}}}},
    CampaignKind{"plate_turned_90",
                 "The same plate, turned by a quarter.",
                 "What turns with the plate is the plate's; what does not, the "
                 "machine's: gantry sag against a curved bed.",
                 "probe",
                 of::kPlate,
                 {{{"cartesian", PlanPlateTurned90}, {"triple_z", PlanPlateTurned90}}}},
    CampaignKind{
        "ring",
        "The probe touches the bore of a ring all around, the spindle turned in "
        "steps; a delta's nozzle touches its bed on three circles.",
        "Lobing, stylus anisotropy, run-out and size of the tip.",
        "probe",
        of::kRing,
        {{{"cartesian", PlanRing}, {"delta", PlanDeltaRing}}}},
    CampaignKind{"ballbar",
                 "A ball-bar reads circles in both senses at two feeds.",
                 "Servo mismatch and lag, reversal spikes, squareness, scale mismatch.",
                 "ballbar",
                 of::kBallbar,
                 {{{"cartesian", PlanBallbar}}}},
    CampaignKind{"alternating",
                 "The probe touches two opposite faces in turn, for an hour from cold.",
                 "Drift of probe and machine: what has the sign of the face is the "
                 "probe's.",
                 "probe",
                 of::kAlternating,
                 {{{"cartesian", PlanAlternating}}}},
    CampaignKind{"rehoming",
                 "The probe touches three faces of a datum after each of many homings.",
                 "Scatter of homing, lost steps.",
                 "probe",
                 of::kRehoming,
                 {{{"cartesian", PlanRehoming}}}},
    CampaignKind{"drift",
                 "The probe touches two far posts, and a lip from above and below, for "
                 "hours through warm-up and cool-down.",
                 "Heat of screws, frame, bed and probe; growth with time.",
                 "probe",
                 of::kDrift,
                 {{{"cartesian", PlanDrift}}}},
    CampaignKind{"delta_grid",
                 "The nozzle of a delta touches its bed all over the disc.",
                 "Endstops, radius, angles, the bed's plane and shape, unlike rods.",
                 "probe",
                 of::kDeltaGrid,
                 {{{"delta", PlanDeltaGrid}}}},
    CampaignKind{"delta_xy",
                 "A camera or dial on a delta reads marks of a plate along x and y.",
                 "Rod length and scale, leaning towers, belts: what heights alone "
                 "cannot tell apart.",
                 "camera",
                 of::kDeltaXy,
                 {{{"delta", PlanDeltaXy}}}},
    CampaignKind{
        "z_columns",
        "A height gauge reads columns over a delta's bed, from above and below.",
        "Leaning towers and belts, which grow with height; play of carriages.",
        "height_gauge",
        of::kZColumns,
        {{{"delta", PlanZColumns}}}},
    CampaignKind{
        "tz_grid",
        "The nozzle touches a bed that stands on three screws on a grid.",
        "The bed's plane and shape, sag of the gantry; with two probe offsets a "
        "twist of its beam.",
        "probe",
        of::kTzGrid,
        {{{"triple_z", PlanTzGrid}}}},
    CampaignKind{
        "tz_heights",
        "A distance sensor on the head reads the bed on a grid at many heights, "
        "moved there from above and from below.",
        "Pitch, waves and play of single screws, a gantry that leans.",
        "laser",
        of::kTzHeights,
        {{{"triple_z", PlanTzHeights}}}},
    CampaignKind{"fixed_post",
                 "An indicator on a post that stands on the frame reads the bed over "
                 "each screw at many heights.",
                 "What is the screws' alone: a gantry that leans does not move it.",
                 "indicator",
                 of::kFixedPost,
                 {{{"triple_z", PlanFixedPost}}}},
    CampaignKind{
        "screws_one_by_one",
        "Each screw is moved up and down alone, and the bed touched on a grid.",
        "Where the screws truly stand, and motors plugged into each other's "
        "drivers: invisible while all move alike.",
        "probe",
        of::kScrewsOneByOne,
        {{{"triple_z", PlanScrewsOneByOne}}}},
    CampaignKind{
        "diagonals",
        "A laser reads both diagonals of a CoreXY, along which one belt moves alone.",
        "Play and waves of one belt apart from the other's; with readings across, "
        "belts "
        "of unlike pitch and a racked beam.",
        "laser",
        of::kDiagonals,
        {{{"corexy", PlanDiagonals}}}},
    CampaignKind{
        "z_offset",
        "The three touches of a nozzle's calibration (nozzle and probe on the "
        "switch, probe on the bed), again and again, cold and hot.",
        "Growth of nozzle, bed and probe, ooze, a nozzle or plate that was changed.",
        "probe",
        of::kZOffset,
        {{{"z_station", PlanZOffset}}}},
    CampaignKind{
        "z_gap",
        "Calibrated, and the gap under the nozzle then measured with a feeler gauge, "
        "cold and hot.",
        "What no touch of a switch sees: a wrong switch_offset; ooze against growth.",
        "feeler",
        of::kZGap,
        {{{"z_station", PlanZGap}}}}};

}  // namespace

std::span<const CampaignKind> AllCampaignKinds() {
  return kKinds;
}

const CampaignKind* FindCampaignKind(std::string_view id) {
  const auto found = std::ranges::find(kKinds, id, &CampaignKind::id);
  return found == kKinds.end() ? nullptr : &*found;
}

}  // namespace caltwin
