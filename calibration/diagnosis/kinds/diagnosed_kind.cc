#include "calibration/diagnosis/kinds/diagnosed_kind.h"

#include <cmath>

#include "calibration/diagnosis/rounding.h"
#include "sim/kinds/perform.h"

namespace caltwin {
namespace {

constexpr double kPretravelSd_mm = 0.1;
constexpr double kWholeSteps = 1;  // 1: all of it; 0: a servo, or a finer microstep.

}  // namespace

void DiagnosedKind::AddKinematics(const Observed& o, NuisanceList* builder) const {
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    const auto k = static_cast<std::size_t>(i);
    const AxisDrawing& drawing = o.machine().axis(axis);
    const auto motion = [&](Eigen::Index row) {
      return o.MotionSign(row) * o.at(row).n[i];
    };
    const double set = o.machine().settings.steps_per_mm[k];
    const double set_ppm = set > 0 ? (set / drawing.steps_per_mm() - 1) * 1e6 : 0;
    builder->Add(
        "scale." + Name(axis),
        "ppm",
        kScaleSd_ppm,
        [&](Eigen::Index row) {
          return motion(row) * (o.at(row).q_mm[i] - drawing.home_mm()) * 1e-6;
        },
        set_ppm);
    builder->Add("backlash." + Name(axis), "mm", kBacklashSd_mm, [&](Eigen::Index row) {
      return -motion(row) * o.at(row).dir[i] / 2;
    });
    // Whether its controller stands at whole steps, the rows say.
    builder->Add(
        "whole_steps." + Name(axis),
        "",
        kWholeSteps,
        [&](Eigen::Index row) { return motion(row) * RoundedBy_mm(o, row, axis); },
        /*offset=*/0,
        /*reported=*/false);
    builder->Add(
        "probe_pretravel." + Name(axis),
        "mm",
        kPretravelSd_mm,
        [&](Eigen::Index row) {
          if (o.at(row).kind != RowKind::kTouch) return 0.0;
          // Of 1 / sqrt(sum (n_i / p_i)^2) by p_i.
          const Vec3<double>& p_mm = o.pretravel_mm();
          const Vec3<double>& n = o.at(row).n;
          const double along_mm = 1 / n.cwiseQuotient(p_mm).norm();
          return -n[i] * n[i] * std::pow(along_mm / p_mm[i], 3);
        },
        o.pretravel_mm()[i]);
  }
}

void DiagnosedKind::AddPlaces(const Observed& o, NuisanceList* list) const {
  AddBedPlane(o, list);
  AddWhatIsTouched(o, list);
}

std::shared_ptr<const void> DiagnosedKind::PoseAnywhere(const Observed& observed,
                                                        const Settings& settings,
                                                        Rng* rng,
                                                        At* at) const {
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = observed.machine().axis(axis);
    const auto i = static_cast<std::size_t>(Index(axis));
    at->q_mm[Index(axis)] = drawing.min_mm + rng->Uniform() * drawing.travel_mm();
    at->dir[Index(axis)] = rng->Uniform() < 1.0 / 2 ? -1 : 1;
    at->steps_per_mm[Index(axis)] = settings.steps_per_mm[i];
    at->compensation_mm[Index(axis)] = settings.backlash_mm[i];
  }
  return nullptr;
}

RowTable DiagnosedKind::Performed(const Observed& observed,
                                  const ReplayedTwin& twin) const {
  return Perform({.machine = observed.machine(),
                  .effects = twin.effects,
                  .header = observed.header(),
                  .fidelity = twin.fidelity,
                  .is_noisy = false,
                  .interrupted = twin.interrupted},
                 observed.table().rows);
}

std::string_view DiagnosedKind::FewestRowsHint() const {
  return "a positioning test takes 5 positions, both senses, twice";
}

std::vector<CorrectionFile> DiagnosedKind::Correction(ControllerKind controller,
                                                      const Diagnosis& diagnosis,
                                                      const Observed& observed,
                                                      const std::string& name) const {
  return CorrectionOfAxes(controller, diagnosis, observed, name);
}

}  // namespace caltwin
