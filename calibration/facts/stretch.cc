#include "calibration/facts/stretch.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

/// Means of readings along one axis, by place.
struct Course {
  Eigen::VectorXd at_mm{}, off_mm{};
  double repeats_mm = kUnknown;  ///< Of one reading, about its place's mean.
  double num_repeats = 0;        ///< Readings a place, on average.
};

struct Stretch {
  Eigen::Index from = 0, to = 0;
  double before_mm = 0, after_mm = 0;  ///< The deviation on either side.
  double left2 = HUGE_VAL;
};

Course CourseOf(const Rows& rows, std::size_t axis, const Repeats& repeats) {
  std::map<double, Rows> by_place;
  for (const Row* row : rows) {
    const bool is_along =
        row->kind == RowKind::kPosition && AxisAlong(*row) == static_cast<int>(axis) &&
        Known(row->cmd_mm[axis]) && !repeats.outliers.contains(row->row) &&
        row->flag != kLengthFlag;
    if (is_along) by_place[row->cmd_mm[axis]].push_back(row);
  }
  const auto num = std::ssize(by_place);
  Course course{Eigen::VectorXd(num), Eigen::VectorXd(num)};
  double squares = 0, freedom = 0, readings = 0;
  Eigen::Index i = 0;
  for (const auto& [place_mm, here] : by_place) {
    const Average average = AverageOf(here);
    course.at_mm[i] = place_mm;
    course.off_mm[i++] = average.mean;
    readings += average.num;
    if (average.num < 2) continue;
    squares += (average.num - 1) * average.sd * average.sd;
    freedom += average.num - 1;
  }
  if (freedom > 0) course.repeats_mm = std::sqrt(squares / freedom);
  course.num_repeats = readings / std::max(1.0, static_cast<double>(num));
  return course;
}

double LeftOfLine2(const Course& course) {
  Eigen::MatrixXd columns(course.at_mm.size(), 2);
  columns << Eigen::VectorXd::Ones(course.at_mm.size()), course.at_mm;
  return (course.off_mm - columns * LeastSquares(columns, course.off_mm)).squaredNorm();
}

// Of the deviations on either side of a stretch between two places.
Stretch Between(const Course& course, Eigen::Index from, Eigen::Index to) {
  Eigen::MatrixXd columns(course.at_mm.size(), 2);
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const double share = std::clamp((course.at_mm[i] - course.at_mm[from]) /
                                        (course.at_mm[to] - course.at_mm[from]),
                                    0.0,
                                    1.0);
    columns(i, 0) = 1 - share;
    columns(i, 1) = share;
  }
  const Eigen::VectorXd sides = LeastSquares(columns, course.off_mm);
  return {.from = from,
          .to = to,
          .before_mm = sides[0],
          .after_mm = sides[1],
          .left2 = (course.off_mm - columns * sides).squaredNorm()};
}

// Three places outside at least, one of them on either side.
std::optional<Stretch> BestOf(const Course& course) {
  constexpr Eigen::Index kFewest = 6, kMost = 200, kOutside = 3;
  const Eigen::Index num = course.at_mm.size();
  if (num < kFewest || num > kMost) return std::nullopt;
  Stretch best;
  for (Eigen::Index from = 1; from + 1 < num; ++from) {
    for (Eigen::Index to = from + 1; to + 1 < num; ++to) {
      if (from + num - 1 - to < kOutside) continue;
      const Stretch here = Between(course, from, to);
      if (here.left2 < best.left2) best = here;
    }
  }
  return best.to > 0 ? std::optional(best) : std::nullopt;
}

// Whether it explains the course, and a line does not.
bool Explains(const Stretch& stretch, const Course& course) {
  constexpr double kOfLine = 0.25, kOfExcess = 0.1, kOfNoise = 3;
  const auto num = static_cast<double>(course.at_mm.size());
  const double left_mm = std::sqrt(stretch.left2 / (num - 4));
  const double of_line_mm = std::sqrt(LeftOfLine2(course) / (num - 2));
  const double excess_mm = std::abs(stretch.after_mm - stretch.before_mm);
  const double noise_mm = Known(course.repeats_mm) ? kOfNoise * course.repeats_mm /
                                                         std::sqrt(course.num_repeats)
                                                   : HUGE_VAL;
  // A place that was read once may be off by as much as readings are rounded to.
  const bool is_noise = left_mm < std::max(noise_mm, 1e-12) || noise_mm == HUGE_VAL;
  return left_mm < kOfLine * of_line_mm && left_mm < kOfExcess * excess_mm && is_noise;
}

Fact FactOf(const Stretch& stretch, const Course& course, std::size_t axis) {
  const double from_mm = course.at_mm[stretch.from], to_mm = course.at_mm[stretch.to];
  const double excess_mm = stretch.after_mm - stretch.before_mm;
  const double factor = 1 + excess_mm / (to_mm - from_mm);
  const double left_mm =
      std::sqrt(stretch.left2 / static_cast<double>(course.at_mm.size() - 4));
  const double sd_mm = left_mm * std::sqrt(2.0);
  const char letter = "XYZ"[axis];
  return {
      .id = "stretch",
      .axis = kAxisNames[axis],
      .figures = {{"from_mm", from_mm},
                  {"to_mm", to_mm},
                  {"excess_um", UmFromMm(excess_mm), UmFromMm(sd_mm)},
                  {"factor", factor, sd_mm / (to_mm - from_mm)}},
      .sentence = fmt::format(
          "{} moves what is commanded up to {:g} and from {:g} on; between them it "
          "moves {} times as far, {} mm too {} in all{}. No steps/mm does that, leave "
          "them: look at the drive in that stretch, the belt and its teeth, the guide, "
          "what the carriage runs against",
          letter,
          from_mm,
          to_mm,
          WithSd(factor, sd_mm / (to_mm - from_mm), ""),
          TwoDigits(std::abs(excess_mm)),
          excess_mm > 0 ? "far" : "short",
          Known(course.repeats_mm) ? fmt::format(", and again to {} mm when repeated",
                                                 TwoDigits(course.repeats_mm))
                                   : ""),
      .is_answer = true};
}

/// Rising from 0 in proportion to the place up to one of them, level from there on.
struct Fade {
  double until_mm = 0, at_end_mm = 0, left2 = HUGE_VAL;
};

std::optional<Fade> FadeOf(const Course& course) {
  constexpr Eigen::Index kFewest = 4, kBeyond = 2;
  constexpr double kOfExcess = 0.05, kOfLine = 0.25, kLeast_mm = 0.05;
  const Eigen::Index num = course.at_mm.size();
  if (num < kFewest || course.at_mm[0] <= 0) return std::nullopt;
  Fade best;
  // Two places below it at least: one alone would make a fade of any constant.
  for (Eigen::Index k = 2; k + kBeyond <= num; ++k) {
    const double until_mm = course.at_mm[k];
    const Eigen::VectorXd share = (course.at_mm.array() / until_mm).min(1.0);
    const double size_mm = share.dot(course.off_mm) / share.squaredNorm();
    const double left2 = (course.off_mm - size_mm * share).squaredNorm();
    if (left2 < best.left2) best = {until_mm, size_mm, left2};
  }
  const double left_mm = std::sqrt(best.left2 / static_cast<double>(num - 2));
  // A line through 0 is what steps/mm that are wrong would do.
  const double slope = course.at_mm.dot(course.off_mm) / course.at_mm.squaredNorm();
  const double of_line_mm = (course.off_mm - slope * course.at_mm).norm() /
                            std::sqrt(static_cast<double>(num - 1));
  const double excess_mm = std::abs(best.at_end_mm);
  const double of_constant_mm =
      (course.off_mm.array() - course.off_mm.mean()).matrix().norm() /
      std::sqrt(static_cast<double>(num - 1));
  const bool is_fade = excess_mm > kLeast_mm && left_mm < kOfExcess * excess_mm &&
                       left_mm < kOfLine * std::min(of_line_mm, of_constant_mm);
  return is_fade ? std::optional(best) : std::nullopt;
}

Fact FactOf(const Fade& fade, std::size_t axis) {
  const char letter = "XYZ"[axis];
  return {
      .id = "stretch",
      .axis = kAxisNames[axis],
      .word = "fades",
      .figures = {{"from_mm", 0},
                  {"to_mm", fade.until_mm},
                  {"excess_um", UmFromMm(fade.at_end_mm)},
                  {"factor", 1 + fade.at_end_mm / fade.until_mm}},
      .sentence = fmt::format(
          "{0} is too {1} by {2:.3g} mm a mm up to {3:g} mm, and by the same {4:.3g} "
          "mm from there on: no steps/mm does that, leave them. A correction that "
          "fades out over the first {3:g} mm does, a levelling mesh (fade height) "
          "whose mean is not 0 but {4:.3g} mm: the zero of Z and the probe's offset "
          "do not belong together. Set them anew, or switch the fading off",
          letter,
          fade.at_end_mm > 0 ? "large" : "small",
          std::abs(fade.at_end_mm) / fade.until_mm,
          fade.until_mm,
          std::abs(fade.at_end_mm)),
      .is_answer = true};
}

// Of heights alone, and of each campaign by itself: another one is another setting.
void AddFades(const Rows& rows, const Repeats& repeats, Facts* facts) {
  std::map<std::string, Rows> by_campaign;
  for (const Row* row : rows)
    by_campaign[row->campaign + "|" + row->setup].push_back(row);
  for (const auto& [campaign, members] : by_campaign) {
    constexpr std::size_t kZ = 2;
    const auto fade = FadeOf(CourseOf(members, kZ, repeats));
    if (!fade) continue;
    std::erase_if(facts->all, [](const Fact& fact) {
      return (fact.id == "scale" || fact.id == "offset") && fact.axis == kAxisNames[kZ];
    });
    facts->all.push_back(FactOf(*fade, kZ));
    return;
  }
}

}  // namespace

void FactsOfStretch(const Rows& rows, const Repeats& repeats, Facts* facts) {
  for (std::size_t axis = 0; axis < kAxisNames.size(); ++axis) {
    const Course course = CourseOf(rows, axis, repeats);
    const auto stretch = BestOf(course);
    if (!stretch || !Explains(*stretch, course)) continue;
    std::erase_if(facts->all, [&](const Fact& fact) {
      return fact.id == "scale" && fact.axis == kAxisNames[axis];
    });
    facts->all.push_back(FactOf(*stretch, course, axis));
    return;
  }
  AddFades(rows, repeats, facts);
}

}  // namespace caltwin
