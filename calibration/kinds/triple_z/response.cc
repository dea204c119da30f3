#include "calibration/kinds/triple_z/response.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "calibration/estimate/linear_fit.h"
#include "calibration/estimate/touch_noise.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr double kScale_mm = 100;  // Brings columns to like units.
constexpr int kShape = 6;          // 1 x y x^2 x y y^2 of the bed at first.
constexpr int kColumns = kShape + 6;

// Where the other two drivers' responses vanish.
std::optional<Eigen::Vector2d> PlaceOf_mm(const Eigen::Matrix3d& by_driver,
                                          int driver) {
  const Vec3<double> one = by_driver.row((driver + 1) % kNumScrews);
  const Vec3<double> other = by_driver.row((driver + 2) % kNumScrews);
  const double area = one[1] * other[2] - one[2] * other[1];
  if (std::abs(area) < 1e-12) return std::nullopt;
  return Eigen::Vector2d((one[2] * other[0] - one[0] * other[2]) / area,
                         (one[0] * other[1] - one[1] * other[0]) / area);
}

// Responses of the drivers out of the last six unknowns.
Eigen::Matrix3d ByDriver(const Eigen::VectorXd& x) {
  Eigen::Matrix3d by_driver;
  for (int i = 0; i < 2; ++i) {
    by_driver.row(i) << x[kShape + 3 * i], x[kShape + 3 * i + 1] / kScale_mm,
        x[kShape + 3 * i + 2] / kScale_mm;
  }
  by_driver.row(2) = Eigen::RowVector3d(1, 0, 0) - by_driver.row(0) - by_driver.row(1);
  return by_driver;
}

void MatchDrivers(const Pivots<double>& drawn_mm, ScrewResponse* response) {
  std::array<int, kNumScrews> order{0, 1, 2};
  double best_mm2 = -1;
  do {
    double sum_mm2 = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto screw = static_cast<std::size_t>(order[i]);
      sum_mm2 += (response->at_mm[i] - drawn_mm[screw]).squaredNorm();
    }
    if (best_mm2 >= 0 && sum_mm2 >= best_mm2) continue;
    best_mm2 = sum_mm2;
    response->screw_of = order;
  } while (std::ranges::next_permutation(order).found);
}

// Uncertainty of where the screws stand: by small changes of the unknowns.
void PropagateSds(const LinearFit& fit, bool is_sigma_stated, ScrewResponse* response) {
  constexpr double kStep = 1e-5;
  const Eigen::Index n = fit.x.size();
  // Where the touches scatter more than was said, they are believed.
  const double rough = ScatterFactor(fit.chi2_per_dof, fit.dof, is_sigma_stated);
  if (rough > 1) response->dof = fit.dof;
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(n, 2 * kNumScrews);
  for (Eigen::Index k = kShape; k < n; ++k) {
    Eigen::VectorXd moved = fit.x;
    moved[k] += kStep;
    const Eigen::Matrix3d by_driver = ByDriver(moved);
    for (int driver = 0; driver < kNumScrews; ++driver) {
      const auto place_mm = PlaceOf_mm(by_driver, driver);
      if (!place_mm) continue;
      const Eigen::Vector2d& from_mm =
          response->at_mm[static_cast<std::size_t>(driver)];
      slopes.block<1, 2>(k, 2 * driver) = ((*place_mm - from_mm) / kStep).transpose();
    }
  }
  response->at_covariance_mm2 =
      rough * rough * slopes.transpose() * fit.covariance * slopes;
  for (int driver = 0; driver < kNumScrews; ++driver) {
    response->at_sd_mm[static_cast<std::size_t>(driver)] =
        response->at_covariance_mm2.diagonal().segment<2>(2 * driver).cwiseSqrt();
  }
}

}  // namespace

ScrewResponse FitScrewResponse(std::span<const RaisedTouches> stands,
                               const Pivots<double>& drawn_mm,
                               double sigma_mm,
                               bool is_sigma_stated) {
  Eigen::Index rows = 0;
  for (const RaisedTouches& stand : stands) rows += std::ssize(stand.touches);
  Eigen::MatrixXd a(rows, kColumns);
  Eigen::VectorXd r(rows);
  Eigen::Index row = 0;
  for (const RaisedTouches& stand : stands) {
    for (const BedTouch& touch : stand.touches) {
      const double x = touch.at_mm[0] / kScale_mm, y = touch.at_mm[1] / kScale_mm;
      const Vec3<double>& up_mm = stand.raised_mm;
      const double first = up_mm[0] - up_mm[2], second = up_mm[1] - up_mm[2];
      a.row(row) << 1, x, y, x * x, x * y, y * y, first, first * x, first * y, second,
          second * x, second * y;
      r[row++] = touch.height_mm - up_mm[2];
    }
  }
  ScrewResponse response;
  // A response is told where a screw's place is, to a tenth of the bed.
  constexpr double kLargestSd = 0.3;
  const LinearFit fit =
      SolveLinear(a / sigma_mm, r / sigma_mm, {.largest_sd = kLargestSd});
  response.rms_mm = fit.residuals.size() == 0
                        ? 0
                        : sigma_mm * std::sqrt(fit.residuals.squaredNorm() /
                                               static_cast<double>(rows));
  if (fit.weakest.size() == kColumns) {
    response.weakest = fit.weakest.tail<6>().normalized();
  }
  if (!fit.identifiable) return response;
  response.by_driver = ByDriver(fit.x);
  response.chi2_per_dof = fit.chi2_per_dof;
  for (int driver = 0; driver < kNumScrews; ++driver) {
    const auto place_mm = PlaceOf_mm(response.by_driver, driver);
    if (!place_mm) return response;
    response.at_mm[static_cast<std::size_t>(driver)] = *place_mm;
  }
  PropagateSds(fit, is_sigma_stated, &response);
  // Known worse than this, a place is of no use to a firmware.
  constexpr double kLargestSd_mm = 10;
  for (const Eigen::Vector2d& sd_mm : response.at_sd_mm) {
    if (!(sd_mm.maxCoeff() < kLargestSd_mm)) return response;
  }
  MatchDrivers(drawn_mm, &response);
  response.is_told = true;
  return response;
}

std::map<std::string, double> ScrewResponse::WeakestOf() const {
  constexpr double kWorthNaming = 1e-3;
  constexpr std::array<std::string_view, 3> kParts = {"", ".dx", ".dy"};
  std::map<std::string, double> named;
  for (Eigen::Index k = 0; k < weakest.size(); ++k) {
    if (std::abs(weakest[k]) < kWorthNaming) continue;
    named[fmt::format("response.{}{}",
                      ScrewName(static_cast<int>(k / 3)),
                      kParts[static_cast<std::size_t>(k % 3)])] = weakest[k];
  }
  return named;
}

Eigen::Matrix3d LevellingGain(const ScrewResponse& response,
                              const Pivots<double>& believed_mm) {
  Eigen::Matrix3d lifts;
  for (int k = 0; k < kNumScrews; ++k) {
    for (int j = 0; j < kNumScrews; ++j) {
      lifts(k, j) = response.At(j, believed_mm[static_cast<std::size_t>(k)]);
    }
  }
  return Eigen::Matrix3d::Identity() - lifts;
}

Eigen::Matrix3d LevellingGain(const Pivots<double>& standing_mm,
                              const Pivots<double>& believed_mm) {
  Eigen::Matrix3d lifts;
  for (int k = 0; k < kNumScrews; ++k) {
    const Eigen::Vector2d& at_mm = believed_mm[static_cast<std::size_t>(k)];
    lifts.row(k) = ScrewWeights<double>(standing_mm, at_mm[0], at_mm[1]).transpose();
  }
  return Eigen::Matrix3d::Identity() - lifts;
}

double SpectralRadius(const Eigen::Matrix3d& gain) {
  return gain.eigenvalues().cwiseAbs().maxCoeff();
}

LevellingFactor FactorOf(const ScrewResponse& response,
                         const Pivots<double>& believed_mm) {
  constexpr double kMoved_mm = 0.1;
  Eigen::Matrix<double, 6, 1> slopes;
  for (Eigen::Index k = 0; k < slopes.size(); ++k) {
    const auto moved = [&](double by_mm) {
      Pivots<double> at_mm = response.at_mm;
      at_mm[static_cast<std::size_t>(k / 2)][k % 2] += by_mm;
      return SpectralRadius(LevellingGain(at_mm, believed_mm));
    };
    slopes[k] = (moved(kMoved_mm) - moved(-kMoved_mm)) / (2 * kMoved_mm);
  }
  return {.value = SpectralRadius(LevellingGain(response, believed_mm)),
          .sd = std::sqrt(slopes.dot(response.at_covariance_mm2 * slopes))};
}

std::vector<std::string> WordsOfResponse(const ScrewResponse& response,
                                         const Pivots<double>& drawn_mm) {
  constexpr double kSure = 3;      // Standard deviations.
  constexpr double kLeast_mm = 1;  // Nearer is where it should be.
  if (!response.is_told) {
    return {
        "these moves do not tell where the screws stand: raise single screws, one "
        "by one"};
  }
  std::vector<std::string> words;
  const auto& screw_of = response.screw_of;
  int moved = 0;
  for (int i = 0; i < kNumScrews; ++i) {
    const int j = screw_of[static_cast<std::size_t>(i)];
    if (j == i) continue;
    ++moved;
    const bool is_pair = screw_of[static_cast<std::size_t>(j)] == i;
    if (is_pair && i < j) {
      words.push_back(fmt::format("Z{} and Z{} are swapped", i + 1, j + 1));
    }
  }
  if (moved == kNumScrews) {
    words.push_back(fmt::format("the drivers of Z1, Z2, Z3 turn screws {}, {}, {}",
                                screw_of[0] + 1,
                                screw_of[1] + 1,
                                screw_of[2] + 1));
  }
  for (std::size_t i = 0; i < screw_of.size(); ++i) {
    const auto screw = static_cast<std::size_t>(screw_of[i]);
    const Eigen::Vector2d off_mm = response.at_mm[i] - drawn_mm[screw];
    const double sd_mm = response.at_sd_mm[i].norm();
    if (off_mm.norm() < std::max(kLeast_mm, kSure * sd_mm)) continue;
    words.push_back(
        fmt::format("pivot {} is {:.1f} +- {:.1f} mm off (dx {:+.1f}, dy {:+.1f})",
                    screw + 1,
                    off_mm.norm(),
                    sd_mm,
                    off_mm[0],
                    off_mm[1]));
  }
  if (words.empty()) words.push_back("wiring and pivots are as drawn");
  if (const auto held = HeldBedLike(response, drawn_mm)) {
    words.push_back(fmt::format(
        "or all screws stand as drawn and guides hold the bed level against "
        "them (stiffness ratio {:.0f} +- {:.0f} mm^2): touches do not tell "
        "these apart, and levelling by the pivots found is right for both",
        held->stiffness_ratio_mm2,
        held->sd_mm2));
  }
  return words;
}

std::optional<HeldBed> HeldBedLike(const ScrewResponse& response,
                                   const Pivots<double>& drawn_mm) {
  constexpr double kSure = 3;                // Standard deviations.
  constexpr double kMostChiSquared = 15.09;  // 5 degrees of freedom, 99 %.
  if (!response.is_told) return std::nullopt;
  const Eigen::Vector2d middle_mm = (drawn_mm[0] + drawn_mm[1] + drawn_mm[2]) / 3;
  Eigen::Matrix2d spread_mm2 = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& at_mm : drawn_mm) {
    spread_mm2 += (at_mm - middle_mm) * (at_mm - middle_mm).transpose();
  }
  Eigen::Matrix<double, 6, 1> pattern, off;
  for (std::size_t i = 0; i < response.at_mm.size(); ++i) {
    const auto screw = static_cast<std::size_t>(response.screw_of[i]);
    const Eigen::Array2d sd_mm = response.at_sd_mm[i].array();
    const auto row = static_cast<Eigen::Index>(2 * i);
    pattern.segment<2>(row) =
        (spread_mm2.inverse() * (drawn_mm[screw] - middle_mm)).array() / sd_mm;
    off.segment<2>(row) = (response.at_mm[i] - drawn_mm[screw]).array() / sd_mm;
  }
  const HeldBed held{.stiffness_ratio_mm2 = pattern.dot(off) / pattern.squaredNorm(),
                     .sd_mm2 = 1 / pattern.norm()};
  const double chi_squared = (off - held.stiffness_ratio_mm2 * pattern).squaredNorm();
  const bool is_like =
      held.stiffness_ratio_mm2 > kSure * held.sd_mm2 && chi_squared < kMostChiSquared;
  return is_like ? std::optional(held) : std::nullopt;
}

std::string WordsOfGain(const LevellingFactor& factor) {
  if (!factor.converges() && !factor.diverges()) {
    return fmt::format(
        "each levelling round multiplies the tilt by {:.3f} +- {:.3f}: whether it "
        "converges cannot be told",
        factor.value,
        2 * factor.sd);
  }
  constexpr double kSlow = 0.5;
  return fmt::format("each levelling round multiplies the tilt by {:.2f}: {}",
                     factor.value,
                     factor.diverges()      ? "it diverges"
                     : factor.value > kSlow ? "it converges slowly"
                                            : "it converges");
}

}  // namespace caltwin
