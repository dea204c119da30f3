#include "calibration/diagnosis/nuisances_of_kinematics.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "calibration/diagnosis/delta_lines.h"
#include "calibration/diagnosis/rounding.h"
#include "sim/effects/drive.h"

namespace caltwin {
namespace {

// How far a machine may be off before another word than calibration is needed.
constexpr double kScaleSd_ppm = 3e4;
constexpr double kBacklashSd_mm = 0.2;
constexpr double kPretravelSd_mm = 0.1;
constexpr double kWholeSteps = 1;  // 1: all of it; 0: a servo, or a finer microstep.
constexpr double kArmSd_mm = 2;

void AddAxes(const Observed& o, NuisanceList* builder) {
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

// The knobs of a delta that its baseline holds, each line with all that it turns.
void AddDelta(const Observed& o, NuisanceList* builder) {
  const auto add = [&](std::string_view name, double prior_sd) {
    const auto turns = KnobsOfLine(name, 1);
    const auto first = static_cast<std::size_t>(turns[0].knob);
    builder->Add(
        std::string(name),
        std::string(kDeltaKnobs[first].unit),
        prior_sd,
        [&](Eigen::Index row) {
          const At& at = o.at(row);
          Vec3<double> moved_mm = Vec3<double>::Zero();
          for (const auto& [knob, by] : turns) {
            moved_mm += at.delta->by_knob.col(knob) * by *
                        kDeltaKnobs[static_cast<std::size_t>(knob)].per_unit;
          }
          return o.MotionSign(row) * at.n.dot(moved_mm);
        },
        o.knobs()[first]);
  };
  for (const int knob :
       {kEndstopKnob, kEndstopKnob + 1, kRadiusKnob, kAngleKnob, kAngleKnob + 1}) {
    const DeltaKnob& declared = kDeltaKnobs[static_cast<std::size_t>(knob)];
    add(declared.name, declared.prior_sd);
  }
  add("arm_length", kArmSd_mm);
  add("scale", kScaleSd_ppm);
}

// Scale and backlash that all three screws of a bed share; like a gantry's z.
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
        const Vec3<double>& weights = o.at(row).triple_z->weights;
        return -motion(row) * weights.dot(*MotorsOf_mm(o.at(row))) * 1e-6;
      },
      set > 0 ? (set / drawing.steps_per_mm() - 1) * 1e6 : 0);
  builder->Add("backlash.z", "mm", kBacklashSd_mm, [&](Eigen::Index row) {
    return -motion(row) * o.at(row).dir[z] / 2;
  });
}

// What was touched, and where: a bed has another height at each place of a mesh.
std::map<std::string, std::set<Eigen::Index>> HeightsOf(const Observed& o) {
  std::map<std::string, std::set<Eigen::Index>> heights;
  const Eigen::Vector2d usual_mm =
      o.machine().z_station->PlaceOf_mm(ZReading::kProbeOnBed);
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    if (o.at(i).kind != RowKind::kTouch || !o.at(i).station) continue;
    std::string name(FeatureOf(*o.at(i).station));
    const Eigen::Vector2d at_mm = o.at(i).q_mm.head<2>();
    const bool is_elsewhere =
        o.at(i).station == ZReading::kProbeOnBed && (at_mm - usual_mm).norm() > 1;
    if (is_elsewhere) name += fmt::format(".{:.0f}_{:.0f}", at_mm[0], at_mm[1]);
    heights[name].insert(i);
  }
  return heights;
}

// Z counts from where it was homed, and of what is touched the heights are known only
// roughly. A gap is what it is.
void AddStation(const Observed& o, NuisanceList* builder) {
  const std::vector<std::string> homes = HomesOf(o, /*only_touches=*/true);
  const auto heights = HeightsOf(o);
  for (const auto& height : heights) {
    const std::set<Eigen::Index>& rows = height.second;
    builder->Add(
        "height." + height.first, "mm", kPlacementSd_mm, [&](Eigen::Index row) {
          return rows.contains(row);
        });
  }
  // The first one's is in those heights.
  for (std::size_t h = 1; h < homes.size(); ++h) {
    builder->Add(
        "homed." + homes[h],
        "mm",
        kPlacementSd_mm,
        [&](Eigen::Index row) {
          return o.at(row).kind == RowKind::kTouch && o.row(row).home == homes[h];
        },
        /*offset=*/0,
        /*reported=*/false);
  }
}

}  // namespace

void NuisanceList::Add(const std::string& name,
                       const std::string& unit,
                       double prior_sd,
                       const OfRow& of_row,
                       double offset,
                       bool reported) {
  Eigen::VectorXd column(observed_.num_rows());
  for (Eigen::Index i = 0; i < column.size(); ++i) column[i] = of_row(i);
  if (column.cwiseAbs().maxCoeff() == 0) return;
  nuisances_.push_back({name, unit, column, prior_sd, offset, reported});
}

std::vector<std::string> HomesOf(const Observed& o, bool only_touches) {
  std::vector<std::string> homes;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    if (only_touches && o.at(i).kind != RowKind::kTouch) continue;
    const std::string& home = o.row(i).home;
    if (std::ranges::find(homes, home) == homes.end()) homes.push_back(home);
  }
  return homes;
}

void AddKinematics(const Observed& o, NuisanceList* builder) {
  if (o.machine().z_station) {
    AddStation(o, builder);
  } else if (o.machine().delta) {
    AddDelta(o, builder);
  } else if (o.machine().triple_z) {
    AddScrews(o, builder);
  } else {
    AddAxes(o, builder);
  }
}

}  // namespace caltwin
