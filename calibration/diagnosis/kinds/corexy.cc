#include "calibration/diagnosis/kinds/kinds.h"
#include "sim/machine/drive_map.h"

namespace caltwin {
namespace {

// Two belts alike are the baseline's scale, as the words on a machine's motors have it;
// what one does differently is a cause: belts of unlike pitch turn a square into a
// parallelogram, which no other baseline line may take up.
class CoreXy final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    const DriveMap& drives = *o.machine().kind->drive_map();
    std::string belts;
    for (int i = 0; i < 3; ++i) {
      if (drives.is_coupled(i)) {
        belts += DriveName(&drives, i);
      } else {
        AddScale(o, i, list);
      }
      AddPlay(o, i, list);
      AddWholeSteps(o, i, list);
      AddPretravel(o, kAxes[static_cast<std::size_t>(i)], list);
    }
    // The first belt's settings stand for both: what differs between them rows are
    // told.
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
        SetBeside_ppm(o, 0));
  }
};

}  // namespace

const DiagnosedKind& DiagnosedCoreXy() {
  static const CoreXy kind;
  return kind;
}

}  // namespace caltwin
