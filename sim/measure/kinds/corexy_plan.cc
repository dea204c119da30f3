#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "sim/measure/kinds/corexy_options.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"

namespace caltwin {
namespace {

constexpr double kOverrun_mm = 4;
constexpr double kLineFeed_mm_s = 20;
constexpr double kShareOfSpacing = 0.45;

// Distances from the middle along a diagonal, ascending; by chance within their share
// of the spacing.
std::vector<double> Distances_mm(const PlannedCampaign& campaign,
                                 MeasuringSession* session) {
  double reach_mm = 1e9;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const double half_mm = session->machine().axis(axis).travel_mm() / 2;
    const double room_mm =
        half_mm - std::max(campaign.options.Number("margin_mm"), kOverrun_mm);
    reach_mm = std::min(reach_mm, room_mm * std::numbers::sqrt2);
  }
  if (reach_mm <= 0) {
    session->Fail("leaves no travel between its margins", "choose a smaller margin_mm");
  }
  const int count = campaign.options.Count("positions");
  const double spacing_mm = 2 * reach_mm / (count - 1);
  std::vector<double> distances_mm;
  for (int i = 0; i < count; ++i) {
    const double by_chance =
        (2 * session->rng()->Uniform() - 1) * kShareOfSpacing * spacing_mm;
    const double even_mm = -reach_mm + i * spacing_mm;
    distances_mm.push_back(std::clamp(even_mm + by_chance, -reach_mm, reach_mm));
  }
  return distances_mm;
}

void Read(const Vec3<double>& along,
          const std::string& setup,
          int rep,
          double dwell_s,
          MeasuringSession* session) {
  Row row{.kind = RowKind::kPosition, .setup = setup, .rep = rep};
  for (int i = 0; i < 3; ++i) row.n[static_cast<std::size_t>(i)] = along[i];
  session->ReadGauge(std::move(row), dwell_s);
}

// One way along a diagonal, from before its first place on.
void Pass(const PlannedCampaign& campaign,
          const Vec3<double>& along,
          const std::vector<double>& distances_mm,
          const std::string& setup,
          int rep,
          MeasuringSession* session) {
  const Vec3<double> across(-along[1], along[0], 0);
  const auto place_mm = [&](double distance_mm) {
    Vec3<double> q_mm = session->Middle_mm() + distance_mm * along;
    for (double& one_mm : q_mm) one_mm = std::round(one_mm * 1e3) / 1e3;
    return q_mm;
  };
  const double sense = distances_mm.front() < distances_mm.back() ? 1 : -1;
  session->Rapid(place_mm(distances_mm.front() - sense * kOverrun_mm));
  for (const double distance_mm : distances_mm) {
    session->MoveTo(place_mm(distance_mm), kLineFeed_mm_s);
    Read(along, setup, rep, campaign.options.Number("dwell_s"), session);
    if (campaign.options.Flag("across")) {
      Read(across, setup + "_across", rep, 0, session);
    }
  }
}

}  // namespace

void PlanDiagonals(const PlannedCampaign& campaign, MeasuringSession* session) {
  for (const double to_y : {1.0, -1.0}) {
    const std::string setup = campaign.name + (to_y > 0 ? "_a" : "_b");
    const Vec3<double> along = Vec3<double>(1, to_y, 0).normalized();
    std::vector<double> distances_mm = Distances_mm(campaign, session);
    for (int rep = 1; rep <= campaign.options.Count("runs"); ++rep) {
      Pass(campaign, along, distances_mm, setup, rep, session);
      std::ranges::reverse(distances_mm);
      Pass(campaign, along, distances_mm, setup, rep, session);
      std::ranges::reverse(distances_mm);
    }
  }
}

}  // namespace caltwin
