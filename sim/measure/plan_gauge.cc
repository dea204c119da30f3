// Campaigns read by a gauge: laser lines and the ball-bar.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"

namespace caltwin {
namespace {

constexpr double kOverrun_mm = 4;
constexpr double kLineFeed_mm_s = 20;
// Of the room around a target in which chance may put it: neighbours keep their order.
constexpr double kShareOfSpacing = 0.45;
constexpr double kUncommonStep = 1.0137;  // Dense steps fit no period.
constexpr int kChordsPerPoint = 24;

// A line along an axis, read there and back.
struct Line {
  Axis axis = Axis::kX;
  std::string setup{};
  Vec3<double> base_mm = Vec3<double>::Zero();
  std::vector<double> targets_mm{};
  double dwell_s = 2;
  double load_n = kUnknown;
  /// Whether the way back begins with an overrun (else the reversal itself is read).
  bool overruns_back = true;
};

Vec3<double> On(const Line& line, double target_mm) {
  Vec3<double> q_mm = line.base_mm;
  q_mm[Index(line.axis)] = target_mm;
  return q_mm;
}

void Pass(
    const Line& line, double sense, int rep, bool overruns, MeasuringSession* session) {
  std::vector<double> targets_mm = line.targets_mm;
  if (sense < 0) std::ranges::reverse(targets_mm);
  if (overruns) {
    const Vec3<double> q_mm = On(line, targets_mm.front() - sense * kOverrun_mm);
    session->RequireReach(q_mm);
    session->Rapid(q_mm);
  } else {
    targets_mm.erase(targets_mm.begin());  // Read by the pass before.
  }
  for (const double target_mm : targets_mm) {
    session->MoveTo(On(line, target_mm), kLineFeed_mm_s);
    Row row{.kind = RowKind::kPosition, .setup = line.setup, .rep = rep};
    row.load_n = line.load_n;
    row.n = {0, 0, 0};
    row.n[static_cast<std::size_t>(Index(line.axis))] = 1;
    session->ReadGauge(std::move(row), line.dwell_s);
  }
}

void ThereAndBack(const Line& line, int runs, MeasuringSession* session) {
  for (int rep = 1; rep <= runs; ++rep) {
    Pass(line, +1, rep, /*overruns=*/true, session);
    Pass(line, -1, rep, line.overruns_back, session);
  }
}

Line LineOf(const PlannedCampaign& campaign, MeasuringSession* session) {
  Line line{.axis = campaign.options.axis("axis"),
            .setup = campaign.name + "_laser",
            .base_mm = session->Middle_mm(),
            .dwell_s = campaign.options.Number("dwell_s")};
  const auto& at_mm = campaign.options.Numbers("at_mm");
  if (at_mm.empty()) return line;
  if (at_mm.size() != 3) {
    session->Fail("needs three numbers in at_mm",
                  "[x, y, z]: a point that the line runs through");
  }
  line.base_mm = {at_mm[0], at_mm[1], at_mm[2]};
  return line;
}

// Where targets may lie: the travel less margin and overrun.
std::pair<double, double> Reach_mm(const PlannedCampaign& campaign,
                                   Axis axis,
                                   const MeasuringSession& session) {
  const AxisDrawing& drawing = session.machine().axis(axis);
  const double off_mm = std::max(campaign.options.Number("margin_mm"), kOverrun_mm);
  if (drawing.travel_mm() <= 2 * off_mm) {
    session.Fail("leaves no travel between its margins", "choose a smaller margin_mm");
  }
  return {drawing.min_mm + off_mm, drawing.max_mm - off_mm};
}

// Targets on micrometres, in ascending order; by chance within their share of the
// spacing unless regular.
std::vector<double> Targets_mm(const PlannedCampaign& campaign,
                               Axis axis,
                               MeasuringSession* session) {
  const auto [low_mm, high_mm] = Reach_mm(campaign, axis, *session);
  const int count = campaign.options.Count("positions");
  const double spacing_mm = (high_mm - low_mm) / (count - 1);
  std::vector<double> targets_mm;
  for (int i = 0; i < count; ++i) {
    double target_mm = low_mm + i * spacing_mm;
    if (!campaign.options.Flag("regular")) {
      target_mm += (2 * session->rng()->Uniform() - 1) * kShareOfSpacing * spacing_mm;
      target_mm = std::clamp(target_mm, low_mm, high_mm);
    }
    targets_mm.push_back(std::round(target_mm * 1e3) / 1e3);
  }
  return targets_mm;
}

using PointAt = std::function<Vec3<double>(double angle_rad)>;

// All runs of one feed and sense (+1 positive about Z), read on the way.
void TurnBallbar(const PlannedCampaign& campaign,
                 const PointAt& point,
                 double feed_mm_s,
                 double sense,
                 MeasuringSession* session) {
  const int points = campaign.options.Count("points");
  const double step_rad = 2 * std::numbers::pi / points;
  // Not on the quadrants, where an axis just turns round.
  const double start_rad = 0.4 * step_rad;
  const auto arc = [&](double to_rad, double span_rad, int chords) {
    for (int k = chords - 1; k >= 0; --k) {
      session->MoveTo(point(to_rad - sense * span_rad * k / chords), feed_mm_s);
    }
  };
  // Half a turn to come up to speed, every axis having turned round once.
  session->Rapid(point(start_rad - sense * std::numbers::pi));
  arc(start_rad - sense * step_rad,
      std::numbers::pi - step_rad,
      kChordsPerPoint * points / 2);
  for (int i = 0; i < points * campaign.options.Count("runs"); ++i) {
    const double angle_rad = start_rad + sense * i * step_rad;
    arc(angle_rad, step_rad, kChordsPerPoint);
    Row row{.kind = RowKind::kRadial,
            .setup = campaign.name,
            .rep = 1 + i / points,
            .feed_mm_s = feed_mm_s,
            .n = {std::cos(angle_rad), std::sin(angle_rad), 0},
            .feature = "bar.ball"};
    session->ReadGauge(std::move(row), 0);
  }
}

}  // namespace

void PlanIso230(const PlannedCampaign& campaign, MeasuringSession* session) {
  Line line = LineOf(campaign, session);
  line.targets_mm = Targets_mm(campaign, line.axis, session);
  std::vector<double> loads_n = campaign.options.Numbers("loads_n");
  if (loads_n.empty()) loads_n = {kUnknown};
  for (const double load_n : loads_n) {
    line.load_n = load_n;
    ThereAndBack(line, campaign.options.Count("runs"), session);
  }
}

void PlanDense(const PlannedCampaign& campaign, MeasuringSession* session) {
  Line line = LineOf(campaign, session);
  line.overruns_back = false;
  const double lead_mm = session->machine().axis(line.axis).lead_mm;
  const int count =
      static_cast<int>(std::lround(campaign.options.Number("periods") *
                                   campaign.options.Count("points_per_period")));
  const double step_mm =
      lead_mm / campaign.options.Count("points_per_period") * kUncommonStep;
  const auto [low_mm, high_mm] = Reach_mm(campaign, line.axis, *session);
  const double length_mm = count * step_mm;
  if (length_mm > high_mm - low_mm) {
    session->Fail("is longer than the travel", "ask for fewer periods");
  }
  const auto& start = campaign.options.Numbers("start_mm");
  const double start_mm = start.empty() ? low_mm + session->rng()->Uniform() *
                                                       (high_mm - low_mm - length_mm)
                                        : start.front();
  for (int i = 0; i <= count; ++i) {
    line.targets_mm.push_back(std::round((start_mm + i * step_mm) * 1e3) / 1e3);
  }
  session->RequireReach(On(line, line.targets_mm.back()));
  ThereAndBack(line, campaign.options.Count("runs"), session);
}

void PlanAbbe(const PlannedCampaign& campaign, MeasuringSession* session) {
  Line line = LineOf(campaign, session);
  line.targets_mm = Targets_mm(campaign, line.axis, session);
  const Axis lever = campaign.options.axis("lever");
  if (lever == line.axis) {
    session->Fail("has the same axis as lever", "the lever is one of the other two");
  }
  const AxisDrawing& drawing = session->machine().axis(lever);
  std::vector<double> heights_mm = campaign.options.Numbers("heights_mm");
  if (heights_mm.empty()) {
    heights_mm = {drawing.min_mm + 0.1 * drawing.travel_mm(),
                  drawing.max_mm - 0.1 * drawing.travel_mm()};
  }
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    line.base_mm[Index(lever)] = heights_mm[i];
    line.setup = fmt::format("{}_{}", campaign.name, i + 1);
    session->RequireReach(On(line, line.targets_mm.front()));
    ThereAndBack(line, campaign.options.Count("runs"), session);
  }
}

void PlanBallbar(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const double radius_mm = options.Number("radius_mm");
  Vec3<double> center_mm = session->Middle_mm();
  const auto& at_mm = options.Numbers("at_mm");
  for (std::size_t i = 0; i < std::min<std::size_t>(3, at_mm.size()); ++i) {
    center_mm[static_cast<int>(i)] = at_mm[i];
  }
  const auto point = [&](double angle_rad) {
    return Vec3<double>(center_mm + radius_mm * Vec3<double>(std::cos(angle_rad),
                                                             std::sin(angle_rad),
                                                             0));
  };
  for (const double angle_deg : {0.0, 90.0, 180.0, 270.0}) {
    session->RequireReach(point(RadFromDeg(angle_deg)));
  }
  session->Certify("bar", {.type = "ballbar", .sizes_mm = {radius_mm}, .u_um = 0.5});
  for (const double feed_mm_s : options.Numbers("feeds_mm_s")) {
    for (const double sense : options.Numbers("senses")) {
      TurnBallbar(campaign, point, feed_mm_s, sense < 0 ? -1 : 1, session);
    }
  }
}

}  // namespace caltwin
