#include "scenarios/study/best_readings.h"

#include <fmt/format.h>

#include "calibration/procedures/plan_model.h"

namespace caltwin {
namespace {

constexpr double kAsGood = 1.05;
constexpr double kPercent = 100;

// "blocks block.left at x 111.9 y 150.0 z 12.7, 1 mm/s"
std::string PlaceText(const Row& row) {
  std::string text = row.campaign;
  if (!row.feature.empty()) text += " " + row.feature;
  text += " at";
  for (const Axis axis : kAxes) {
    const double mm = row.cmd_mm[static_cast<std::size_t>(Index(axis))];
    if (Known(mm)) text += fmt::format(" {} {:.1f}", Name(axis), mm);
  }
  if (Known(row.feed_mm_s)) text += fmt::format(", {:.3g} mm/s", row.feed_mm_s);
  return text;
}

}  // namespace

ReadingsWorth WorthOf(const PlanStudy& plan) {
  return {.all = RelativeSdOfAll(plan.problem()),
          .enough = EnoughOf(plan.problem(), kAsGood),
          .next_d = BestAfterAll(plan.problem(), Optimal::kD),
          .next_a = BestAfterAll(plan.problem(), Optimal::kA),
          .told = InWords(plan.Observe())};
}

std::string WorthText(const PlanStudy& plan, const ReadingsWorth& worth) {
  return fmt::format(
      "\n{}\nAll {} readings leave {:.4f} of what was not known (root mean square of "
      "sd over prior sd); {} of them tell each of the {} quantities that all of them "
      "tell within 5 % of the same sd{}.\n"
      "The best one to add: {} (D-optimal), {} (A-optimal).\n",
      worth.told,
      plan.num_rows(),
      worth.all,
      worth.enough.readings.size(),
      worth.enough.num_told,
      worth.enough.worst.empty()
          ? ""
          : fmt::format(" ({} {:.1f} % more)",
                        worth.enough.worst,
                        kPercent * (worth.enough.largest_ratio - 1)),
      PlaceText(plan.row(worth.next_d.reading)),
      PlaceText(plan.row(worth.next_a.reading)));
}

}  // namespace caltwin
