#include "sim/measure/plan_touching.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/units.h"

namespace caltwin {

double Rounded(double mm) {
  return std::round(mm * 1e3) / 1e3;
}

Row TouchOf(const std::string& setup,
            const std::string& feature,
            const Vec3<double>& at_mm,
            const Vec3<double>& n) {
  Row row{.kind = RowKind::kTouch, .setup = setup, .feature = feature};
  for (int i = 0; i < 3; ++i) {
    row.cmd_mm[static_cast<std::size_t>(i)] = at_mm[i];
    row.n[static_cast<std::size_t>(i)] = n[i];
  }
  return row;
}

std::pair<int, int> GridOf(const PlannedCampaign& campaign,
                           const MeasuringSession& session) {
  const auto& grid = campaign.options.Numbers("grid");
  const auto is_whole = [](double number) {
    return number == std::floor(number);
  };
  if (grid.size() != 2 || !std::ranges::all_of(grid, is_whole)) {
    session.Fail("needs two whole numbers in grid", "[7, 7]");
  }
  return {static_cast<int>(grid[0]), static_cast<int>(grid[1])};
}

std::string ArtefactId(const PlannedCampaign& campaign, const std::string& usual) {
  const std::string& said = campaign.options.Text("artefact");
  return said.empty() ? usual : said;
}

void TouchAll(const std::vector<Row>& rows,
              const std::vector<double>& feeds_mm_s,
              MeasuringSession* session) {
  std::vector<Row> all;
  for (const double feed_mm_s : feeds_mm_s) {
    for (const Row& row : rows) {
      all.push_back(row);
      all.back().feed_mm_s = feed_mm_s;
    }
  }
  Shuffle(&all, session->rng());
  for (Row& row : all) session->Touch(std::move(row));
}

Vec3<double> TurnedAboutZ(const Vec3<double>& v, double turn_deg) {
  const double turn_rad = RadFromDeg(turn_deg);
  double c = std::cos(turn_rad);
  double s = std::sin(turn_rad);
  if (std::fmod(turn_deg, 90) == 0) {
    c = std::round(c);
    s = std::round(s);
  }
  return {c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
}

}  // namespace caltwin
