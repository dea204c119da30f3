#include "scenarios/study/best_readings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "calibration/procedures/plan_model.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

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

// "1 to 4, 6" of ascending numbers.
std::string RangesText(const std::vector<std::size_t>& numbers) {
  std::vector<std::string> texts;
  for (std::size_t from = 0, to = 0; from < numbers.size(); from = to + 1) {
    to = from;
    while (to + 1 < numbers.size() && numbers[to + 1] == numbers[to] + 1) ++to;
    texts.push_back(from == to ? fmt::format("{}", numbers[from])
                               : fmt::format("{} to {}", numbers[from], numbers[to]));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

Json RowJson(const PlanStudy& plan, std::size_t i) {
  const Row& row = plan.row(i);
  Json at;
  for (const Axis axis : kAxes) {
    const double mm = row.cmd_mm[static_cast<std::size_t>(Index(axis))];
    at.push_back(Known(mm) ? Json(mm) : Json(nullptr));
  }
  return {{"row", i + 1},
          {"campaign", row.campaign},
          {"feature", row.feature},
          {"cmd_mm", at},
          {"feed_mm_s", Known(row.feed_mm_s) ? Json(row.feed_mm_s) : Json(nullptr)}};
}

// Which rows are enough, by what they touch: "blocks left.-x 1 to 4, 6".
std::string EnoughText(const PlanStudy& plan,
                       const std::vector<std::size_t>& readings) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> groups;
  for (const std::size_t i : readings) {
    const Row& row = plan.row(i);
    const std::string of = fmt::format("{} {}", row.campaign, row.feature);
    if (groups.empty() || groups.back().first != of) groups.emplace_back(of, 0);
    groups.back().second.push_back(i + 1);
  }
  std::vector<std::string> texts;
  for (const auto& [of, rows] : groups) {
    texts.push_back(fmt::format("{} {}", of, RangesText(rows)));
  }
  return fmt::format("{}", fmt::join(texts, "; "));
}

}  // namespace

ReadingsWorth WorthOf(const PlanStudy& plan) {
  return {.all = RelativeSdOfAll(plan.problem()),
          .enough = EnoughOf(plan.problem(), kAsGood),
          .next_d = BestAfterAll(plan.problem(), Optimal::kD),
          .next_a = BestAfterAll(plan.problem(), Optimal::kA),
          .observed = plan.Observe()};
}

Json ToJson(const PlanStudy& plan, const ReadingsWorth& worth) {
  Json blind = Json::array(), readings = Json::array();
  for (const Observability& one : worth.observed.blind) {
    blind.push_back(
        {{"statement", one.statement}, {"blind_direction", one.blind_direction}});
  }
  for (const std::size_t i : worth.enough.readings)
    readings.push_back(RowJson(plan, i));
  return {{"readings", plan.num_rows()},
          {"machine_time_s", plan.duration_s()},
          {"rank", worth.observed.rank},
          {"unknowns", worth.observed.num_unknowns},
          {"told", worth.observed.determined},
          {"blind", blind},
          {"relative_sd", worth.all},
          {"enough",
           {{"within", kAsGood},
            {"quantities", worth.enough.num_told},
            {"worst", worth.enough.worst},
            {"worst_ratio", worth.enough.largest_ratio},
            {"readings", readings}}},
          {"next",
           {{"d_optimal", RowJson(plan, worth.next_d.reading)},
            {"d_optimal_relative_sd", worth.next_d.relative_sd},
            {"a_optimal", RowJson(plan, worth.next_a.reading)},
            {"a_optimal_relative_sd", worth.next_a.relative_sd}}}};
}

std::string WorthText(const PlanStudy& plan, const ReadingsWorth& worth) {
  return fmt::format(
      "\n{}\nOf {} unknowns (where things lie included) the readings tell {} "
      "directions: their noise-scaled rank.\n"
      "All {} readings leave {:.4f} of what was not known (root mean square of "
      "sd over prior sd); {} of them tell each of the {} quantities that all of them "
      "tell within 5 % of the same sd{}: rows {}.\n"
      "The best one to add: {} (D-optimal), {} (A-optimal).\n",
      InWords(worth.observed),
      worth.observed.num_unknowns,
      worth.observed.rank,
      plan.num_rows(),
      worth.all,
      worth.enough.readings.size(),
      worth.enough.num_told,
      worth.enough.worst.empty()
          ? ""
          : fmt::format(" ({} {:.1f} % more)",
                        worth.enough.worst,
                        kPercent * (worth.enough.largest_ratio - 1)),
      EnoughText(plan, worth.enough.readings),
      PlaceText(plan.row(worth.next_d.reading)),
      PlaceText(plan.row(worth.next_a.reading)));
}

}  // namespace caltwin
