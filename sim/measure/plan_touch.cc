// Campaigns touched by the machine's own probe: blocks, plates, ring.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

struct Face {
  const char* name;
  Axis axis;
  double sign;
};
constexpr std::array kFaces = {Face{"left", Axis::kX, -1},
                               Face{"right", Axis::kX, +1},
                               Face{"front", Axis::kY, -1},
                               Face{"back", Axis::kY, +1},
                               Face{"top", Axis::kZ, +1}};

Vec3<double> OnTable(const PlannedCampaign& campaign, const MeasuringSession& session) {
  Vec3<double> at_mm = session.Middle_mm();
  at_mm[2] = 0;
  if (campaign.options.Numbers("at_mm").size() >= 2) {
    at_mm[0] = campaign.options.Numbers("at_mm")[0];
    at_mm[1] = campaign.options.Numbers("at_mm")[1];
  }
  return at_mm;
}

// A block somewhere on the table: where the center of its base is, and its sizes.
struct Standing {
  std::string setup{}, id{};
  Vec3<double> at_mm = Vec3<double>::Zero();
  Vec3<double> size_mm = Vec3<double>::Ones();
};

std::vector<Row> BlockTouches(const Standing& block, int points, Rng* rng) {
  std::vector<Row> rows;
  for (const Face& face : kFaces) {
    for (int i = 0; i < points; ++i) {
      Vec3<double> p_mm = block.at_mm + Vec3<double>(0, 0, block.size_mm[2] / 2);
      for (const Axis axis : kAxes) {
        const int k = Index(axis);
        p_mm[k] += axis == face.axis
                       ? face.sign * block.size_mm[k] / 2
                       : Rounded((rng->Uniform() - 0.5) * 0.84 * block.size_mm[k]);
      }
      rows.push_back(TouchOf(block.setup,
                             fmt::format("{}.{}", block.id, face.name),
                             p_mm,
                             face.sign * Unit(face.axis)));
    }
  }
  return rows;
}

Vec3<double> Sizes(const PlannedCampaign& campaign,
                   const std::string& option,
                   const MeasuringSession& session) {
  const auto& size_mm = campaign.options.Numbers(option);
  if (size_mm.size() != 3) {
    session.Fail(fmt::format("needs three numbers in {}", option),
                 "sizes of the block, long to short");
  }
  return {size_mm[0], size_mm[1], size_mm[2]};
}

// The touches once more at each angle of the spindle; 0 alone needs no saying.
std::vector<Row> AtAllAngles(const std::vector<Row>& rows,
                             const std::vector<double>& angles_deg) {
  std::vector<Row> at_all_angles;
  for (const double angle_deg : angles_deg) {
    for (Row row : rows) {
      if (angles_deg.size() > 1 || angle_deg != 0) row.probe_angle_deg = angle_deg;
      at_all_angles.push_back(std::move(row));
    }
  }
  return at_all_angles;
}

void TouchBlock(const PlannedCampaign& campaign,
                const std::string& id,
                const Vec3<double>& size_mm,
                int place,
                MeasuringSession* session) {
  // Long, middle and short side along x, y, z, in each way it is laid.
  const std::array<Vec3<double>, 3> lying = {
      Vec3<double>(size_mm[0], size_mm[1], size_mm[2]),
      Vec3<double>(size_mm[1], size_mm[0], size_mm[2]),
      Vec3<double>(size_mm[1], size_mm[2], size_mm[0])};
  for (int way = 0; way < campaign.options.Count("ways"); ++way) {
    Standing block{.setup = fmt::format("{}_{}_{}", campaign.name, id, way + 1),
                   .id = id,
                   .at_mm = session->Middle_mm(),
                   .size_mm = lying[static_cast<std::size_t>(way)]};
    block.at_mm[2] = 0;
    // Each way elsewhere, so that the travel is covered.
    const double angle_rad = 2 * std::numbers::pi * (way + 0.5 * place) / 3 + 0.5;
    for (int k = 0; k < 2; ++k) {
      const double room_mm =
          session->machine().axes[static_cast<std::size_t>(k)].travel_mm() / 2 -
          block.size_mm[k] / 2 - kInset_mm;
      block.at_mm[k] = Rounded(
          block.at_mm[k] + 0.7 * std::max(0.0, room_mm) *
                               (k == 0 ? std::cos(angle_rad) : std::sin(angle_rad)));
    }
    session->Certify(id,
                     {.type = id == "block123" ? "block123" : "block",
                      .sizes_mm = {size_mm[0], size_mm[1], size_mm[2]},
                      .u_um = 0.5});
    const std::vector<Row> rows =
        BlockTouches(block, campaign.options.Count("points"), session->rng());
    TouchAll(AtAllAngles(rows, campaign.options.Numbers("spindle_deg")),
             campaign.options.Numbers("feeds_mm_s"),
             session);
  }
}

// Half the extent of the grid: as asked for, else what all offsets leave of the travel.
Vec3<double> HalfGrid_mm(const PlannedCampaign& campaign,
                         const MeasuringSession& session) {
  const auto& extent_mm = campaign.options.Numbers("extent_mm");
  if (extent_mm.size() >= 2) return {extent_mm[0] / 2, extent_mm[1] / 2, 0};
  double offset_mm = 0;
  for (const double each_mm : campaign.options.Numbers("probe_offset_mm")) {
    offset_mm = std::max(offset_mm, std::abs(each_mm));
  }
  const double margin_mm = campaign.options.Number("margin_mm");
  const Machine& machine = session.machine();
  const Vec3<double> half_mm(
      machine.axis(Axis::kX).travel_mm() / 2 - margin_mm,
      machine.axis(Axis::kY).travel_mm() / 2 - margin_mm - offset_mm,
      0);
  if (half_mm[0] <= 0 || half_mm[1] <= 0) {
    session.Fail("leaves no room for the grid", "smaller offsets or margins will do");
  }
  return half_mm;
}

// The grid is the machine's: a turned plate is touched where the other was.
std::vector<Vec3<double>> GridPoints_mm(const PlannedCampaign& campaign,
                                        const Vec3<double>& half_mm,
                                        const MeasuringSession& session) {
  const auto [along_x, along_y] = GridOf(campaign, session);
  const auto place = [](int i, int count, double half) {
    return Rounded(half * (2.0 * i / (count - 1) - 1));
  };
  Vec3<double> middle_mm = session.Middle_mm();
  middle_mm[2] = campaign.options.Number("height_mm");
  std::vector<Vec3<double>> points_mm;
  for (int i = 0; i < along_x * along_y; ++i) {
    points_mm.emplace_back(middle_mm +
                           Vec3<double>(place(i / along_y, along_x, half_mm[0]),
                                        place(i % along_y, along_y, half_mm[1]),
                                        0));
  }
  return points_mm;
}

std::vector<Row> PlateTouches(const PlannedCampaign& campaign,
                              const std::string& feature,
                              double turn_deg,
                              const std::vector<Vec3<double>>& points_mm) {
  std::vector<Row> rows;
  for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
    for (const Vec3<double>& at_mm : points_mm) {
      rows.push_back(TouchOf(campaign.name, feature, at_mm, Unit(Axis::kZ)));
      rows.back().rep = rep;
      rows.back().artefact_turn_deg = turn_deg;
    }
  }
  return rows;
}

void PlanPlateTurned(const PlannedCampaign& campaign,
                     double turn_deg,
                     MeasuringSession* session) {
  const Vec3<double> half_mm = HalfGrid_mm(campaign, *session);
  const std::string id = ArtefactId(campaign, "plate");
  session->Certify(id, {.type = "plate", .sizes_mm = {2 * half_mm[0], 2 * half_mm[1]}});
  const auto points_mm = GridPoints_mm(campaign, half_mm, *session);
  const auto& offsets_mm = campaign.options.Numbers("probe_offset_mm");
  for (const double offset_mm : offsets_mm) {
    auto rows = PlateTouches(campaign, id + ".top", turn_deg, points_mm);
    const bool is_offset = offsets_mm.size() > 1 || offset_mm != 0;
    for (Row& row : rows) {
      if (is_offset) row.probe_off_mm = {0, offset_mm, 0};
    }
    TouchAll(rows, campaign.options.Numbers("feeds_mm_s"), session);
  }
}

}  // namespace

void PlanBlocks(const PlannedCampaign& campaign, MeasuringSession* session) {
  TouchBlock(campaign,
             ArtefactId(campaign, "block123"),
             Sizes(campaign, "size_mm", *session),
             0,
             session);
  if (campaign.options.Numbers("second_mm").empty()) return;
  TouchBlock(campaign, "block2", Sizes(campaign, "second_mm", *session), 1, session);
}

void PlanPlate(const PlannedCampaign& campaign, MeasuringSession* session) {
  PlanPlateTurned(campaign, 0, session);
}
void PlanPlateTurned90(const PlannedCampaign& campaign, MeasuringSession* session) {
  PlanPlateTurned(campaign, 90, session);
}

void PlanRing(const PlannedCampaign& campaign, MeasuringSession* session) {
  const CampaignOptions& options = campaign.options;
  const double radius_mm = options.Number("diameter_mm") / 2;
  const std::string id = ArtefactId(campaign, "ring");
  session->Certify(id, {.type = "ring", .sizes_mm = {2 * radius_mm}, .u_um = 0.5});
  Vec3<double> center_mm = OnTable(campaign, *session);
  center_mm[2] = options.Number("height_mm");
  const int points = options.Count("points");
  for (const double spindle_deg : options.Numbers("spindle_deg")) {
    std::vector<Row> rows;
    for (int rep = 1; rep <= options.Count("repeats"); ++rep) {
      for (int i = 0; i < points; ++i) {
        const Vec3<double> out = TurnedAboutZ({1, 0, 0}, 360.0 * i / points);
        rows.push_back(
            TouchOf(campaign.name, id + ".bore", center_mm + radius_mm * out, -out));
        rows.back().rep = rep;
        rows.back().probe_angle_deg = spindle_deg;
      }
    }
    TouchAll(rows, options.Numbers("feeds_mm_s"), session);
  }
}

}  // namespace caltwin
