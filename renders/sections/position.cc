#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

std::string Bar(std::string_view label, double error_mm, double largest_mm) {
  // Never narrower than can be seen.
  const double percent = std::max(0.4, PercentFromFraction(error_mm / largest_mm));
  return fmt::format(
      "<div class=\"bar\"><span class=\"label\">{}</span>"
      "<span class=\"track\"><span class=\"fill\" "
      "style=\"width:{:.1f}%\"></span></span>"
      "<span class=\"number\">{}</span></div>\n",
      label,
      percent,
      LengthText(error_mm));
}

std::string Change(double before_mm, double after_mm) {
  if (after_mm <= 0 || before_mm <= 0) return "";
  const double ratio = before_mm / after_mm;
  if (ratio >= 1) return fmt::format(" That is {:.3g} times smaller.", ratio);
  return fmt::format(" That is {:.3g} times larger.", 1 / ratio);
}

}  // namespace

std::string PositionSection(const RunResult& result,
                            const ReportPictures& /*pictures*/) {
  const double before_mm = result.position_error_before_p95_mm;
  const double after_mm = result.position_error_after_p95_mm;
  const double largest_mm = std::max(before_mm, after_mm);
  if (largest_mm <= 0) return "";
  return fmt::format(
      "<p>{}{} It is the closed forms' answer for the machine as built, with the "
      "settings of then; the calibration never sees it.</p>\n{}{}",
      result.is_error_of_nozzle
          ? "Commanded to 0 over the middle of the bed, the clean nozzle is so far "
            "from "
            "its surface: as homing alone leaves it, and at the end."
          : "At 1000 poses all over the travel, approached in both senses and the mean "
            "offset removed, 95 of 100 are reached with a smaller error than this.",
      Change(before_mm, after_mm),
      Bar("before", before_mm, largest_mm),
      Bar("after", after_mm, largest_mm));
}

}  // namespace caltwin
