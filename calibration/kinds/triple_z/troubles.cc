#include "calibration/kinds/triple_z/troubles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr std::size_t kFewest = 6;      // Touches that tell anything of a shape.
constexpr double kFlatterWithout = 3;   // By so much, and it is one touch alone.
constexpr double kShareOfShape = 0.75;  // Of the squares off the plane.
constexpr double kSure = 4;             // Standard uncertainties.

// Least squares of z over 1, x, y and, with a shape, x^2, xy, y^2, all within -1 .. 1.
struct Surface {
  double squares_mm2 = 0;
  double peak_to_peak_mm = 0;  // Of the shape alone, over the touched places.
  bool is_hollow = false;      // The middle is low.
};

std::vector<BedTouch> Without(std::span<const BedTouch> touches, std::size_t left_out) {
  std::vector<BedTouch> rest;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (i != left_out) rest.push_back(touches[i]);
  }
  return rest;
}

Surface FitSurface(std::span<const BedTouch> touches, bool with_shape) {
  Eigen::Vector2d low_mm = touches.front().at_mm;
  Eigen::Vector2d high_mm = low_mm;
  for (const BedTouch& touch : touches) {
    low_mm = low_mm.cwiseMin(touch.at_mm);
    high_mm = high_mm.cwiseMax(touch.at_mm);
  }
  const Eigen::Index columns = with_shape ? 6 : 3;
  const auto rows = static_cast<Eigen::Index>(touches.size());
  Eigen::MatrixXd terms(rows, columns);
  Eigen::VectorXd heights_mm(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const BedTouch& touch = touches[static_cast<std::size_t>(i)];
    const Eigen::Vector2d half_mm = ((high_mm - low_mm) / 2).cwiseMax(1e-9);
    const Eigen::Vector2d at =
        (touch.at_mm - (low_mm + high_mm) / 2).cwiseQuotient(half_mm);
    heights_mm[i] = touch.height_mm;
    terms.row(i).head(3) << 1, at[0], at[1];
    if (with_shape) terms.row(i).tail(3) << at[0] * at[0], at[0] * at[1], at[1] * at[1];
  }
  const Eigen::MatrixXd normal = terms.transpose() * terms;
  const Eigen::VectorXd fitted = normal.ldlt().solve(terms.transpose() * heights_mm);
  Surface surface{.squares_mm2 = (heights_mm - terms * fitted).squaredNorm()};
  if (with_shape) {
    // Of the shape what a plane leaves: a parabola has a mean.
    Eigen::VectorXd shape = terms.rightCols(3) * fitted.tail(3);
    shape -= terms.leftCols(3) * (terms.leftCols(3).transpose() * terms.leftCols(3))
                                     .ldlt()
                                     .solve(terms.leftCols(3).transpose() * shape);
    surface.peak_to_peak_mm = shape.maxCoeff() - shape.minCoeff();
    surface.is_hollow = fitted[3] + fitted[5] > 0;
  }
  return surface;
}

std::optional<OffPlane> OneTouch(std::span<const BedTouch> touches, double sigma_mm) {
  const double all_mm2 = FitSurface(touches, false).squares_mm2;
  std::size_t worst = 0;
  double least_mm2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const double left_mm2 = FitSurface(Without(touches, i), false).squares_mm2;
    if (left_mm2 >= least_mm2) continue;
    least_mm2 = left_mm2;
    worst = i;
  }
  const auto count = static_cast<double>(touches.size());
  const double rms_mm = std::sqrt(all_mm2 / count);
  const double rest_mm =
      std::max(std::sqrt(least_mm2 / std::max(count - 4, 1.0)), sigma_mm);
  const std::vector<BedTouch> rest = Without(touches, worst);
  const BedPlane plane = FitBedPlane(rest, sigma_mm, /*is_sigma_stated=*/false);
  const double off_mm = touches[worst].height_mm - plane.At_mm(touches[worst].at_mm);
  const bool sticks_out = rms_mm > kFlatterWithout * std::sqrt(least_mm2 / count) &&
                          std::abs(off_mm) > kSure * rest_mm;
  if (!sticks_out) return std::nullopt;
  return OffPlane{
      .cause = OffPlane::Cause::kOneTouch,
      .touch = worst,
      .size_mm = off_mm,
      .words = fmt::format(
          "one touch, at ({:.0f}, {:.0f}), lies {:.3f} mm {} the plane that all others "
          "agree on to {:.3f} mm: {}",
          touches[worst].at_mm[0],
          touches[worst].at_mm[1],
          std::abs(off_mm),
          off_mm > 0 ? "above" : "below",
          rest_mm,
          off_mm > 0 ? "something lies on the bed there, or the probe triggered early; "
                       "clean it and measure again"
                     : "the bed has a dent there, or the probe triggered late; measure "
                       "that place again")};
}

std::optional<OffPlane> Bent(std::span<const BedTouch> touches) {
  const double plane_mm2 = FitSurface(touches, false).squares_mm2;
  const Surface surface = FitSurface(touches, true);
  const double dof = static_cast<double>(touches.size()) - 6;
  if (dof < 2) return std::nullopt;
  const double f = (plane_mm2 - surface.squares_mm2) / 3 /
                   std::max(surface.squares_mm2 / dof, 1e-12);
  // 99 % of F(3, dof), between its values of few and of many degrees of freedom.
  const double chance = 3.8 * (1 + 8 / (dof * dof) + 2 / dof);
  const bool takes_most =
      plane_mm2 - surface.squares_mm2 > kShareOfShape * plane_mm2 && f > chance;
  if (!takes_most) return std::nullopt;
  return OffPlane{.cause = OffPlane::Cause::kBent,
                  .size_mm = surface.peak_to_peak_mm,
                  .words = fmt::format(
                      "the bed is bent by {:.3f} mm, its middle {}: a smooth shape "
                      "that no screw takes out. Level it all the same; a mesh "
                      "takes the rest",
                      surface.peak_to_peak_mm,
                      surface.is_hollow ? "low" : "high")};
}

// A way in which screws may answer, and how it is said.
struct Answer {
  Vec3<double> moved_mm = Vec3<double>::Zero();
  std::string words{};
};

std::vector<Answer> Answers(const Vec3<double>& told_mm) {
  std::vector<Answer> answers = {
      {told_mm, ""},
      {Vec3<double>::Zero(),
       "the bed did not move: do the Z motors turn, are their cables plugged in?"},
      {-told_mm,
       "the bed went the other way: the Z motors turn against the sign that was "
       "assumed"}};
  for (int i = 0; i < kNumScrews; ++i) {
    Vec3<double> still_mm = told_mm;
    still_mm[i] = 0;
    answers.push_back({still_mm,
                       fmt::format("{} did not move: look at its motor, its cable and "
                                   "its coupling",
                                   ScrewName(i))});
    const int j = (i + 1) % kNumScrews;
    Vec3<double> swapped_mm = told_mm;
    std::swap(swapped_mm[i], swapped_mm[j]);
    answers.push_back({swapped_mm,
                       fmt::format("{} and {} are exchanged: each moved by what the "
                                   "other was told. Exchange their cables, or their "
                                   "places in the firmware (M671, M584)",
                                   ScrewName(std::min(i, j)),
                                   ScrewName(std::max(i, j)))});
  }
  for (const int by : {1, 2}) {
    Vec3<double> turned_mm;
    for (int i = 0; i < kNumScrews; ++i) turned_mm[i] = told_mm[(i + by) % kNumScrews];
    answers.push_back(
        {turned_mm,
         "all three Z motors are exchanged in a ring: bring their cables, "
         "or their places in the firmware, into order"});
  }
  return answers;
}

}  // namespace

std::optional<OffPlane> WhyOffPlane(std::span<const BedTouch> touches,
                                    double sigma_mm) {
  if (touches.size() < kFewest) return std::nullopt;
  const double dof = static_cast<double>(touches.size()) - 3;
  const double rms_mm = std::sqrt(FitSurface(touches, false).squares_mm2 / dof);
  // What touches scatter by chance: within 3 standard deviations of its own.
  if (rms_mm < sigma_mm * (1 + 3 / std::sqrt(2 * dof))) return std::nullopt;
  if (const auto one = OneTouch(touches, sigma_mm)) return one;
  if (const auto bent = Bent(touches)) return bent;
  return OffPlane{
      .size_mm = rms_mm,
      .words = fmt::format("the touches lie {:.3f} mm rms off their plane in no shape: "
                           "they do not repeat. Touch one place ten times "
                           "(probe_accuracy): a loose probe, or play in Z",
                           rms_mm)};
}

std::string WhyNotLevel(const Vec3<double>& applied_mm,
                        const Vec3<double>& moved_mm,
                        double noise_mm) {
  const std::vector<Answer> answers = Answers(applied_mm);
  const auto off_mm = [&](const Answer& answer) {
    return (answer.moved_mm - moved_mm).norm();
  };
  const double enough_mm = kSure * noise_mm * std::sqrt(3.0);
  if (off_mm(answers.front()) < enough_mm) return "";
  const Answer* best = &answers.front();
  double second_mm = std::numeric_limits<double>::infinity();
  for (const Answer& answer : answers) {
    if (off_mm(answer) < off_mm(*best)) best = &answer;
  }
  for (const Answer& answer : answers) {
    const bool is_other = (answer.moved_mm - best->moved_mm).norm() > enough_mm;
    if (is_other) second_mm = std::min(second_mm, off_mm(answer));
  }
  // The next best has to be clearly worse, and what is named has to fit.
  const bool fits = off_mm(*best) < std::max(enough_mm, 0.1 * applied_mm.norm());
  return fits && second_mm > 2 * off_mm(*best) ? best->words : "";
}

}  // namespace caltwin
