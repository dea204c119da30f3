#include "calibration/diagnosis/kinds/kinds.h"
#include "sim/machine/drive_map.h"

namespace caltwin {
namespace {

// Two belts alike are the baseline's scale; what one does differently is a cause: belts
// of unlike pitch turn a square into a parallelogram, which no other line may take up.
void AddBelts(const Observed& o, NuisanceList* list) {
  const DriveMap& drives = *o.machine().kind->drive_map();
  std::string belts;
  for (int i = 0; i < 3; ++i) {
    if (!drives.is_coupled(i)) continue;
    belts += DriveName(&drives, i);
    AddPlay(o, i, list);
    AddWholeSteps(o, i, list);
  }
  // The first belt's settings stand for both: what differs between them rows are told.
  list->Add(
      "scale." + belts,
      "ppm",
      kScaleSd_ppm,
      [&](Eigen::Index row) {
        double moved_mm = 0;
        for (int i = 0; i < 3; ++i) {
          if (drives.is_coupled(i)) moved_mm += ScaleColumn(o, i, row);
        }
        return moved_mm;
      },
      PpmSetBesideDrawing(o, 0));
}

class CoreXy final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    AddBelts(o, list);
    const int z = Index(Axis::kZ);
    AddScale(o, z, list);
    AddPlay(o, z, list);
    AddWholeSteps(o, z, list);
    for (const Axis axis : kAxes) AddPretravel(o, axis, list);
  }
};

class CoreXyOnScrews final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    AddBelts(o, list);
    AddScrews(o, list);
  }
  void AddPlaces(const Observed& o, NuisanceList* list) const override {
    AddBedPlanes(o, list);
    AddWhatIsTouched(o, list);
    AddFrameOfTracker(o, list);
  }
  bool StandsAnewWhenHomed() const override { return true; }
  int AxisOfMotor(const Drive& drive) const override {
    return drive.is_screw ? Index(Axis::kZ) : drive.index;
  }
  std::optional<double> LeastCounted_mm() const override { return 0; }
};

}  // namespace

const DiagnosedKind& DiagnosedCoreXy() {
  static const CoreXy kind;
  return kind;
}

const DiagnosedKind& DiagnosedCoreXyOnScrews() {
  static const CoreXyOnScrews kind;
  return kind;
}

}  // namespace caltwin
