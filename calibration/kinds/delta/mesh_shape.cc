#include "calibration/kinds/delta/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <ceres/jet.h>
#include <fmt/format.h>

#include "calibration/estimate/linear_fit.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr int kNumAll = 16;  // Klipper's six, three arms, seven terms of a bed.
using Jet16 = ceres::Jet<double, kNumAll>;
template <typename T>
using All = Eigen::Matrix<T, kNumAll, 1>;

constexpr int kNumSix = 6;
constexpr int kNumArms = 3;
constexpr int kNumSquares = 3;
constexpr int kNumCubics = 4;
constexpr int kBlocksAcross = 4;
constexpr int kMeshShapeMostSteps = 40;
constexpr double kPoint_mm = MmFromUm(20.0);
constexpr double kNoteworthy = 0.9;  ///< Of a rival's held-out rms.

std::vector<int> ActiveOf(MeshModel model) {
  std::vector<int> active;
  const auto add = [&](int first, int count) {
    for (int i = 0; i < count; ++i) active.push_back(first + i);
  };
  add(0, kNumSix);
  if (model == MeshModel::kArms) add(kNumSix, kNumArms);
  const bool is_bed = model == MeshModel::kBed || model == MeshModel::kCubic;
  if (is_bed) add(kNumSix + kNumArms, kNumSquares);
  if (model == MeshModel::kCubic) add(kNumSix + kNumArms + kNumSquares, kNumCubics);
  return active;
}

/// One point as the machine felt it.
struct Felt {
  Vec3<double> motors_mm = Vec3<double>::Zero();
  Eigen::Matrix<double, kNumSquares + kNumCubics, 1> terms;  ///< Of the bed's shape.
  std::pair<int, int> block{};
};

class Bed {
 public:
  Bed(std::span<const BedPoint> points, const DeltaModel<double>& settings)
      : settings_(settings), arc_mm_(settings.radius_mm[0]) {
    for (const BedPoint& point : points) {
      rim_mm_ = std::max(rim_mm_, std::hypot(point.x_mm, point.y_mm));
    }
    for (const BedPoint& point : points) Add(point);
  }

  const std::vector<Felt>& felt() const { return felt_; }
  double arc_mm() const { return arc_mm_; }

  template <typename T>
  DeltaModel<T> Model(const All<T>& p) const {
    DeltaModel<T> model;
    for (int i = 0; i < kNumTowers; ++i) {
      const auto at = static_cast<std::size_t>(i);
      model.radius_mm[at] = settings_.radius_mm[at] + p[0];
      model.endstop_mm[at] = settings_.endstop_mm[at] + p[1 + i];
      model.angle_rad[at] = T(settings_.angle_rad[at]);
      if (i < 2) model.angle_rad[at] += p[4 + i] / T(arc_mm_);
      model.arm_mm[at] = settings_.arm_mm[at] + p[kNumSix + i];
    }
    return model;
  }

  /// Nozzle less bed.
  template <typename T>
  T Residual_mm(const DeltaModel<T>& model, const All<T>& p, const Felt& felt) const {
    T off_mm = DeltaNozzle_mm<T>(model, felt.motors_mm.cast<T>())[2];
    for (int i = 0; i < felt.terms.size(); ++i) {
      off_mm -= p[kNumSix + kNumArms + i] * felt.terms[i];
    }
    return off_mm;
  }

 private:
  void Add(const BedPoint& point) {
    const double u = point.x_mm / rim_mm_, v = point.y_mm / rim_mm_;
    Felt felt;
    felt.motors_mm =
        DeltaMotors_mm<double>(settings_, {point.x_mm, point.y_mm, point.z_mm});
    felt.terms << u * u, v * v, 2 * u * v, u * u * u, u * u * v, u * v * v, v * v * v;
    const auto block = [](double w) {
      const int index = static_cast<int>(std::floor((w + 1) / 2 * kBlocksAcross));
      return std::clamp(index, 0, kBlocksAcross - 1);
    };
    felt.block = {block(u), block(v)};
    if (felt.motors_mm.allFinite()) felt_.push_back(felt);
  }

  DeltaModel<double> settings_;
  double arc_mm_;
  double rim_mm_ = 1;
  std::vector<Felt> felt_;
};

/// Whitened residuals, those of the priors below, and their slopes.
struct Slopes {
  Eigen::MatrixXd slope{};
  Eigen::VectorXd residual{};
};

double PriorSigma_mm(int parameter) {
  if (parameter < 4) return 10;
  if (parameter < kNumSix) return 5;
  return parameter < kNumSix + kNumArms ? 3 : 0.5;
}

Slopes SlopesAt(const Bed& bed,
                const std::vector<const Felt*>& points,
                const std::vector<int>& active,
                const All<double>& p) {
  const auto columns = static_cast<Eigen::Index>(active.size());
  const auto rows = static_cast<Eigen::Index>(points.size());
  All<Jet16> jets;
  for (int i = 0; i < kNumAll; ++i) jets[i] = Jet16(p[i], i);
  const DeltaModel<Jet16> model = bed.Model<Jet16>(jets);
  Slopes at{.slope = Eigen::MatrixXd::Zero(rows + columns, columns),
            .residual = Eigen::VectorXd::Zero(rows + columns)};
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Jet16 off =
        bed.Residual_mm<Jet16>(model, jets, *points[static_cast<std::size_t>(row)]);
    at.residual[row] = off.a / kPoint_mm;
    for (Eigen::Index i = 0; i < columns; ++i) {
      at.slope(row, i) = off.v[active[static_cast<std::size_t>(i)]] / kPoint_mm;
    }
  }
  for (Eigen::Index i = 0; i < columns; ++i) {
    const int parameter = active[static_cast<std::size_t>(i)];
    at.slope(rows + i, i) = 1 / PriorSigma_mm(parameter);
    at.residual[rows + i] = p[parameter] / PriorSigma_mm(parameter);
  }
  return at;
}

/// Sum of the squares of those residuals.
double CostAt(const Bed& bed,
              const std::vector<const Felt*>& points,
              const std::vector<int>& active,
              const All<double>& p) {
  const DeltaModel<double> model = bed.Model<double>(p);
  double cost = 0;
  for (const Felt* felt : points) {
    cost += std::pow(bed.Residual_mm<double>(model, p, *felt) / kPoint_mm, 2);
  }
  for (const int i : active) cost += std::pow(p[i] / PriorSigma_mm(i), 2);
  return cost;
}

/// The step, halved until it does not worsen the fit; nullopt at the minimum.
std::optional<All<double>> ImprovedMeshShape(const Bed& bed,
                                             const std::vector<const Felt*>& points,
                                             const std::vector<int>& active,
                                             const All<double>& from,
                                             const Eigen::VectorXd& step,
                                             const Eigen::VectorXd& residual) {
  constexpr int kMostHalvings = 9;
  double part = 1;
  for (int halving = 0; halving <= kMostHalvings; ++halving, part /= 2) {
    All<double> p = from;
    for (std::size_t i = 0; i < active.size(); ++i) {
      p[active[i]] += part * step[static_cast<Eigen::Index>(i)];
    }
    const double cost = CostAt(bed, points, active, p);
    if (std::isfinite(cost) && cost < residual.squaredNorm()) return p;
  }
  return std::nullopt;
}

struct Fitted {
  All<double> p = All<double>::Zero();
  Eigen::MatrixXd covariance{};  ///< Of the active ones.
};

/// Parameters of a model fitted to points; nullopt where there are not twice as many
/// points, or no minimum is found.
std::optional<Fitted> FitMeshShape(const Bed& bed,
                                   const std::vector<const Felt*>& points,
                                   const std::vector<int>& active) {
  constexpr double kSmall_mm = 1e-7;
  if (points.size() < 2 * active.size()) return std::nullopt;
  All<double> p = All<double>::Zero();
  for (int step = 0; step < kMeshShapeMostSteps; ++step) {
    const Slopes at = SlopesAt(bed, points, active, p);
    if (!at.residual.allFinite()) return std::nullopt;
    const LinearFit fit = SolveLinear(at.slope, -at.residual);
    if (fit.x.norm() < kSmall_mm) return Fitted{.p = p, .covariance = fit.covariance};
    const auto improved = ImprovedMeshShape(bed, points, active, p, fit.x, at.residual);
    if (!improved) return Fitted{.p = p, .covariance = fit.covariance};
    p = *improved;
  }
  return std::nullopt;
}

double SumOfSquares_mm2(const Bed& bed,
                        const std::vector<const Felt*>& points,
                        const All<double>& p) {
  const DeltaModel<double> model = bed.Model<double>(p);
  double sum_mm2 = 0;
  for (const Felt* felt : points) {
    const double off_mm = bed.Residual_mm<double>(model, p, *felt);
    sum_mm2 += off_mm * off_mm;
  }
  return sum_mm2;
}

/// A model's fit, and the squared errors of each block as the others foretell them.
struct Judged {
  MeshFit fit{};
  std::vector<double> blocks_mm2{};  ///< Empty where it is not determined.
};

using Blocks = std::map<std::pair<int, int>, std::vector<const Felt*>>;

Judged Judge(const Bed& bed, const Blocks& blocks, MeshModel which) {
  Judged judged;
  const std::vector<int> active = ActiveOf(which);
  std::vector<const Felt*> all;
  for (const Felt& felt : bed.felt()) all.push_back(&felt);
  const auto count = static_cast<double>(all.size());
  const auto whole = FitMeshShape(bed, all, active);
  if (!whole) return judged;
  judged.fit.rms_mm = std::sqrt(SumOfSquares_mm2(bed, all, whole->p) / count);
  judged.fit.model = bed.Model<double>(whole->p);
  for (std::size_t i = 0; i < 3; ++i) {
    judged.fit.shape_mm[i] =
        whole->p[kNumSix + kNumArms + static_cast<Eigen::Index>(i)];
  }
  if (which == MeshModel::kArms) {
    judged.fit.arm_covariance_mm2 = whole->covariance.bottomRightCorner<3, 3>();
  }
  double sum_mm2 = 0;
  for (const auto& [place, left_out] : blocks) {
    std::vector<const Felt*> rest;
    for (const Felt& felt : bed.felt()) {
      if (felt.block != place) rest.push_back(&felt);
    }
    const auto fit = FitMeshShape(bed, rest, active);
    if (!fit) {
      judged.blocks_mm2.clear();
      return judged;
    }
    judged.blocks_mm2.push_back(SumOfSquares_mm2(bed, left_out, fit->p));
    sum_mm2 += judged.blocks_mm2.back();
  }
  judged.fit.hold_out_rms_mm = std::sqrt(sum_mm2 / count);
  return judged;
}

/// Whether one foretells blocks better than the other, beyond chance.
bool IsBetter(const Judged& one, const Judged& other) {
  constexpr double kStandardErrors = 2;
  if (one.blocks_mm2.empty() || other.blocks_mm2.empty()) return false;
  if (*one.fit.hold_out_rms_mm > kNoteworthy * *other.fit.hold_out_rms_mm) return false;
  const auto count = static_cast<double>(one.blocks_mm2.size());
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < one.blocks_mm2.size(); ++i) {
    const double gain_mm2 = other.blocks_mm2[i] - one.blocks_mm2[i];
    mean += gain_mm2 / count;
    square += gain_mm2 * gain_mm2 / count;
  }
  const double error_mm2 = std::sqrt((square - mean * mean) / (count - 1));
  return mean > kStandardErrors * error_mm2;
}

/// Rods of one machine are cut alike: arms that differ more mimic something else.
bool IsPlausible(const DeltaModel<double>& fitted) {
  constexpr double kMostApart = 0.02;
  const auto [shortest, longest] = std::ranges::minmax(fitted.arm_mm);
  return longest - shortest < kMostApart * shortest;
}

void Conclude(const std::array<Judged, kNumMeshModels>& judged,
              bool are_arms_plausible,
              MeshShape* shape) {
  const auto better = [&](MeshModel one, MeshModel other) {
    return IsBetter(judged[static_cast<std::size_t>(one)],
                    judged[static_cast<std::size_t>(other)]);
  };
  using enum MeshModel;
  const bool are_arms_good = better(kArms, kSix);
  const auto seems_better = [&](MeshModel model) {
    return shape->of(model).hold_out_rms_mm && shape->of(kSix).hold_out_rms_mm &&
           *shape->of(model).hold_out_rms_mm <=
               kNoteworthy * *shape->of(kSix).hold_out_rms_mm;
  };
  const bool is_bed_better = (better(kBed, kSix) && better(kBed, kArms)) ||
                             (better(kCubic, kSix) && better(kCubic, kArms));
  if (!shape->of(kSix).hold_out_rms_mm || !shape->of(kArms).hold_out_rms_mm) {
    shape->reason = "the points are too few to leave blocks out";
  } else if (is_bed_better) {
    shape->verdict = MeshVerdict::kBedShape;
    shape->reason = "a bent bed foretells blocks left out better than free arms";
  } else if (!shape->of(kBed).hold_out_rms_mm || !shape->of(kCubic).hold_out_rms_mm) {
    shape->reason = "the points do not determine a bent bed";
  } else if (!seems_better(kArms) && !seems_better(kBed) && !seems_better(kCubic)) {
    shape->verdict = MeshVerdict::kNeither;
    shape->reason = "nothing foretells blocks left out better than the six numbers";
  } else if (are_arms_good && !are_arms_plausible) {
    shape->reason =
        "the arms that would explain it differ by more than 2 % from each other";
  } else if (are_arms_good && better(kArms, kBed)) {
    shape->verdict = MeshVerdict::kArms;
    shape->reason =
        "free arms foretell blocks left out better than bowl, cylinder and twist";
  } else {
    shape->reason = "the blocks left out do not choose between arms and a bent bed";
  }
}

}  // namespace

std::string Name(MeshVerdict verdict) {
  switch (verdict) {
    case MeshVerdict::kArms:
      return "arms";
    case MeshVerdict::kBedShape:
      return "bed shape";
    case MeshVerdict::kNeither:
      return "neither";
    case MeshVerdict::kCannotTell:
      return "cannot tell";
  }
  return "";
}

MeshShape ExplainMesh(std::span<const BedPoint> points,
                      const DeltaModel<double>& settings) {
  const Bed bed(points, settings);
  Blocks blocks;
  for (const Felt& felt : bed.felt()) blocks[felt.block].push_back(&felt);
  std::array<Judged, kNumMeshModels> judged;
  MeshShape shape{.num_blocks = static_cast<int>(blocks.size())};
  for (std::size_t i = 0; i < kNumMeshModels; ++i) {
    judged[i] = Judge(bed, blocks, static_cast<MeshModel>(i));
    shape.fits[i] = judged[i].fit;
  }
  Conclude(judged, IsPlausible(shape.of(MeshModel::kArms).model), &shape);
  return shape;
}

}  // namespace caltwin
