#include "calibration/kinds/delta/settings.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <ceres/jet.h>
#include <fmt/format.h>

#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr int kNumSettings = 12;  // Endstops, radii, angles, arms.
// How much more heights on the bed weigh than places. Where a firmware has fewer
// numbers than it takes, it trades one for the other; beyond this nothing is gained.
constexpr double kHeightWeight = 200;

using SettingsJet = ceres::Jet<double, kNumSettings>;

// What each of the twelve numbers adds to: towers of a shared one move together.
DeltaModel<SettingsJet> Free(const DeltaModel<double>& at,
                             const DeltaSettingsShape& shape) {
  DeltaModel<SettingsJet> model;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<int>(i);
    model.endstop_mm[i] = SettingsJet(at.endstop_mm[i], k);
    model.radius_mm[i] =
        SettingsJet(at.radius_mm[i], 3 + (shape.has_radius_per_tower ? k : 0));
    model.angle_rad[i] = SettingsJet(at.angle_rad[i], 6 + k);
    model.arm_mm[i] = SettingsJet(at.arm_mm[i], 9 + (shape.has_arm_per_tower ? k : 0));
  }
  return model;
}

struct Aim {
  Vec3<double> sent_mm = Vec3<double>::Zero();
  Vec3<double> motors_mm = Vec3<double>::Zero();  ///< That take the nozzle there.
};

// A lattice on the disc at this height.
std::vector<Vec3<double>> LatticeAt(double above_mm, double radius_mm) {
  constexpr int kSteps = 5;
  std::vector<Vec3<double>> points;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      if (i * i + j * j > kSteps * kSteps) continue;
      points.emplace_back(radius_mm * i / kSteps, radius_mm * j / kSteps, above_mm);
    }
  }
  return points;
}

std::vector<Aim> AimsOn(const DeltaBuild<double>& build,
                        const DeltaBed<double>& bed,
                        double radius_mm) {
  std::vector<Aim> aims;
  for (const double above_mm : {0.0, 40.0}) {
    for (const Vec3<double>& sent : LatticeAt(above_mm, radius_mm)) {
      Vec3<double> there = sent;
      there[2] += bed.Height_mm(sent[0], sent[1]);
      if (const auto motors = DeltaMotorsOf(build, there)) {
        aims.push_back({sent, *motors});
      }
    }
  }
  return aims;
}

void Add(const Eigen::VectorXd& step,
         const DeltaSettingsShape& shape,
         DeltaModel<double>* model) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    model->endstop_mm[i] += step[k];
    model->radius_mm[i] += step[3 + (shape.has_radius_per_tower ? k : 0)];
    model->angle_rad[i] += step[6 + k];
    model->arm_mm[i] += step[9 + (shape.has_arm_per_tower ? k : 0)];
  }
}

// Counter-clockwise from where the drawing has the tower.
std::array<double, 3> Corrections_deg(const DeltaModel<double>& settings,
                                      const DeltaModel<double>& drawn) {
  std::array<double, 3> more_deg{};
  for (std::size_t i = 0; i < 3; ++i) {
    more_deg[i] = DegFromRad(settings.angle_rad[i] - drawn.angle_rad[i]);
  }
  return more_deg;
}

}  // namespace

DeltaModel<double> BestDeltaSettings(const DeltaBuild<double>& build,
                                     const DeltaBed<double>& bed,
                                     const DeltaModel<double>& from,
                                     double radius_mm,
                                     const DeltaSettingsShape& shape) {
  constexpr int kRounds = 8;
  constexpr double kSlight = 1e-6;  // Holds what changes nothing where it stands.
  const std::vector<Aim> aims = AimsOn(build, bed, radius_mm);
  DeltaModel<double> model = from;
  const auto num = static_cast<Eigen::Index>(aims.size());
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Index rows = 3 * num + 1 + kNumSettings;
    Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(rows, kNumSettings);
    Eigen::VectorXd off = Eigen::VectorXd::Zero(rows);
    const DeltaModel<SettingsJet> free = Free(model, shape);
    SettingsJet outward(0.0);  // Sum of how far out places are, times their radius.
    double radius2_mm2 = 0;
    for (Eigen::Index i = 0; i < num; ++i) {
      const Aim& aim = aims[static_cast<std::size_t>(i)];
      // Where the firmware believes to be when the nozzle is where it was sent.
      const Vec3<SettingsJet> believed =
          DeltaNozzle_mm<SettingsJet>(free, aim.motors_mm.cast<SettingsJet>());
      for (int c = 0; c < 3; ++c) {
        const bool is_bed_height = c == 2 && aim.sent_mm[2] == 0;
        const double weight = is_bed_height ? kHeightWeight : 1;
        slope.row(3 * i + c) = weight * believed[c].v.transpose();
        off[3 * i + c] = weight * (believed[c].a - aim.sent_mm[c]);
        if (c == 2) continue;
        outward += (believed[c] - aim.sent_mm[c]) * aim.sent_mm[c];
        radius2_mm2 += aim.sent_mm[c] * aim.sent_mm[c];
      }
    }
    // The error of scale is outward / radius^2: one number, in places as heights weigh.
    const double scale_weight = kHeightWeight / std::sqrt(radius2_mm2);
    slope.row(3 * num) = scale_weight * outward.v.transpose();
    off[3 * num] = scale_weight * outward.a;
    slope.bottomRows(kNumSettings).diagonal().setConstant(kSlight);
    Add(-LeastSquares(slope, off), shape, &model);
  }
  return model;
}

std::string AsRrf(const DeltaModel<double>& settings, const DeltaModel<double>& drawn) {
  const auto more_deg = Corrections_deg(settings, drawn);
  const double mean_mm = MeanOfTowers(settings.endstop_mm);
  const auto& arm = settings.arm_mm;
  const bool is_one_arm = arm[0] == arm[1] && arm[1] == arm[2];
  return fmt::format(
      "M665 L{} R{:.4f} H{:.4f} X{:.4f} Y{:.4f} Z{:.4f}\n"
      "M666 X{:.4f} Y{:.4f} Z{:.4f}\n",
      is_one_arm ? fmt::format("{:.4f}", arm[0])
                 : fmt::format("{:.4f}:{:.4f}:{:.4f}", arm[0], arm[1], arm[2]),
      MeanOfTowers(settings.radius_mm),
      mean_mm,
      more_deg[0],
      more_deg[1],
      more_deg[2],
      settings.endstop_mm[0] - mean_mm,
      settings.endstop_mm[1] - mean_mm,
      settings.endstop_mm[2] - mean_mm);
}

std::string AsMarlin(const DeltaModel<double>& settings,
                     const DeltaModel<double>& drawn) {
  const auto more_deg = Corrections_deg(settings, drawn);
  // Every carriage backs off from its endstop to the lowest of them: M666, none above
  // 0.
  const double lowest_mm = std::ranges::min(settings.endstop_mm);
  const double arm_mm = MeanOfTowers(settings.arm_mm);
  return fmt::format(
      "M665 L{:.4f} R{:.4f} H{:.4f} X{:.4f} Y{:.4f} Z{:.4f} A{:.4f} B{:.4f} C{:.4f}\n"
      "M666 X{:.4f} Y{:.4f} Z{:.4f}\n",
      arm_mm,
      MeanOfTowers(settings.radius_mm),
      lowest_mm,
      more_deg[0],
      more_deg[1],
      more_deg[2],
      settings.arm_mm[0] - arm_mm,
      settings.arm_mm[1] - arm_mm,
      settings.arm_mm[2] - arm_mm,
      lowest_mm - settings.endstop_mm[0],
      lowest_mm - settings.endstop_mm[1],
      lowest_mm - settings.endstop_mm[2]);
}

std::string AsKlipper(const DeltaModel<double>& settings) {
  std::string text = fmt::format("[printer]\ndelta_radius: {:.6f}\n",
                                 MeanOfTowers(settings.radius_mm));
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format(
        "\n[stepper_{}]\nangle: {:.6f}\narm_length: {:.6f}\nposition_endstop: {:.6f}\n",
        TowerName(static_cast<int>(i)),
        DegFromRad(settings.angle_rad[i]),
        settings.arm_mm[i],
        settings.endstop_mm[i]);
  }
  return text;
}

}  // namespace caltwin
