#include "calibration/diagnosis/nuisances.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "calibration/diagnosis/candidates.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// How far a machine may be off before another word than calibration is needed.
constexpr double kScaleSd_ppm = 3e4;
constexpr double kBacklashSd_mm = 1;
constexpr double kPretravelSd_mm = 0.5;
constexpr double kSlopeSd_mrad = 30;
constexpr double kPlacementSd_mm = 100;
constexpr double kTurnSd_mrad = 100;
constexpr double kHysteresisSd_mm = 0.1;
// What a free plane of each turned plate may differ from the bed's.
constexpr double kPlateSlopeSd_mrad = 3;

using OfRow = std::function<double(Eigen::Index)>;

class Builder {
 public:
  explicit Builder(const Observed& observed) : observed_(observed) {}

  // Adds a column unless it is nothing, or but a constant where that cannot be told.
  void Add(const std::string& name,
           const std::string& unit,
           double prior_sd,
           const OfRow& of_row,
           double offset = 0,
           bool reported = true) {
    Eigen::VectorXd column(observed_.num_rows());
    for (Eigen::Index i = 0; i < column.size(); ++i) column[i] = of_row(i);
    if (column.cwiseAbs().maxCoeff() == 0) return;
    nuisances_.push_back({name, unit, column, prior_sd, offset, reported});
  }

  std::vector<Nuisance> Take() { return std::move(nuisances_); }

 private:
  const Observed& observed_;
  std::vector<Nuisance> nuisances_{};
};

// Where a row's artefact lies, or which zero its gauge has.
std::string PlacementKey(const Row& row) {
  if (row.kind != RowKind::kTouch) {
    return row.setup.empty() ? row.campaign : row.campaign + "/" + row.setup;
  }
  std::string key = row.setup.empty() ? std::string(ArtefactOf(row)) : row.setup;
  if (key.empty()) key = row.campaign;
  return key;
}

void AddAxes(const Observed& o, Builder* builder) {
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
    builder->Add(
        "probe_pretravel." + Name(axis),
        "mm",
        kPretravelSd_mm,
        [&](Eigen::Index row) {
          if (o.at(row).kind != RowKind::kTouch) return 0.0;
          return -o.at(row).n[i] * o.at(row).n[i];
        },
        o.machine().probe.pretravel_mm);
  }
}

void AddBedPlane(const Observed& o, Builder* builder) {
  const auto tilt = *FindEffect("bed_tilt");
  for (std::size_t slope = 0; slope < 2; ++slope) {
    Injected unit{.effect = tilt, .axis = "", .values = {0, 0}};
    unit.values[slope] = 1;
    const Eigen::VectorXd column = o.Change_mm(unit);
    builder->Add(slope == 0 ? "bed_plane.slope_x" : "bed_plane.slope_y",
                 "mrad",
                 kSlopeSd_mrad,
                 [&](Eigen::Index row) { return column[row]; });
  }
}

struct Placement {
  Vec3<double> sum_mm = Vec3<double>::Zero();
  int count = 0;
  bool has_feature = false, is_gauge = false, is_radial = false, faces_up = false;
};

std::map<std::string, Placement> PlacementsOf(const Observed& o) {
  std::map<std::string, Placement> placements;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    Placement& placement = placements[PlacementKey(o.row(i))];
    placement.sum_mm += o.at(i).Tip_mm();
    ++placement.count;
    placement.has_feature |= !o.row(i).feature.empty();
    placement.is_gauge |= o.at(i).kind != RowKind::kTouch;
    placement.is_radial |= o.at(i).kind == RowKind::kRadial;
    placement.faces_up |= std::abs(o.at(i).n.z()) > 0.9;
  }
  return placements;
}

void AddPlacements(const Observed& o, Builder* builder) {
  const auto placements = PlacementsOf(o);
  const auto num_plates = std::ranges::count_if(placements, [](const auto& entry) {
    return !entry.second.is_gauge && entry.second.faces_up;
  });
  for (const auto& [key, placement] : placements) {
    const Vec3<double> mid_mm = placement.sum_mm / placement.count;
    const auto belongs = [&](Eigen::Index row) {
      return PlacementKey(o.row(row)) == key;
    };
    const auto turned = [&](const Vec3<double>& about) {
      return [&, about](Eigen::Index row) {
        if (!belongs(row)) return 0.0;
        const Vec3<double> arm_mm = o.at(row).Tip_mm() - mid_mm;
        return RadFromMrad(about.cross(arm_mm).dot(o.at(row).n));
      };
    };
    const std::string name = "placement." + key + ".";
    for (const Axis axis : kAxes) {
      builder->Add(name + Name(axis), "mm", kPlacementSd_mm, [&](Eigen::Index row) {
        return belongs(row) ? o.at(row).n[Index(axis)] : 0.0;
      });
    }
    if (placement.is_radial) {
      builder->Add(name + "radius", "mm", kPlacementSd_mm, [&](Eigen::Index row) {
        return belongs(row) ? 1.0 : 0.0;
      });
    }
    if (placement.has_feature && !placement.is_radial) {
      const Vec3<double> up(0, 0, 1);
      builder->Add(name + "turn", "mrad", kTurnSd_mrad, turned(up));
      const double tilt_sd = placement.is_gauge ? kTurnSd_mrad : kPlateSlopeSd_mrad;
      if (placement.is_gauge || (placement.faces_up && num_plates > 1)) {
        builder->Add(name + "tilt_x", "mrad", tilt_sd, turned({1, 0, 0}));
        builder->Add(name + "tilt_y", "mrad", tilt_sd, turned({0, 1, 0}));
      }
    }
  }
}

// The size of an artefact, within what its certificate leaves open.
void AddSizes(const Observed& o, Builder* builder) {
  const auto block_size = FindEffect("block_size");
  for (const auto& [id, artefact] : o.header().artefacts) {
    if (artefact.u_um <= 0 || !block_size) continue;
    const Eigen::VectorXd column =
        o.Change_mm({.effect = *block_size, .axis = id, .values = {1}});
    builder->Add("size." + id, "um", artefact.u_um, [&](Eigen::Index row) {
      return column[row];
    });
  }
}

}  // namespace

std::vector<Nuisance> BaselineOf(const Observed& observed) {
  Builder builder(observed);
  AddAxes(observed, &builder);
  AddBedPlane(observed, &builder);
  AddPlacements(observed, &builder);
  AddSizes(observed, &builder);
  builder.Add("probe_hysteresis", "mm", kHysteresisSd_mm, [&](Eigen::Index row) {
    return IsRelease(observed.row(row)) ? -1.0 : 0.0;
  });
  return builder.Take();
}

}  // namespace caltwin
