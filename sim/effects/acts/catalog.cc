#include "sim/effects/catalog.h"

#include <array>

#include "sim/effects/acts/acts.h"
#include "sim/effects/acts/edits.h"

namespace caltwin {
namespace {

constexpr std::array kActs = {
    ActOf{EffectIndex<StepsPerMm>(), ActKind::kDriveMap},
    ActOf{EffectIndex<Backlash>(), ActKind::kEditModel, EditBacklash},
    ActOf{EffectIndex<WindupLoad>(), ActKind::kEditModel, EditWindupLoad},
    ActOf{EffectIndex<CyclicLead>(), ActKind::kDriveMap},
    ActOf{EffectIndex<PulleyEccentric>(), ActKind::kDriveMap},
    ActOf{EffectIndex<Microstep>(), ActKind::kDriveMap},
    ActOf{EffectIndex<PitchProgressive>(), ActKind::kDriveMap},
    ActOf{EffectIndex<PitchMap>(), ActKind::kDriveMap},
    ActOf{EffectIndex<BacklashWorn>(), ActKind::kDriveMap},
    ActOf{EffectIndex<ReversalSpike>(), ActKind::kDriveMap},
    ActOf{EffectIndex<ThermalScrew>(), ActKind::kDriveMap},
    ActOf{EffectIndex<MissedSteps>(), ActKind::kDriveMap},
    ActOf{EffectIndex<HomingScatter>(), ActKind::kDriveMap},
    ActOf{EffectIndex<Squareness>(), ActKind::kEditModel, EditSquareness},
    ActOf{EffectIndex<Straightness>(), ActKind::kEditModel, EditStraightness},
    ActOf{EffectIndex<Angular>(), ActKind::kEditModel, EditAngular},
    ActOf{EffectIndex<GantrySag>(), ActKind::kEditModel, EditGantrySag},
    ActOf{EffectIndex<AxisTwist>(), ActKind::kEditModel, EditAxisTwist},
    ActOf{EffectIndex<Racking>(), ActKind::kEditModel, EditRacking},
    ActOf{EffectIndex<BeltPitch>(), ActKind::kLinkBuild},
    ActOf{EffectIndex<CarriageBacklash>(), ActKind::kDriveMap},
    ActOf{EffectIndex<RodMismatch>(), ActKind::kLinkBuild},
    ActOf{EffectIndex<TowerLean>(), ActKind::kLinkBuild},
    ActOf{EffectIndex<TowerTwist>(), ActKind::kLinkBuild},
    ActOf{EffectIndex<TowerRadius>(), ActKind::kLinkBuild},
    ActOf{EffectIndex<EffectorTilt>(), ActKind::kReadingMap},
    ActOf{EffectIndex<ScrewPitch>(), ActKind::kDriveMap},
    ActOf{EffectIndex<ScrewCyclic>(), ActKind::kDriveMap},
    ActOf{EffectIndex<ScrewBacklash>(), ActKind::kDriveMap},
    ActOf{EffectIndex<PivotPosition>(), ActKind::kScrewBuild},
    ActOf{EffectIndex<MotorsSwapped>(), ActKind::kDriveMap},
    ActOf{EffectIndex<OverconstrainedBed>(), ActKind::kScrewBuild},
    ActOf{EffectIndex<ServoMismatch>(), ActKind::kReadingMap},
    ActOf{EffectIndex<ServoLag>(), ActKind::kReadingMap},
    ActOf{EffectIndex<FrameGrowth>(), ActKind::kReadingMap},
    ActOf{EffectIndex<FrameTemperature>(), ActKind::kReadingMap},
    ActOf{EffectIndex<RandomWalk>(), ActKind::kReadingMap},
    ActOf{EffectIndex<ProbePretravel>(), ActKind::kReadingMap},
    ActOf{EffectIndex<ProbeTemperature>(), ActKind::kReadingMap},
    ActOf{EffectIndex<ProbeLobing>(), ActKind::kReadingMap},
    ActOf{EffectIndex<StylusAnisotropy>(), ActKind::kReadingMap},
    ActOf{EffectIndex<TipRunout>(), ActKind::kReadingMap},
    ActOf{EffectIndex<TipSize>(), ActKind::kEditModel, EditTipSize},
    ActOf{EffectIndex<TriggerLatency>(), ActKind::kReadingMap},
    ActOf{EffectIndex<TriggerScatter>(), ActKind::kReadingMap},
    ActOf{EffectIndex<NozzleTemperature>(), ActKind::kStationMap},
    ActOf{EffectIndex<Ooze>(), ActKind::kStationMap},
    ActOf{EffectIndex<SwitchOffset>(), ActKind::kStationMap},
    ActOf{EffectIndex<StationChange>(), ActKind::kStationMap},
    ActOf{EffectIndex<BedTilt>(), ActKind::kEditModel, EditBedTilt},
    ActOf{EffectIndex<BedBowl>(), ActKind::kTableMap},
    ActOf{EffectIndex<BedCylinder>(), ActKind::kTableMap},
    ActOf{EffectIndex<BedTwist>(), ActKind::kTableMap},
    ActOf{EffectIndex<BlockSize>(), ActKind::kArtefactMap},
    ActOf{EffectIndex<BlockRotated>(), ActKind::kArtefactMap},
    ActOf{EffectIndex<UnknownMap>(), ActKind::kReadingMap}};
static_assert(kActs.size() == kNumEffects);

}  // namespace

std::span<const ActOf> AllActs() {
  return kActs;
}

void EditModel(const Machine& machine, std::span<const Injected> effects, Mjcf* model) {
  // In the catalog's order, so that a gap is there before the spring beyond it.
  for (const ActOf& act : kActs) {
    for (const Injected& injected : effects) {
      if (injected.effect == act.effect && act.edit != nullptr) {
        act.edit(machine, injected, model);
      }
    }
  }
}

}  // namespace caltwin
