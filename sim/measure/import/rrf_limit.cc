#include "sim/measure/import/rrf_limit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {

void CorrectionLimit::Take(const ConsoleLine& said, int line) {
  const std::string& lower = said.lower;
  if (IsCommand(said, "g30")) {
    const auto x_mm = WordOf(said, 'x'), y_mm = WordOf(said, 'y');
    if (!x_mm || !y_mm || !WordOf(said, 'p')) return;
    if (*WordOf(said, 'p') == 0) points_mm_.clear();
    points_mm_.push_back({*x_mm, *y_mm});
    return;
  }
  if (lower.starts_with("leadscrew adjustments made")) {
    const std::size_t colon = lower.find(':'), comma = lower.find(',');
    const auto num_points = NumberAfter(lower, "points used ");
    if (colon == std::string::npos || comma == std::string::npos || !num_points) return;
    const auto adjustments = NumbersApart(lower.substr(colon, comma - colon));
    fits_exactly_ |= *num_points == static_cast<double>(adjustments.size());
    return;
  }
  const std::size_t limit = lower.find("exceed configured limit of ");
  if (limit == std::string::npos) return;
  const std::size_t colon = lower.find(':', limit);
  if (colon == std::string::npos) return;
  const auto limits_mm = NumbersApart(lower.substr(limit, colon - limit));
  if (limits_mm.size() != 1 || limits_mm[0] <= 0) return;
  limit_mm_ = limits_mm[0];
  corrections_mm_ = NumbersApart(lower.substr(colon));
  line_ = line;
}

void CorrectionLimit::Tell(Imported* imported) const {
  if (fits_exactly_) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kOpen,
         .what = "levelling",
         .sentence =
             "how level it is after: as many points as motors always fit, so "
             "'after 0.000' proves nothing. Probe one point more than there are "
             "motors"});
  }
  std::vector<std::string> beyond, within;
  double largest_mm = 0, sum_mm = 0;
  for (std::size_t i = 0; i < corrections_mm_.size(); ++i) {
    const double move_mm = corrections_mm_[i];
    (std::abs(move_mm) > limit_mm_ ? beyond : within)
        .push_back(fmt::format("motor {} by {:+.3f}", i + 1, move_mm));
    largest_mm = std::max(largest_mm, std::abs(move_mm));
    sum_mm += move_mm;
  }
  if (beyond.empty()) return;
  std::vector<NoteFigure> figures = {{"limit_um", UmFromMm(limit_mm_)},
                                     {"largest_um", UmFromMm(largest_mm)}};
  std::string tilt;
  if (corrections_mm_.size() == 2) {
    const double apart_mm = corrections_mm_[0] - corrections_mm_[1];
    figures.push_back({"tilt_um", UmFromMm(apart_mm)});
    tilt = fmt::format(" Together they are {:+.3f} mm on average and {:.3f} mm apart",
                       sum_mm / 2,
                       std::abs(apart_mm));
    if (points_mm_.size() == 2) {
      tilt += fmt::format(", over points {:.0f} mm apart",
                          std::hypot(points_mm_[1][0] - points_mm_[0][0],
                                     points_mm_[1][1] - points_mm_[0][1]));
    }
    tilt += '.';
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "Line {}: the firmware refused to level and moved nothing, because {} is "
           "more than the limit of {:g} mm{}.{} The limit is S of M671: S{:.0f} lets "
           "these pass. Why it stood so far off these lines do not say; screws that "
           "were "
           "turned, or sank, while the motors were off do that",
           line_,
           fmt::join(beyond, " and "),
           limit_mm_,
           within.empty() ? ""
                          : fmt::format(" ({} is not)", fmt::join(within, " and ")),
           tilt,
           std::ceil(largest_mm * 1.1)),
       .fact = "levelling",
       .word = "limit",
       .figures = std::move(figures)});
}

}  // namespace caltwin
