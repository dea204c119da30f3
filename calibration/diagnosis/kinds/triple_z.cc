#include <algorithm>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/kinds.h"
#include "calibration/diagnosis/kinds/triple_z_correction.h"
#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"

namespace caltwin {

void AddScrews(const Observed& o, NuisanceList* builder) {
  const int z = Index(Axis::kZ);
  const AxisDrawing& drawing = o.machine().axis(Axis::kZ);
  const auto motion = [&](Eigen::Index row) {
    return o.MotionSign(row) * o.at(row).n[z];
  };
  const double set = o.machine().settings.steps_per_mm[static_cast<std::size_t>(z)];
  builder->Add(
      "scale.z",
      "ppm",
      kScaleSd_ppm,
      [&](Eigen::Index row) {
        const Vec3<double>& weights = o.at(row).screws->weights;
        return -motion(row) * weights.dot(*ScrewsOf_mm(o.at(row))) * 1e-6;
      },
      set > 0 ? (set / drawing.steps_per_mm() - 1) * 1e6 : 0);
  builder->Add("backlash.z", "mm", kBacklashSd_mm, [&](Eigen::Index row) {
    return -motion(row) * o.at(row).dir[z] / 2;
  });
}

namespace {

class TripleZ final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    AddScrews(o, list);
  }
  void AddPlaces(const Observed& o, NuisanceList* list) const override {
    AddBedPlanes(o, list);
    AddWhatIsTouched(o, list);
  }
  bool StandsAnewWhenHomed() const override { return true; }

  // Screws under a bed are its z.
  int AxisOfMotor(const Drive& drive) const override {
    return drive.is_motor ? Index(Axis::kZ) : drive.index;
  }

  // All screws moving alike.
  void AddUnseen(const Observed& observed,
                 const std::vector<Candidate>& candidates,
                 Diagnosis* diagnosis) const override {
    bool is_any_unmoved = false;
    for (const int effect : {EffectIndex<PivotPosition>(),
                             EffectIndex<MotorsSwapped>(),
                             EffectIndex<OverconstrainedBed>()}) {
      const bool is_shown = std::ranges::any_of(
          candidates, [&](const Candidate& one) { return one.effect == effect; });
      if (is_shown) continue;
      is_any_unmoved = true;
      for (const std::string_view axis :
           AxesOn(EffectAt(effect), observed.machine().kind)) {
        diagnosis->absorbed.push_back(
            {axis.empty() ? std::string(EffectAt(effect).name)
                          : fmt::format("{}.{}", EffectAt(effect).name, axis),
             "all screws move alike"});
      }
    }
    if (!is_any_unmoved) return;
    diagnosis->remarks.push_back(
        "No row moves a screw alone, so where the screws stand, whether two motors are "
        "exchanged and whether the bed is held level cannot be seen: the campaign "
        "screws_one_by_one shows them");
  }

  std::optional<double> LeastCounted_mm() const override { return 0; }

  void RequireSettings(ControllerKind controller) const override {
    RequireScrewLevelling(controller);
  }
  std::vector<CorrectionFile> Correction(ControllerKind controller,
                                         const Diagnosis& diagnosis,
                                         const Observed& observed,
                                         const std::string&) const override {
    return {{.text = TripleZCorrectionText(controller, diagnosis, observed)}};
  }
};

}  // namespace

const DiagnosedKind& DiagnosedTripleZ() {
  static const TripleZ kind;
  return kind;
}

}  // namespace caltwin
