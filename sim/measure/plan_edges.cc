// Campaigns touched along edges: straight-edge and square.

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

// Both outer edges of a square that lies flat, its corner towards -x -y at turn 0.
std::vector<Row> FlatSquare(const PlannedCampaign& campaign,
                            const std::string& id,
                            double turn_deg,
                            const MeasuringSession& session) {
  const double leg_mm = campaign.options.Number("leg_mm");
  const int points = campaign.options.Count("points");
  Vec3<double> center_mm = session.Middle_mm();
  center_mm[2] = kInset_mm;
  std::vector<Row> rows;
  for (int i = 0; i < 2 * points; ++i) {
    const bool is_long = i < points;
    const double along_mm =
        Rounded(-leg_mm / 2 + kInset_mm +
                (leg_mm - 2 * kInset_mm) * (i % points) / (points - 1));
    const Vec3<double> from_center = is_long ? Vec3<double>(along_mm, -leg_mm / 2, 0)
                                             : Vec3<double>(-leg_mm / 2, along_mm, 0);
    const Vec3<double> n = is_long ? Vec3<double>(0, -1, 0) : Vec3<double>(-1, 0, 0);
    rows.push_back(TouchOf(fmt::format("{}_{:.0f}", campaign.name, turn_deg),
                           id + (is_long ? ".long" : ".short"),
                           center_mm + TurnedAboutZ(from_center, turn_deg),
                           TurnedAboutZ(n, turn_deg)));
    rows.back().artefact_turn_deg = turn_deg;
  }
  return rows;
}

// The blade of a square standing up, touched at many heights; turned by half, its other
// side faces the probe.
std::vector<Row> StandingSquare(const PlannedCampaign& campaign,
                                const std::string& id,
                                double turn_deg,
                                const MeasuringSession& session) {
  const Axis across = campaign.options.Text("plane") == "xz" ? Axis::kX : Axis::kY;
  const int points = 2 * campaign.options.Count("points");
  const double sign = std::cos(RadFromDeg(turn_deg)) > 0 ? -1 : 1;
  const double most_mm =
      std::min(campaign.options.Number("leg_mm"),
               session.machine().axis(Axis::kZ).max_mm - 2 * kInset_mm);
  Vec3<double> at_mm = session.Middle_mm() + 15 * sign * Unit(across);
  std::vector<Row> rows;
  for (int i = 0; i < points; ++i) {
    at_mm[2] = Rounded(kInset_mm + (most_mm - kInset_mm) * i / (points - 1));
    rows.push_back(TouchOf(fmt::format("{}_{:.0f}", campaign.name, turn_deg),
                           id + ".blade",
                           at_mm,
                           sign * Unit(across)));
    rows.back().artefact_turn_deg = turn_deg;
  }
  return rows;
}

}  // namespace

void PlanStraightedge(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const Axis axis = options.axis("axis");
  Axis across = options.axis("across");
  if (across == axis) across = axis == Axis::kX ? Axis::kY : Axis::kX;
  const AxisDrawing& drawing = session->machine().axis(axis);
  const double margin_mm = options.Number("margin_mm");
  const double room_mm = drawing.travel_mm() - 2 * margin_mm;
  if (room_mm <= 0) session->Fail("leaves no travel", "choose a smaller margin_mm");
  const std::string id = ArtefactId(campaign, "edge");
  session->Certify(
      id, {.type = "straight_edge", .sizes_mm = {drawing.travel_mm()}, .u_um = 0.3});
  const std::array<const char*, 2> sides =
      across == Axis::kX   ? std::array{"left", "right"}
      : across == Axis::kY ? std::array{"front", "back"}
                           : std::array{"bottom", "top"};
  const int count = options.Count("positions");
  std::vector<Row> rows;
  for (int rep = 1; rep <= options.Count("repeats"); ++rep) {
    for (int i = 0; i < count; ++i) {
      const double spacing_mm = room_mm / (count - 1);
      const double place_mm =
          std::clamp(drawing.min_mm + margin_mm +
                         (i + 0.4 * (session->rng()->Uniform() - 0.5)) * spacing_mm,
                     drawing.min_mm + margin_mm,
                     drawing.max_mm - margin_mm);
      for (const double side : {-1.0, 1.0}) {
        Vec3<double> at_mm = session->Middle_mm();
        at_mm[2] = options.Number("height_mm");
        if (axis == Axis::kZ || across == Axis::kZ) at_mm[2] = session->Middle_mm()[2];
        at_mm[Index(across)] += side * options.Number("width_mm") / 2;
        at_mm[Index(axis)] = Rounded(place_mm);
        rows.push_back(TouchOf(campaign.name,
                               fmt::format("{}.{}", id, sides[side < 0 ? 0 : 1]),
                               at_mm,
                               side * Unit(across)));
        rows.back().rep = rep;
      }
    }
  }
  TouchAll(rows, options.Numbers("feeds_mm_s"), session);
}

void PlanSquare(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const bool is_flat = options.Text("plane") == "xy";
  std::vector<double> turns_deg = options.Numbers("turns_deg");
  if (turns_deg.empty()) turns_deg = {0, is_flat ? 90.0 : 180.0};
  const std::string id = ArtefactId(campaign, "square");
  session->Certify(
      id, {.type = "square", .sizes_mm = {options.Number("leg_mm")}, .u_um = 0.5});
  for (const double turn_deg : turns_deg) {
    std::vector<Row> rows;
    for (int rep = 1; rep <= options.Count("repeats"); ++rep) {
      for (Row row : is_flat ? FlatSquare(campaign, id, turn_deg, *session)
                             : StandingSquare(campaign, id, turn_deg, *session)) {
        row.rep = rep;
        rows.push_back(std::move(row));
      }
    }
    TouchAll(rows, options.Numbers("feeds_mm_s"), session);
  }
}

}  // namespace caltwin
