#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/kinds/delta/klipper_fit.h"
#include "calibration/kinds/delta/mesh_shape.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/kinds/klipper_delta.h"
#include "sim/measure/import/klipper_mesh.h"
#include "tests/measure/import_bench.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 0.01;

DeltaModel<double> Built() {
  DeltaModel<double> model = SymmetricDelta(300, 150, 315);
  model.radius_mm.fill(150.7);
  model.endstop_mm = {300.4, 299.8, 300.1};
  model.angle_rad[0] += RadFromDeg(0.3);
  model.angle_rad[1] -= RadFromDeg(0.2);
  return model;
}

/// Touches of a flat bed by that machine at Klipper's seven places.
std::vector<DeltaTouch> Touches(const DeltaModel<double>& built) {
  constexpr std::array kScatter = {0.95, 0.90, 0.85, 0.70, 0.75, 0.80};
  std::vector<DeltaTouch> touches = {
      {.motors_mm = DeltaMotors_mm<double>(built, {0, 0, 16}),
       .height_mm = 16,
       .sigma_mm = kSigma_mm}};
  for (std::size_t i = 0; i < kScatter.size(); ++i) {
    const double angle_rad = RadFromDeg(90.0 + 60.0 * static_cast<double>(i));
    const double r_mm = 130 * kScatter[i];
    touches.push_back(
        {.motors_mm = DeltaMotors_mm<double>(
             built, {r_mm * std::cos(angle_rad), r_mm * std::sin(angle_rad), 16}),
         .height_mm = 16,
         .sigma_mm = kSigma_mm});
  }
  return touches;
}

/// A saved calibration as the fit takes it, weighted as Klipper weighs.
struct Problem {
  std::vector<DeltaTouch> touches{};
  std::vector<DeltaDistance> distances{};
  DeltaModel<double> saved{};
};

Problem ProblemOf(const KlipperCalibration& read) {
  Problem problem{.saved = read.geometry.model};
  for (const KlipperTouch& touch : read.touches) {
    problem.touches.push_back({touch.motors_mm, touch.height_mm, kSigma_mm});
  }
  const double sigma_mm =
      KlipperDistanceSigma_mm(kSigma_mm, read.touches.size(), read.distances.size());
  for (const KlipperDistance& distance : read.distances) {
    problem.distances.push_back(
        {distance.length_mm, distance.from_mm, distance.to_mm, sigma_mm});
  }
  return problem;
}

KlipperAssessment Assess(const Problem& problem) {
  return AssessKlipper(problem.touches, problem.distances, problem.saved);
}

double FarthestEndstop_mm(const DeltaModel<double>& one,
                          const DeltaModel<double>& other) {
  double farthest_mm = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    farthest_mm =
        std::max(farthest_mm, std::abs(one.endstop_mm[i] - other.endstop_mm[i]));
  }
  return farthest_mm;
}

TEST(KlipperFit, RecoversATruthFromTheDrawing) {
  const DeltaModel<double> built = Built();

  const KlipperFit fit =
      FitKlipperModel(Touches(built), {}, SymmetricDelta(300, 150, 315), kKlipperSix);

  EXPECT_TRUE(fit.is_converged);
  EXPECT_TRUE(fit.last_step.identifiable);
  EXPECT_NEAR(fit.model.radius_mm[0], built.radius_mm[0], 1e-7);
  EXPECT_NEAR(fit.model.angle_rad[0], built.angle_rad[0], 1e-9);
  EXPECT_NEAR(fit.model.angle_rad[1], built.angle_rad[1], 1e-9);
  EXPECT_NEAR(FarthestEndstop_mm(fit.model, built), 0, 1e-7);
  EXPECT_NEAR(fit.height_rms_mm, 0, 1e-9);
}

TEST(KlipperFit, StatesACovarianceThatIsTheScatterOfRepeats) {
  const DeltaModel<double> built = Built();
  const std::vector<DeltaTouch> exact = Touches(built);
  constexpr int kRepeats = 300;
  Rng rng(7, 0, "delta_klipper_fit");

  double radius_mm2 = 0, endstop_mm2 = 0;
  KlipperFit fit;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    std::vector<DeltaTouch> touches = exact;
    for (DeltaTouch& touch : touches) touch.height_mm += kSigma_mm * rng.Normal();
    fit = FitKlipperModel(touches, {}, built, kKlipperSix);
    radius_mm2 += std::pow(fit.model.radius_mm[0] - built.radius_mm[0], 2) / kRepeats;
    endstop_mm2 +=
        std::pow(fit.model.endstop_mm[1] - built.endstop_mm[1], 2) / kRepeats;
  }

  const double four_sigma = 4 / std::sqrt(2.0 * kRepeats);
  EXPECT_NEAR(std::sqrt(radius_mm2) / fit.last_step.sd(0), 1, four_sigma);
  EXPECT_NEAR(std::sqrt(endstop_mm2) / fit.last_step.sd(2), 1, four_sigma);
}

TEST(KlipperFit, SaysThatFiveTouchesDoNotDetermineSixNumbers) {
  std::vector<DeltaTouch> touches = Touches(Built());
  touches.resize(5);

  const KlipperFit fit = FitKlipperModel(touches, {}, Built(), kKlipperSix);

  EXPECT_FALSE(fit.last_step.identifiable);
  EXPECT_EQ(fit.last_step.rank, 5);
}

TEST(KlipperFit, CannotTellArmsFromHeightsButFromDistances) {
  const DeltaModel<double> built = Built();
  const std::vector<DeltaTouch> touches = Touches(built);
  DeltaModel<double> start = built;
  for (double& arm_mm : start.arm_mm) arm_mm += 1;
  std::vector<DeltaDistance> distances;
  for (std::size_t i = 1; i < touches.size(); ++i) {
    const Vec3<double> nozzle_mm = DeltaNozzle_mm(built, touches[i].motors_mm);
    distances.push_back(
        {(nozzle_mm - DeltaNozzle_mm(built, touches[0].motors_mm)).norm(),
         touches[0].motors_mm,
         touches[i].motors_mm});
  }

  const KlipperFit heights = FitKlipperModel(touches, {}, start, kKlipperNine);
  const KlipperFit both = FitKlipperModel(touches, distances, start, kKlipperNine);

  EXPECT_FALSE(heights.last_step.identifiable);
  EXPECT_TRUE(both.is_converged);
  EXPECT_TRUE(both.last_step.identifiable);
  EXPECT_NEAR(both.model.arm_mm[0], built.arm_mm[0], 1e-6);
  EXPECT_NEAR(both.model.radius_mm[0], built.radius_mm[0], 1e-6);
}

TEST(SavedCalibration, ThatWasMovedAsAWholeIsToldFromOneThatIsStale) {
  Problem problem{.touches = Touches(Built()), .saved = Built()};
  EXPECT_EQ(Assess(problem).verdict, SavedVerdict::kBelongs);

  for (double& endstop_mm : problem.saved.endstop_mm) endstop_mm += 0.2;
  const KlipperAssessment moved = Assess(problem);
  EXPECT_EQ(moved.verdict, SavedVerdict::kMovedTogether);
  EXPECT_NEAR(moved.saved_mean_mm, 0.2, 1e-9);

  problem.saved.endstop_mm[2] -= 0.2;
  EXPECT_EQ(Assess(problem).verdict, SavedVerdict::kStale);
}

TEST(SavedCalibration, OfASuperRacerIsReproduced) {
  const Problem problem = ProblemOf(ReadKlipperCalibration(
      TestData("imports/delta_super_racer.cfg"), "delta_super_racer.cfg", {}));

  const KlipperAssessment assessment = Assess(problem);

  EXPECT_EQ(assessment.verdict, SavedVerdict::kBelongs);
  EXPECT_NEAR(assessment.fit.model.radius_mm[0], problem.saved.radius_mm[0], 0.005);
  EXPECT_LT(FarthestEndstop_mm(assessment.fit.model, problem.saved), 0.01);
  EXPECT_NEAR(assessment.saved_rms_mm, assessment.fit.height_rms_mm, 1e-5);
  // One reading to spare: what it foretells is far worse than what it fits.
  EXPECT_EQ(assessment.spare, 1);
  EXPECT_GT(*assessment.hold_out_rms_mm, 5 * assessment.fit.height_rms_mm);
}

// However far the touches themselves are from the model: 12 um rms here.
TEST(SavedCalibration, WhoseDeltaRadiusWasChangedSinceIsStale) {
  Problem problem = ProblemOf(ReadKlipperCalibration(
      TestData("imports/delta_super_racer.cfg"), "delta_super_racer.cfg", {}));
  problem.saved.radius_mm.fill(problem.saved.radius_mm[0] + 0.05);

  EXPECT_EQ(Assess(problem).verdict, SavedVerdict::kStale);
}

TEST(SavedCalibration, WithDistancesIsReproducedInNineNumbers) {
  const Problem problem = ProblemOf(ReadKlipperCalibration(
      TestData("imports/delta_v400_distances.cfg"), "delta_v400_distances.cfg", {}));

  const KlipperAssessment assessment = Assess(problem);

  EXPECT_EQ(assessment.verdict, SavedVerdict::kBelongs);
  EXPECT_NEAR(assessment.fit.model.radius_mm[0], problem.saved.radius_mm[0], 0.005);
  EXPECT_LT(FarthestEndstop_mm(assessment.fit.model, problem.saved), 0.01);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(assessment.fit.model.arm_mm[i], problem.saved.arm_mm[i], 0.01);
  }
}

TEST(SavedCalibration, RoundedByHandIsStale) {
  const Problem problem = ProblemOf(ReadKlipperCalibration(
      TestData("imports/delta_v400_fixes.cfg"), "delta_v400_fixes.cfg", {}));

  const KlipperAssessment assessment = Assess(problem);

  EXPECT_EQ(assessment.verdict, SavedVerdict::kStale);
  EXPECT_GT(assessment.saved_rms_mm, 5 * assessment.fit.height_rms_mm);
}

TEST(SavedCalibration, IsReproducedOnEveryFileOfAFolder) {
  const char* folder = std::getenv("CALTWIN_KLIPPER_DELTA");
  if (folder == nullptr) GTEST_SKIP() << "CALTWIN_KLIPPER_DELTA names no folder";
  int num_read = 0, num_reproduced = 0, num_stale = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().string();
    const std::string text = ReadTextFile(entry.path(), 1'000'000);
    try {
      ImportText("klipper-delta", text, name, {});
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name + ":"), std::string::npos);
      continue;
    }
    const Problem problem = ProblemOf(ReadKlipperCalibration(text, name, {}));
    const KlipperAssessment assessment = Assess(problem);
    EXPECT_TRUE(assessment.fit.is_converged) << name;
    const bool is_same = std::abs(assessment.fit.model.radius_mm[0] -
                                  problem.saved.radius_mm[0]) < 0.005 &&
                         FarthestEndstop_mm(assessment.fit.model, problem.saved) < 0.01;
    const bool is_stale = assessment.verdict == SavedVerdict::kStale;
    EXPECT_NE(is_same, is_stale) << name;
    ++num_read;
    num_reproduced += is_same ? 1 : 0;
    num_stale += is_stale ? 1 : 0;
  }
  RecordProperty("read", num_read);
  EXPECT_GE(num_reproduced, 9 * num_read / 10);
  EXPECT_EQ(num_reproduced + num_stale, num_read);
}

constexpr double kMeshNoise_mm = 0.005;

/// A mesh of a bed of that shape, probed by that machine under those settings: the
/// height that the settings believe where the nozzle truly touches.
template <typename Shape>
std::vector<BedPoint> Mesh(const DeltaModel<double>& built,
                           const DeltaModel<double>& settings,
                           const Shape& height_mm) {
  constexpr double kRadius_mm = 120;
  Rng rng(3, 0, "delta_mesh");
  std::vector<BedPoint> points;
  for (int i = -5; i <= 5; ++i) {
    for (int k = -5; k <= 5; ++k) {
      const double x_mm = i * kRadius_mm / 5, y_mm = k * kRadius_mm / 5;
      if (std::hypot(x_mm, y_mm) > kRadius_mm + 0.01) continue;
      const double z_mm = height_mm(x_mm / kRadius_mm, y_mm / kRadius_mm) +
                          kMeshNoise_mm * rng.Normal();
      const Vec3<double> believed_mm =
          DeltaNozzle_mm(settings, DeltaMotors_mm<double>(built, {x_mm, y_mm, z_mm}));
      points.push_back({believed_mm[0], believed_mm[1], believed_mm[2]});
    }
  }
  return points;
}

double Flat(double /*u*/, double /*v*/) {
  return 0;
}

TEST(MeshShape, NamesArmsThatDiffer) {
  DeltaModel<double> built = Built();
  built.arm_mm = {315.8, 314.6, 315.0};

  const MeshShape shape = ExplainMesh(Mesh(built, Built(), Flat), Built());

  EXPECT_EQ(shape.verdict, MeshVerdict::kArms);
  const MeshFit& arms = shape.of(MeshModel::kArms);
  const Eigen::Matrix3d covariance_mm2 =
      arms.arm_covariance_mm2 * std::pow(kMeshNoise_mm / MmFromUm(20.0), 2);
  for (const Eigen::Vector3d& apart : {Eigen::Vector3d(1, -1, 0), {0, 1, -1}}) {
    double off_mm = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      off_mm += apart[i] * (arms.model.arm_mm[at] - built.arm_mm[at]);
    }
    EXPECT_LT(std::abs(off_mm), 4 * std::sqrt(apart.dot(covariance_mm2 * apart)));
  }
}

TEST(MeshShape, NamesABentBedThatIsThreeFold) {
  const auto bent = [](double u, double v) {
    return 0.1 * (u * u * u - 3 * u * v * v);
  };

  const MeshShape shape = ExplainMesh(Mesh(Built(), Built(), bent), Built());

  EXPECT_EQ(shape.verdict, MeshVerdict::kBedShape) << shape.reason;
}

// What the docstring admits: one side of the rim up, the other down, is what arms do.
TEST(MeshShape, TakesAPlateBentLikeArmsForArms) {
  const auto bent = [](double u, double v) {
    return 0.1 * u * (u * u + v * v);
  };

  const MeshShape shape = ExplainMesh(Mesh(Built(), Built(), bent), Built());

  EXPECT_EQ(shape.verdict, MeshVerdict::kArms);
  EXPECT_LT(shape.of(MeshModel::kArms).rms_mm, 2 * kMeshNoise_mm);
}

TEST(MeshShape, BlamesNothingForAFlatBed) {
  const MeshShape shape = ExplainMesh(Mesh(Built(), Built(), Flat), Built());

  EXPECT_EQ(shape.verdict, MeshVerdict::kNeither);
}

TEST(MeshShape, LosesBowlCylinderAndTwistInKlippersSixNumbers) {
  const auto bent = [](double u, double v) {
    return 0.05 * (u * u + v * v) + 0.04 * u * u - 0.03 * 2 * u * v;
  };

  const MeshShape shape = ExplainMesh(Mesh(Built(), Built(), bent), Built());

  // Before: 0.06 mm at the rim; the six numbers leave little more than the noise.
  EXPECT_LT(shape.of(MeshModel::kSix).rms_mm, 0.015);
  EXPECT_NE(shape.verdict, MeshVerdict::kArms);
}

TEST(MeshShape, CannotTellFromThirteenPoints) {
  std::vector<BedPoint> points = Mesh(Built(), Built(), Flat);
  points.resize(13);

  EXPECT_EQ(ExplainMesh(points, Built()).verdict, MeshVerdict::kCannotTell);
}

TEST(MeshShape, OfAWellCalibratedPrinterNeedsNoExplanation) {
  const KlipperBed bed = ReadKlipperBed(TestData("imports/mesh_v400.cfg"), "f.cfg");
  std::vector<BedPoint> points;
  for (const MeshPoint& point : bed.meshes[0].points) {
    points.push_back({point.x_mm, point.y_mm, point.z_mm});
  }

  const MeshShape shape = ExplainMesh(points, bed.geometry->model);

  EXPECT_EQ(shape.verdict, MeshVerdict::kNeither);
}

}  // namespace
}  // namespace caltwin
