#include "scenarios/kinds/compare_measured.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/delta/g33.h"
#include "calibration/kinds/delta/klipper_descent.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "scenarios/interrupt.h"
#include "scenarios/kinds/compare_delta.h"
#include "sim/kinds/delta/calliper.h"
#include "sim/machine/kinds/delta/measured.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {
namespace {

constexpr double kRadius_mm = 100;
constexpr double kTouch_mm = 0.01, kCalliper_mm = 0.02;
constexpr double kTenth = 0.1;
constexpr double kLongRod_mm = 250.6;

/// What a task calibrates.
struct Trial {
  DeltaBuild<double> build = MeasuredDelta();
  DeltaBed<double> bed{};
  bool is_noisy = false;
  std::uint64_t seed = 0;
};

/// Sums over the draws of what a calibration leaves.
struct Left {
  double z2_um2 = 0, rod2_um2 = 0;
  double most_um = 0, scale = 0, touches = 0, said_mm = 0, sideways_um = 0;
};

using Engine = DeltaOutcome (*)(const DeltaProbe&, const Trial&);
using Take = double (*)(const Left&);

struct Asked {
  const char* name;
  std::optional<double> there;
  double last_digit;
  Take take;
};

struct Task {
  const char* engine;
  const char* task;
  Engine calibrate;
  Trial trial;
  std::vector<Asked> asked;
  const char* note = "";
};

double Z_um(const Left& left) {
  return std::sqrt(left.z2_um2);
}
double Most_um(const Left& left) {
  return left.most_um;
}
double Scale_um(const Left& left) {
  return left.scale;
}
double Touches(const Left& left) {
  return left.touches;
}
double Said_mm(const Left& left) {
  return left.said_mm;
}
double Rod_um(const Left& left) {
  return std::sqrt(left.rod2_um2);
}
double Sideways_um(const Left& left) {
  return left.sideways_um;
}

DeltaOutcome Klipper(const DeltaProbe& probe, const Trial&) {
  return CalibrateKlipper(
      probe, MeasuredDeltaAsDrawn(), {.points = KlipperProbePoints(kRadius_mm)});
}

DeltaOutcome KlipperWithPrint(const DeltaProbe& probe, const Trial& trial) {
  const DeltaModel<double> start = MeasuredDeltaAsDrawn();
  SimulatedDeltaCalliper calliper(trial.build, kCalliper_mm, trial.seed, 0);
  KlipperOptions options{.points = KlipperProbePoints(kRadius_mm)};
  for (const KlipperRidge& ridge : KlipperPrint()) {
    DeltaDistance distance;
    distance.from_mm =
        DeltaMotors_mm<double>(start, {ridge.first_mm[0], ridge.first_mm[1], 0});
    distance.to_mm =
        DeltaMotors_mm<double>(start, {ridge.second_mm[0], ridge.second_mm[1], 0});
    distance.length_mm = *calliper.Between_mm(distance.from_mm, distance.to_mm);
    options.distances.push_back(distance);
  }
  return CalibrateKlipper(probe, start, options);
}

template <int factors>
DeltaOutcome Rrf(const DeltaProbe& probe, const Trial&) {
  return CalibrateRrf(probe,
                      MeasuredDeltaAsDrawn(),
                      {.factors = factors, .points = RrfProbePoints(kRadius_mm)});
}

// As a person does: until the next run changes nothing that shows.
template <int factors>
DeltaOutcome RrfRepeated(const DeltaProbe& probe, const Trial&) {
  constexpr int kRuns = 4;
  DeltaOutcome outcome{.settings = MeasuredDeltaAsDrawn()};
  for (int run = 0; run < kRuns; ++run) {
    outcome = CalibrateRrf(probe,
                           outcome.settings,
                           {.factors = factors, .points = RrfProbePoints(kRadius_mm)});
  }
  return outcome;
}

template <int points>
DeltaOutcome G33(const DeltaProbe& probe, const Trial&) {
  return CalibrateG33(probe,
                      MeasuredDeltaAsDrawn(),
                      {.points = points,
                       .printable_radius_mm = kRadius_mm,
                       .variant = G33Variant::kAsPublished});
}

// Caltwin's own, of the list that random machines are compared on.
DeltaOutcome Joint(const DeltaProbe& probe, const Trial&) {
  const auto rival = std::ranges::find(DeltaRivals(), "delta_joint", &DeltaRival::name);
  return rival->calibrate(probe, MeasuredDeltaAsDrawn());
}

constexpr const char* kFewDraws =
    "an rms of few draws scatters; how many were drawn there is not known";

Trial Plain() {
  return {};
}
Trial Noisy() {
  return {.is_noisy = true};
}
Trial Rods(bool is_noisy = false) {
  return {.build = MeasuredDelta(kLongRod_mm), .is_noisy = is_noisy};
}
Trial Tilt() {
  return {.bed = MeasuredDeltaTilted()};
}

std::vector<Task> KlipperTasks() {
  return {{"klipper",
           "6 unknowns, 10 um",
           Klipper,
           Noisy(),
           {{"z rms um", 9.4, 0.1, Z_um}}},
          {"klipper",
           "6 unknowns, rods",
           Klipper,
           Rods(),
           {{"z rms um", 5.1, 0.1, Z_um}, {"scale um/mm", 1.9, 0.1, Scale_um}}},
          {"klipper",
           "9 unknowns, 12 distances, 10/20 um",
           KlipperWithPrint,
           Noisy(),
           {{"z rms um", 7.6, 0.1, Z_um}}}};
}

std::vector<Task> RrfTasks() {
  return {{"rrf",
           "6 factors, 10 um",
           Rrf<6>,
           Noisy(),
           {{"z rms um", 4.8, 0.1, Z_um}},
           "what least squares of these points leaves is 5.4 um with the mean of the "
           "heights and 4.7 without: 4.8 is the figure without (no 16 touches leave "
           "less than 5.1 with it)"},
          {"rrf",
           "7 factors, rods, 10 um",
           Rrf<7>,
           Rods(/*is_noisy=*/true),
           {{"z rms um", 5.4, 0.1, Z_um}, {"rod rms um", 391, 1, Rod_um}},
           "points drawn in to 90 mm leave 392 um of the rods, but 6.6 um of the "
           "heights on "
           "the disc of 100 mm; on one of 90 mm 5.7: not explained"},
          {"rrf",
           "6 factors, tilt, one run",
           Rrf<6>,
           Tilt(),
           {{"z rms um", 8.1, 0.1, Z_um}},
           "after one run; see the next row"},
          {"rrf",
           "6 factors, tilt, run until still",
           RrfRepeated<6>,
           Tilt(),
           {{"z rms um", 8.1, 0.1, Z_um}}},
          {"rrf",
           "8 factors, tilt",
           Rrf<8>,
           Tilt(),
           {{"z rms um", 0.015, 0.001, Z_um}},
           "the firmware computes in single precision, which leaves 19 nm; here in "
           "double"}};
}

std::vector<Task> G33Tasks() {
  return {{"g33",
           "P2",
           G33<2>,
           Plain(),
           {{"z rms um", 87, 1, Z_um},
            {"z most um", 261, 1, Most_um},
            {"touches", 28, 1, Touches},
            {"says mm", 0, 0.001, Said_mm}}},
          {"g33",
           "P4",
           G33<4>,
           Plain(),
           {{"z rms um", 0.43, 0.01, Z_um}, {"touches", 160, 1, Touches}}},
          {"g33",
           "P4, 10 um",
           G33<4>,
           Noisy(),
           {{"z rms um", 5.9, 0.1, Z_um}, {"touches", 131, 1, Touches}},
           kFewDraws},
          {"g33",
           "P4, rods",
           G33<4>,
           Rods(),
           {{"z rms um", 4.6, 0.1, Z_um},
            {"scale um/mm", 1.7, 0.1, Scale_um},
            {"says mm", 0.005, 0.001, Said_mm}}},
          {"g33",
           "P4, tilt",
           G33<4>,
           Tilt(),
           {{"z rms um", 11, 1, Z_um},
            {"xy most um", 486, 1, Sideways_um},
            {"says mm", 0, 0.001, Said_mm}}},
          {"g33",
           "P10, 10 um",
           G33<10>,
           Noisy(),
           {{"z rms um", 2.6, 0.1, Z_um}, {"touches", 760, 10, Touches}}}};
}

std::vector<Task> JointTasks() {
  const std::vector<Asked> heights_and_scale = {
      {"z rms um", std::nullopt, 0.1, Z_um},
      {"scale um/mm", std::nullopt, 0.1, Scale_um}};
  return {{"joint", "10 um", Joint, Noisy(), heights_and_scale},
          {"joint", "rods", Joint, Rods(), heights_and_scale},
          {"joint", "rods, 10 um", Joint, Rods(/*is_noisy=*/true), heights_and_scale},
          {"joint", "tilt", Joint, Tilt(), heights_and_scale}};
}

std::vector<Task> AllTasks() {
  std::vector<Task> all = KlipperTasks();
  for (const auto& more : {RrfTasks(), G33Tasks(), JointTasks()}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

// How far the nozzle stands beside where it is sent, at most on the disc. Heights tell
// no common turn of the towers: angles count from tower c, which is built as drawn.
double SidewaysMost_um(const Trial& trial, DeltaModel<double> settings) {
  constexpr int kSteps = 8;
  const double turned_rad = settings.angle_rad[2] - trial.build.model.angle_rad[2];
  for (double& angle_rad : settings.angle_rad) angle_rad -= turned_rad;
  double most_mm = 0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j > kSteps * kSteps) continue;
      const Vec3<double> sent(kRadius_mm * i / kSteps, kRadius_mm * j / kSteps, 0);
      const auto pose = DeltaPoseOf(trial.build, DeltaMotors_mm(settings, sent));
      if (!pose) continue;
      most_mm = std::max(most_mm, double{(pose->nozzle_mm - sent).head<2>().norm()});
    }
  }
  return UmFromMm(most_mm);
}

void Add(const Trial& trial, const DeltaOutcome& outcome, double share, Left* left) {
  // A tilt that the engine fitted is commanded too.
  DeltaBed<double> bed = trial.bed;
  bed.slope_x -= outcome.tilt_x;
  bed.slope_y -= outcome.tilt_y;
  const DeltaAccuracy after =
      DeltaAccuracyOf(trial.build, bed, outcome.settings, kRadius_mm);
  const double rod_um =
      UmFromMm(outcome.settings.arm_mm[0] - trial.build.model.arm_mm[0]);
  left->z2_um2 += share * std::pow(UmFromMm(after.z_rms_mm), 2);
  left->rod2_um2 += share * rod_um * rod_um;
  left->most_um += share * UmFromMm(after.z_most_mm);
  left->scale += share * UmFromMm(after.xy_scale);
  left->touches += share * outcome.touches;
  left->said_mm += share * outcome.said_mm;
  left->sideways_um += share * SidewaysMost_um(trial, outcome.settings);
}

MeasuredTask Perform(const Task& task, int draws, std::uint64_t seed) {
  MeasuredTask performed{.engine = task.engine,
                         .task = task.task,
                         .draws = task.trial.is_noisy ? draws : 1,
                         .note = task.note};
  Left left;
  for (int draw = 0; draw < performed.draws; ++draw) {
    Trial trial = task.trial;
    trial.seed = Rng(seed, static_cast<std::uint64_t>(draw), task.task).Next();
    SimulatedDelta machine(
        trial.build, trial.bed, trial.is_noisy ? kTouch_mm : 0, trial.seed);
    const DeltaOutcome outcome = task.calibrate(
        [&](const DeltaModel<double>& settings, double x_mm, double y_mm) {
          return machine.Touch(settings, x_mm, y_mm);
        },
        trial);
    Add(trial, outcome, 1.0 / performed.draws, &left);
  }
  for (const Asked& asked : task.asked) {
    MeasuredFigure figure{.name = asked.name,
                          .there = asked.there,
                          .last_digit = asked.last_digit,
                          .here = asked.take(left)};
    if (figure.there) {
      const double most =
          task.trial.is_noisy ? kTenth * *figure.there : asked.last_digit;
      figure.is_met = std::abs(figure.here - *figure.there) <= most;
    } else {
      figure.is_met = true;
    }
    performed.figures.push_back(figure);
  }
  return performed;
}

}  // namespace

std::vector<MeasuredTask> CompareMeasuredDelta(
    int draws,
    std::uint64_t seed,
    const std::function<void(const std::string&)>& progress) {
  std::vector<MeasuredTask> tasks;
  for (const Task& task : AllTasks()) {
    if (InterruptRequested()) break;
    progress(fmt::format("{}, {}", task.engine, task.task));
    tasks.push_back(Perform(task, draws, seed));
  }
  return tasks;
}

}  // namespace caltwin
