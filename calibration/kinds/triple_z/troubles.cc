#include "calibration/kinds/triple_z/troubles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "sim/base/units.h"
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
      .found = fmt::format(
          "one touch, at ({:.0f}, {:.0f}), lies {:.3f} mm {} the plane that all others "
          "agree on to {:.3f} mm",
          touches[worst].at_mm[0],
          touches[worst].at_mm[1],
          std::abs(off_mm),
          off_mm > 0 ? "above" : "below",
          rest_mm),
      .advice = off_mm > 0
                    ? "something lies on the bed there, or the probe triggered early; "
                      "clean it and measure again"
                    : "the bed has a dent there, or the probe triggered late; measure "
                      "that place again"};
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
                  .found = fmt::format(
                      "the bed is bent by {:.3f} mm, its middle {}, a smooth shape "
                      "that leaves {:.0f} % of what is off the plane",
                      surface.peak_to_peak_mm,
                      surface.is_hollow ? "low" : "high",
                      PercentFromFraction(surface.squares_mm2 / plane_mm2)),
                  .advice =
                      "no screw takes it out. Level it all the same; a mesh takes "
                      "the rest"};
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

std::string HighResidualAsPublished(const BedPlane& plane) {
  constexpr double kHighResidual_mm = 0.2;
  if (plane.fit.rms_mm <= kHighResidual_mm) return "";
  return fmt::format(
      "residual {:.3f} mm, above 0.2 mm: probe more points (5x5), look for debris on "
      "the bed, check the probe (probe_accuracy)",
      plane.fit.rms_mm);
}

double Unsuspected_mm(const TripleZBench& bench) {
  constexpr double kNobodyStated_mm = 0.02;
  return bench.is_sigma_stated ? bench.sigma_mm
                               : std::max(bench.sigma_mm, kNobodyStated_mm);
}

std::optional<OffPlane> WhyOffPlane(std::span<const BedTouch> touches,
                                    double sigma_mm) {
  if (touches.size() < 4) return std::nullopt;
  const double dof = static_cast<double>(touches.size()) - 3;
  const double rms_mm = std::sqrt(FitSurface(touches, false).squares_mm2 / dof);
  // What touches scatter by chance: within 3 standard deviations of its own.
  if (rms_mm < sigma_mm * (1 + 3 / std::sqrt(2 * dof))) return std::nullopt;
  if (touches.size() < kFewest) {
    return OffPlane{
        .cause = OffPlane::Cause::kFew,
        .size_mm = rms_mm,
        .found = fmt::format("{} touches lie {:.3f} mm rms off their plane, too few "
                             "points to say why",
                             touches.size(),
                             rms_mm),
        .advice =
            "debris under one, a bent bed and touches that do not repeat look "
            "alike. Touch 3x3 or 5x5 points, which tells them apart"};
  }
  if (const auto one = OneTouch(touches, sigma_mm)) return one;
  if (const auto bent = Bent(touches)) return bent;
  return OffPlane{
      .size_mm = rms_mm,
      .found = fmt::format("the touches lie {:.3f} mm rms off their plane in no shape",
                           rms_mm),
      .advice =
          "they do not repeat. Touch one place ten times (probe_accuracy): a "
          "loose probe, or play in Z"};
}

std::string WordsOfAgain(const OffPlane& off,
                         double first_mm,
                         std::span<const double> again_mm) {
  const double count = static_cast<double>(again_mm.size());
  double mean_mm = 0, squares_mm2 = 0;
  for (const double mm : again_mm) mean_mm += mm / count;
  for (const double mm : again_mm) squares_mm2 += (mm - mean_mm) * (mm - mean_mm);
  const double sd_mm = std::sqrt(squares_mm2 / std::max(count - 1, 1.0));
  if (off.cause == OffPlane::Cause::kScatter) {
    const bool is_probe = sd_mm > off.size_mm / 3;
    return off.found +
           fmt::format(". One place touched {} times {} {:.3f} mm: it is the {}",
                       again_mm.size(),
                       is_probe ? "scatters by" : "repeats to",
                       sd_mm,
                       is_probe
                           ? "probe (loose, dirty, play in Z), not the bed"
                           : "bed, rough or bent more finely than these points show. "
                             "Touch more of them");
  }
  const double stays = (mean_mm - first_mm + off.size_mm) / off.size_mm;
  const std::string touched =
      fmt::format(". Touched {} times again it lies {:.3f} mm {}",
                  again_mm.size(),
                  std::abs(stays * off.size_mm),
                  stays * off.size_mm > 0 ? "above" : "below");
  constexpr double kStays = 0.75;
  if (stays < 1 - kStays) {
    return off.found + touched +
           ": that touch was bad, not the bed. Check the probe's "
           "seat and cable";
  }
  if (stays < kStays || off.size_mm == 0) return off.words();
  return off.found + touched +
         (off.size_mm > 0 ? ": debris on the bed, not the probe. Clean that place and "
                            "measure again"
                          : ": a dent in the bed, or a plate that is not seated there, "
                            "not the probe");
}

std::string TouchAgain(TripleZPrinter* printer,
                       const OffPlane& off,
                       std::span<const BedTouch> touches) {
  const bool is_doubted =
      off.cause == OffPlane::Cause::kOneTouch || off.cause == OffPlane::Cause::kScatter;
  if (!is_doubted) return off.words();
  const int times = off.cause == OffPlane::Cause::kOneTouch ? 3 : 10;
  const BedTouch& first = touches[off.touch];
  std::vector<double> again_mm;
  for (int i = 0; i < times; ++i) {
    const auto height_mm = printer->Probe(first.at_mm);
    if (!height_mm) return off.words();
    again_mm.push_back(*height_mm);
  }
  return WordsOfAgain(off, first.height_mm, again_mm);
}

namespace {

// The tilt follows by one part of what it was told, the middle in full.
std::string WhyInPart(const Vec3<double>& told_mm,
                      const Vec3<double>& moved_mm,
                      double enough_mm) {
  constexpr double kLeast = 0.1, kMost = 0.95;
  const Vec3<double> tilt_mm = told_mm.array() - told_mm.mean();
  const Vec3<double> moved_tilt_mm = moved_mm.array() - moved_mm.mean();
  if (tilt_mm.norm() < 2 * enough_mm) return "";
  const double part = moved_tilt_mm.dot(tilt_mm) / tilt_mm.squaredNorm();
  const double rest_mm = (moved_tilt_mm - part * tilt_mm).norm();
  const double middle_mm = std::abs(moved_mm.mean() - told_mm.mean());
  const double doubt_mm = std::max(enough_mm, 0.1 * tilt_mm.norm());
  if (part < kLeast || part > kMost || rest_mm > doubt_mm || middle_mm > doubt_mm) {
    return "";
  }
  return fmt::format(
      "the bed tilted by {:.0f} % of what the screws were told, in the right sense, "
      "and "
      "its middle by all of it: guides hold it, or the screws stand further out than "
      "was assumed, not its motors. Recalibrate: another round leaves {:.0f} % of this "
      "tilt",
      PercentFromFraction(part),
      PercentFromFraction((1 - part) * (1 - part)));
}

}  // namespace

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
  const bool is_named = best != &answers.front() && fits;
  if (is_named && second_mm > 2 * off_mm(*best)) return best->words;
  return WhyInPart(applied_mm, moved_mm, enough_mm);
}

std::string WhyNotLevel(const Vec3<double>& applied_mm,
                        const BedPlane& before,
                        const BedPlane& after,
                        const TripleZBench& bench) {
  Vec3<double> moved_mm;
  for (int i = 0; i < kNumScrews; ++i) {
    const auto& at_mm = bench.drawn_mm[static_cast<std::size_t>(i)];
    moved_mm[i] = after.At_mm(at_mm) - before.At_mm(at_mm);
  }
  const double noise_mm =
      std::max({before.fit.rms_mm, after.fit.rms_mm, bench.sigma_mm});
  return WhyNotLevel(applied_mm, moved_mm, noise_mm);
}

}  // namespace caltwin
