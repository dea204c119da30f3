#include "calibration/diagnosis/kinds/diagnosed_kind.h"

#include <cmath>

#include "calibration/diagnosis/rounding.h"
#include "sim/kinds/perform.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr double kPretravelSd_mm = 0.1;
constexpr double kWholeSteps = 1;  // 1: all of it; 0: a servo, or a finer microstep.

// How a drive's motion shows in a row.
double Motion(const Observed& o, int drive, Eigen::Index row) {
  const DriveMap* drives = o.machine().kind->drive_map();
  const Vec3<double>& n = o.at(row).n;
  const double along =
      drives == nullptr ? n[drive] : n.dot(drives->axes_by_drive.col(drive));
  return o.MotionSign(row) * along;
}

}  // namespace

double ScaleColumn(const Observed& o, int drive, Eigen::Index row) {
  const At& at = o.at(row);
  const double from_home_mm =
      at.drives ? DrivesOf(at.drives->map, at.q_mm)[drive] - at.drives->home_mm[drive]
                : at.q_mm[drive] -
                      o.machine().axes[static_cast<std::size_t>(drive)].home_mm();
  return Motion(o, drive, row) * from_home_mm * 1e-6;
}

double PpmSetBesideDrawing(const Observed& o, int drive) {
  const auto k = static_cast<std::size_t>(drive);
  const double set = o.machine().settings.steps_per_mm[k];
  return set > 0 ? (set / o.machine().axes[k].steps_per_mm() - 1) * 1e6 : 0;
}

void AddScale(const Observed& o, int drive, NuisanceList* list) {
  list->Add(
      "scale." + DriveName(o.machine().kind->drive_map(), drive),
      "ppm",
      kScaleSd_ppm,
      [&](Eigen::Index row) { return ScaleColumn(o, drive, row); },
      PpmSetBesideDrawing(o, drive));
}

void AddPlay(const Observed& o, int drive, NuisanceList* list) {
  list->Add("backlash." + DriveName(o.machine().kind->drive_map(), drive),
            "mm",
            kBacklashSd_mm,
            [&](Eigen::Index row) {
              return -Motion(o, drive, row) * DriveSense(o.at(row), drive) / 2;
            });
}

// Where some rows say their load and others do not, nobody knows what those turned
// round under.
void AddPlayOfNoLoad(const Observed& o, int drive, NuisanceList* list) {
  constexpr double kByLoad_mm = 0.05;
  bool has_load = false;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) has_load |= Known(o.row(i).load_n);
  if (!has_load) return;
  list->Add(
      "backlash_without_load." + DriveName(o.machine().kind->drive_map(), drive),
      "mm",
      kByLoad_mm,
      [&](Eigen::Index row) {
        return Known(o.row(row).load_n)
                   ? 0.0
                   : -Motion(o, drive, row) * DriveSense(o.at(row), drive) / 2;
      },
      /*offset=*/0,
      /*reported=*/false);
}

// Whether its controller stands at whole steps, the rows say.
void AddWholeSteps(const Observed& o, int drive, NuisanceList* list) {
  list->Add(
      "whole_steps." + DriveName(o.machine().kind->drive_map(), drive),
      "",
      kWholeSteps,
      [&](Eigen::Index row) {
        return Motion(o, drive, row) * RoundedBy_mm(o, row, drive);
      },
      /*offset=*/0,
      /*reported=*/false);
}

void AddPretravel(const Observed& o, Axis axis, NuisanceList* list) {
  const int i = Index(axis);
  list->Add(
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

void DiagnosedKind::AddKinematics(const Observed& o, NuisanceList* list) const {
  for (const Axis axis : kAxes) {
    AddScale(o, Index(axis), list);
    AddPlay(o, Index(axis), list);
    AddPlayOfNoLoad(o, Index(axis), list);
    AddWholeSteps(o, Index(axis), list);
    AddPretravel(o, axis, list);
  }
}

void DiagnosedKind::AddPlaces(const Observed& o, NuisanceList* list) const {
  AddBedPlane(o, list);
  AddWhatIsTouched(o, list);
  AddFrameOfTracker(o, list);
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
  if (at->drives) {
    for (int i = 0; i < 3; ++i) {
      at->drives->dir[i] = rng->Uniform() < 1.0 / 2 ? -1 : 1;
    }
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
