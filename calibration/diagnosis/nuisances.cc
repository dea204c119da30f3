#include "calibration/diagnosis/nuisances.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/drawn.h"
#include "calibration/diagnosis/free_form.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/nuisance_list.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// How far what stands on a machine may be off.
constexpr double kSlopeSd_mrad = 30;
constexpr double kTurnSd_mrad = 100;
constexpr double kHysteresisSd_mm = 0.1;
// How far what is laid on the bed may lean from its plane: a speck of 60 um under one
// end of 200 mm.
constexpr double kPlateSlopeSd_mrad = 0.3;
// How far a face may stand from where it was written, if nobody measured it.
constexpr double kFaceSd_mm = 10;
// What an effect of the model may still go by, of its size. Of homings: the model draws
// where each stood, and the machine drew differently, each with the stated scatter.
constexpr double kFreedomShare = 0.2;
constexpr double kHomingsApart = 2;

// Where a row's artefact lies, or which zero its gauge has.
std::string PlacementKey(const Row& row) {
  if (row.kind != RowKind::kTouch) {
    return row.setup.empty() ? row.campaign : row.campaign + "/" + row.setup;
  }
  std::string key = row.setup.empty() ? std::string(ArtefactOf(row)) : row.setup;
  if (key.empty()) key = row.campaign;
  return key;
}

// What a slope of the bed of one would do to every row, along x or y.
Eigen::VectorXd SlopeColumn(const Observed& o, std::size_t slope) {
  Injected unit{.effect = *FindEffect("bed_tilt"), .axis = "", .values = {0, 0}};
  unit.values[slope] = 1;
  return o.Change_mm(unit);
}

struct Placement {
  Vec3<double> sum_mm = Vec3<double>::Zero();
  int count = 0;
  bool has_feature = false, is_gauge = false, is_radial = false;
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
  }
  return placements;
}

void AddPlacements(const Observed& o, NuisanceList* builder) {
  const auto placements = PlacementsOf(o);
  const auto num_touched = std::ranges::count_if(
      placements, [](const auto& entry) { return !entry.second.is_gauge; });
  for (const auto& entry : placements) {
    const std::string& key = entry.first;
    const Placement& placement = entry.second;
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
    const bool is_gauged_face = placement.is_gauge && placement.has_feature;
    if (placement.has_feature && !placement.is_radial) {
      builder->Add(name + "turn", "mrad", kTurnSd_mrad, turned({0, 0, 1}));
    }
    if (!placement.is_radial) {
      const double tilt_sd = placement.is_gauge ? kTurnSd_mrad : kPlateSlopeSd_mrad;
      // Alone it leans with the bed.
      if (is_gauged_face || (!placement.is_gauge && num_touched > 1)) {
        builder->Add(name + "tilt_x", "mrad", tilt_sd, turned({1, 0, 0}));
        builder->Add(name + "tilt_y", "mrad", tilt_sd, turned({0, 1, 0}));
      }
    }
  }
}

// A face that nobody measured stands where it stands: an offset along its normal, of
// each setup anew. A placement with a single face has it in its place.
void AddFaces(const Observed& o, NuisanceList* builder) {
  const auto face_of = [](const Row& row) {
    std::string face = PlacementKey(row) + "|" + row.feature;
    if (row.feature.empty()) {
      for (const double n : row.n)
        face += Known(n) ? "," + std::to_string(std::lround(n)) : ",?";
    }
    return face;
  };
  std::map<std::string, std::set<std::string>> faces;
  for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
    const Row& row = o.row(i);
    if (o.at(i).kind != RowKind::kTouch || o.at(i).station) continue;
    if (IsDrawn(o.header(), std::string(ArtefactOf(row)))) continue;
    faces[PlacementKey(row)].insert(face_of(row));
  }
  for (const auto& [placement, own] : faces) {
    if (own.size() < 2) continue;
    for (const std::string& face : own) {
      builder->Add(
          "face." + face,
          "mm",
          kFaceSd_mm,
          [&](Eigen::Index i) {
            return o.at(i).kind == RowKind::kTouch && face_of(o.row(i)) == face ? 1.0
                                                                                : 0.0;
          },
          /*offset=*/0,
          /*reported=*/false);
    }
  }
}

// The size of an artefact, within what its certificate leaves open.
void AddSizes(const Observed& o, NuisanceList* builder) {
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

// The columns of a part of the model with what each may still go by, in units of mm.
void AddFreedom(const std::string& name,
                const Eigen::MatrixXd& columns_mm,
                const Eigen::VectorXd& sds,
                NuisanceList* builder) {
  for (Eigen::Index k = 0; k < columns_mm.cols(); ++k) {
    builder->Add(
        name + ".form",
        "mm",
        sds[k],
        [&](Eigen::Index row) { return columns_mm(row, k); },
        /*offset=*/0,
        /*reported=*/false);
  }
}

// A table without a formula: smooth functions of its covariates, by as much as a named
// effect may deviate from its shape.
void AddFreedomOfMap(const Observed& o, const Injected& effect, NuisanceList* builder) {
  constexpr int kTerms = 13;
  const MapWords words = EffectAt(effect.effect).name == PitchMap::kDeclaration.name
                             ? MapWords{.channel = effect.axis,
                                        .covariates = {effect.axis, ""},
                                        .num_covariates = 1}
                             : WordsOf(effect.axis);
  const std::vector<std::string> covariates(
      words.covariates.begin(), words.covariates.begin() + words.num_covariates);
  if (covariates.empty()) return;
  const double peak_mm = Peak_mm(o.Change_mm(effect));
  const FreeForm form = FreeFormOf(o, std::string(words.channel), covariates, kTerms);
  AddFreedom(std::string(EffectAt(effect.effect).name) + "." + effect.axis,
             form.columns_mm,
             kFreedomShare * peak_mm * form.prior.cwiseSqrt(),
             builder);
}

// What was found earlier and is in the model keeps the freedom that it was found with:
// its size by a fifth, its form as a finding's. Of homings, each its own place: the
// model knows how far they scatter, not where each stood.
void AddFreedomOfEffect(const Observed& o,
                        const Injected& effect,
                        NuisanceList* builder) {
  const Effect& declaration = EffectAt(effect.effect);
  std::vector<double> forms;
  double size = 0;
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i) {
    if (declaration.parameters[i].role == Role::kForm)
      forms.push_back(effect.values[i]);
    if (declaration.parameters[i].role == Role::kSize) {
      size = std::hypot(size, effect.values[i]);
    }
  }
  const Variant variant = VariantOf(o, effect.effect, effect.axis, forms);
  if (variant.columns_mm.cols() == 0 || size == 0) return;
  const Candidate candidate{
      .effect = effect.effect,
      .cause = std::string(declaration.name),
      .axis = effect.axis,
      .shown = ShownOn(declaration, effect.axis, o.machine().kind)};
  const double size_mm = std::abs(size) / variant.size_per_mm;
  const bool is_homing = declaration.name == HomingScatter::kDeclaration.name;
  const double share = is_homing ? kHomingsApart : kFreedomShare;
  AddFreedom(candidate.Name(),
             variant.columns_mm,
             Eigen::VectorXd::Constant(variant.columns_mm.cols(), share * size_mm),
             builder);
  const Tolerance tolerance = ToleranceOf(o, candidate, variant);
  AddFreedom(candidate.Name(),
             tolerance.columns_mm,
             size_mm * tolerance.prior.cwiseSqrt(),
             builder);
}

void AddFreedoms(const Observed& o, NuisanceList* builder) {
  for (const Injected& effect : o.effects()) {
    const std::string_view name = EffectAt(effect.effect).name;
    if (EffectAt(effect.effect).sight) {
      AddFreedomOfEffect(o, effect, builder);
    } else if (name == PitchMap::kDeclaration.name ||
               name == UnknownMap::kDeclaration.name) {
      AddFreedomOfMap(o, effect, builder);
    }
  }
}

}  // namespace

// A bed on screws stands anew after each homing.
void AddBedPlanes(const Observed& o, NuisanceList* builder) {
  const std::vector<std::string> homes = HomesOf(o, /*only_touches=*/false);
  for (std::size_t h = 0; h < homes.size(); ++h) {
    const std::string name =
        homes.size() == 1 ? "bed_plane." : "bed_plane." + homes[h] + ".";
    const auto within = [&](Eigen::Index row) {
      return o.row(row).home == homes[h];
    };
    // The first one's height is that of the placements.
    builder->Add(name + "height", "mm", kPlacementSd_mm, [&](Eigen::Index row) {
      const double up = o.MotionSign(row) * o.at(row).n.z();
      return h > 0 && within(row) ? -up : 0.0;
    });
    for (std::size_t slope = 0; slope < 2; ++slope) {
      const Eigen::VectorXd column = SlopeColumn(o, slope);
      builder->Add(name + (slope == 0 ? "slope_x" : "slope_y"),
                   "mrad",
                   kSlopeSd_mrad,
                   [&](Eigen::Index row) { return within(row) ? column[row] : 0.0; });
    }
  }
}

void AddBedPlane(const Observed& o, NuisanceList* builder) {
  for (std::size_t slope = 0; slope < 2; ++slope) {
    const Eigen::VectorXd column = SlopeColumn(o, slope);
    builder->Add(slope == 0 ? "bed_plane.slope_x" : "bed_plane.slope_y",
                 "mrad",
                 kSlopeSd_mrad,
                 [&](Eigen::Index row) { return column[row]; });
  }
}

void AddWhatIsTouched(const Observed& o, NuisanceList* builder) {
  AddPlacements(o, builder);
  AddFaces(o, builder);
  AddSizes(o, builder);
  builder->Add("probe_hysteresis", "mm", kHysteresisSd_mm, [&](Eigen::Index row) {
    return IsRelease(o.row(row)) ? -1.0 : 0.0;
  });
}

std::vector<Nuisance> BaselineOf(const Observed& observed) {
  NuisanceList builder(observed);
  const DiagnosedKind& kind = DiagnosedAs(observed.machine());
  kind.AddKinematics(observed, &builder);
  kind.AddPlaces(observed, &builder);
  AddFreedoms(observed, &builder);
  return builder.Take();
}

}  // namespace caltwin
