// Campaigns touched by the machine's own probe: blocks, plates, ring, straight-edge,
// square.

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tests/blind/plan.h"

namespace blind {
namespace {

struct Face {
  const char* name;
  int axis;
  double sign;
};
constexpr Face kSides[] = {{"left", 0, -1},
                           {"right", 0, +1},
                           {"front", 1, -1},
                           {"back", 1, +1},
                           {"top", 2, +1}};

/// A block standing somewhere: its sizes along x, y, z.
struct StandingBlock {
  std::string setup{}, artefact{};
  Vector3 center_mm{}, size_mm{};
};

/// Three points on each of its five free faces, at every feed, in random order.
void AddBlockTouches(const std::string& campaign,
                     const StandingBlock& block,
                     const std::vector<double>& feeds_mm_s,
                     Random* random,
                     Plan* plan) {
  std::vector<Stop> stops;
  for (const Face& face : kSides) {
    for (int point = 0; point < 3; ++point) {
      Vector3 at = block.center_mm + Vector3{0, 0, 0.5 * block.size_mm[2]};
      for (std::size_t i = 0; i < 3; ++i) {
        at[i] += static_cast<int>(i) == face.axis
                     ? 0.5 * face.sign * block.size_mm[i]
                     : random->Uniform(-0.42, 0.42) * block.size_mm[i];
      }
      for (const double feed_mm_s : feeds_mm_s) {
        Stop stop = Touch(campaign,
                          block.setup,
                          block.artefact + "." + face.name,
                          at,
                          Along(face.axis, face.sign));
        stop.feed_mm_s = feed_mm_s;
        stops.push_back(stop);
      }
    }
  }
  random->Shuffle(&stops);
  plan->stops.insert(plan->stops.end(), stops.begin(), stops.end());
}

/// The 1-2-3 block with its long side along x, y and z in turn, each time elsewhere.
void AddBlocks(const CampaignRequest& request,
               const std::string& name,
               const Drawing& drawing,
               Random* random,
               Plan* plan) {
  const std::vector<Vector3> lying = {
      {76.2, 50.8, 25.4}, {50.8, 76.2, 25.4}, {50.8, 25.4, 76.2}};
  const std::vector<double> feeds_mm_s =
      request.three_feeds ? std::vector<double>{1, 3, 8} : std::vector<double>{1, 5};
  for (int artefact = 0; artefact < (request.two_artefacts ? 2 : 1); ++artefact) {
    for (std::size_t i = 0; i < lying.size(); ++i) {
      StandingBlock block;
      block.artefact = artefact == 0 ? "block123" : "block45";
      block.size_mm = artefact == 0 ? lying[i] : Vector3{45, 45, 45};
      block.setup = fmt::format("{}_{}_{}", name, block.artefact, i + 1);
      for (std::size_t a = 0; a < 2; ++a) {
        const AxisDrawing& axis = drawing.axis(static_cast<int>(a));
        block.center_mm[a] = random->Uniform(axis.min_mm + 55, axis.max_mm - 55);
      }
      plan->placements[block.setup] = {.artefact = block.artefact,
                                       .center_mm = block.center_mm};
      if (artefact == 1 && i > 0) continue;
      AddBlockTouches(name, block, feeds_mm_s, random, plan);
    }
  }
  plan->artefacts["block123"] = {
      .type = "block", .sizes_mm = {76.2, 50.8, 25.4}, .u_um = 0.5};
  if (request.two_artefacts) {
    plan->artefacts["block45"] = {
        .type = "block", .sizes_mm = {45, 45, 45}, .u_um = 0.5};
  }
  plan->campaigns.push_back({name,
                             "blocks",
                             fmt::format("{{orientations: 3, feeds_mm_s: [{}]}}",
                                         request.three_feeds ? "1, 3, 8" : "1, 5"),
                             "probe"});
}

/// A flat plate over the whole travel, probed in a grid, turned by a quarter or not.
void AddPlate(const CampaignRequest& request,
              const std::string& name,
              double turn_deg,
              const Drawing& drawing,
              Random* random,
              Plan* plan) {
  constexpr int kGrid = 7;
  constexpr double kHeight_mm = 20, kEdge_mm = 8, kOffset_mm = 40;
  const AxisDrawing& x = drawing.axis(0);
  const AxisDrawing& y = drawing.axis(1);
  const double margin_mm = kEdge_mm + (request.two_offsets ? kOffset_mm : 0);
  std::vector<Stop> stops;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      const auto place = [&](double low, double high, int k) {
        return low + (high - low) * k / (kGrid - 1) + random->Uniform(-2, 2);
      };
      const Vector3 at = {place(x.min_mm + kEdge_mm, x.max_mm - kEdge_mm, i),
                          place(y.min_mm + margin_mm, y.max_mm - kEdge_mm, j),
                          kHeight_mm};
      Stop stop = Touch(name, name, "plate.top", at, Along(2));
      stop.turn_deg = turn_deg;
      stops.push_back(stop);
      if (!request.two_offsets) continue;
      stop.offset_mm = {0, kOffset_mm, 0};
      stops.push_back(stop);
    }
  }
  random->Shuffle(&stops);
  plan->stops.insert(plan->stops.end(), stops.begin(), stops.end());
  plan->placements[name] = {.artefact = "plate",
                            .center_mm = {x.Mid_mm(), y.Mid_mm(), 0}};
  plan->artefacts["plate"] = {
      .type = "plate", .sizes_mm = {2 * x.Half_mm(), 2 * y.Half_mm()}, .u_um = 1};
  const bool turned = turn_deg != 0;
  plan->campaigns.push_back({name,
                             turned ? "plate_turned_90" : "plate",
                             fmt::format("{{grid: [7, 7], probe_offset_mm: [0, {}]}}",
                                         request.two_offsets ? kOffset_mm : 0),
                             "probe"});
}

/// A ring from inside in 24 directions, at four spindle orientations.
void AddRing(const std::string& name,
             const Drawing& drawing,
             Random* random,
             Plan* plan) {
  constexpr double kDiameter_mm = 60;
  constexpr int kDirections = 24;
  const Vector3 center = {drawing.axis(0).Mid_mm() + random->Uniform(-40, 40),
                          drawing.axis(1).Mid_mm() + random->Uniform(-40, 40),
                          0};
  const double first_rad = random->Uniform(0.03, 0.2);
  for (const double spindle_deg : {0.0, 90.0, 180.0, 270.0}) {
    std::vector<Stop> stops;
    for (int i = 0; i < kDirections; ++i) {
      const double angle_rad = first_rad + 2 * std::numbers::pi * i / kDirections;
      const Vector3 out = {std::cos(angle_rad), std::sin(angle_rad), 0};
      Stop stop = Touch(name,
                        name,
                        "ring.bore",
                        center + 0.5 * kDiameter_mm * out + Vector3{0, 0, 10},
                        -1 * out);
      stop.ring_radius_mm = 0.5 * kDiameter_mm;
      stop.spindle_deg = spindle_deg;
      stops.push_back(stop);
    }
    random->Shuffle(&stops);
    plan->stops.insert(plan->stops.end(), stops.begin(), stops.end());
  }
  // Its centre is sought first: further off, cos(2 theta) of the second order would
  // show.
  plan->placements[name] = {
      .artefact = "ring", .center_mm = center, .offset_sd_mm = 0.02};
  plan->artefacts["ring"] = {.type = "ring", .sizes_mm = {kDiameter_mm}, .u_um = 0.5};
  plan->campaigns.push_back(
      {name, "ring", "{directions: 24, orientations: 4}", "probe"});
}

/// A straight-edge along an axis, touched on both long sides.
void AddStraightedge(const CampaignRequest& request,
                     const std::string& name,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan) {
  constexpr double kHalfWidth_mm = 10;
  const auto along = static_cast<std::size_t>(request.axis);
  const int across = 1 - request.axis;
  const AxisDrawing& axis = drawing.axis(request.axis);
  const Vector3 center = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  std::vector<Stop> stops;
  for (int i = 0; i < 15; ++i) {
    const double place_mm = axis.min_mm + 8 + (2 * axis.Half_mm() - 16) * i / 14;
    for (const double side : {-1.0, 1.0}) {
      for (int rep = 1; rep <= 3; ++rep) {
        Vector3 at = center + side * kHalfWidth_mm * Along(across) + Vector3{0, 0, 15};
        at[along] = place_mm + random->Uniform(-1, 1);
        stops.push_back(Touch(name,
                              name,
                              side < 0 ? "edge.front" : "edge.back",
                              at,
                              Along(across, side)));
        stops.back().rep = rep;
      }
    }
  }
  random->Shuffle(&stops);
  plan->stops.insert(plan->stops.end(), stops.begin(), stops.end());
  plan->placements[name] = {.artefact = "edge", .center_mm = center};
  plan->artefacts["edge"] = {
      .type = "straight_edge", .sizes_mm = {2 * axis.Half_mm()}, .u_um = 0.3};
  plan->campaigns.push_back({name,
                             "straightedge",
                             fmt::format("{{axis: {}}}", "xyz"[request.axis]),
                             "probe"});
}

/// Both outer edges of a square lying flat; then the square turned by a quarter.
void AddFlatSquare(const std::string& name, const Vector3& center, Plan* plan) {
  constexpr double kLeg_mm = 180;
  for (const double turn_deg : {0.0, 90.0}) {
    const double turn_rad = turn_deg * std::numbers::pi / 180;
    const std::string setup = fmt::format("{}_{:.0f}", name, turn_deg);
    for (int rep = 1; rep <= 2; ++rep) {
      for (int i = 0; i < 20; ++i) {
        // Outer edges meet in a corner; the long leg runs along +x, the short along +y.
        const bool is_long = i < 10;
        const double far_mm = -0.5 * kLeg_mm + 10 + 160.0 * (i % 10) / 9;
        const Vector3 from_center = is_long ? Vector3{far_mm, -0.5 * kLeg_mm, 10}
                                            : Vector3{-0.5 * kLeg_mm, far_mm, 10};
        const Vector3 n = is_long ? Along(1, -1) : Along(0, -1);
        Stop stop = Touch(name,
                          setup,
                          is_long ? "square.long" : "square.short",
                          center + TurnedAboutZ(from_center, turn_rad),
                          TurnedAboutZ(n, turn_rad));
        stop.turn_deg = turn_deg;
        stop.rep = rep;
        plan->stops.push_back(stop);
      }
    }
    plan->placements[setup] = {.artefact = "square", .center_mm = center};
  }
}

/// The blade of a square standing up, touched at many heights from either side, at two
/// places: at a single one the wave of a motor step may pass for a slope.
void AddStandingSquare(const std::string& name,
                       int axis,
                       const Drawing& drawing,
                       Random* random,
                       Plan* plan) {
  for (int stand = 0; stand < 4; ++stand) {
    const double turn_deg = stand % 2 == 0 ? 0 : 180;
    const double sign = turn_deg == 0 ? -1 : 1;
    const std::string setup =
        fmt::format("{}_{}_{:.0f}", name, stand / 2 + 1, turn_deg);
    Vector3 center = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
    center[static_cast<std::size_t>(axis)] += random->Uniform(-60, 60);
    for (int i = 0; i < 14; ++i) {
      const double height_mm = 6 + (drawing.axis(2).max_mm - 20) * i / 13;
      Stop stop = Touch(name,
                        setup,
                        "square.blade",
                        center + Along(axis, 15 * sign) + Vector3{0, 0, height_mm},
                        Along(axis, sign));
      stop.turn_deg = turn_deg;
      plan->stops.push_back(stop);
    }
    plan->placements[setup] = {.artefact = "square", .center_mm = center};
  }
}

}  // namespace

void AddTouchCampaign(const CampaignRequest& request,
                      const std::string& name,
                      const Drawing& drawing,
                      Random* random,
                      Plan* plan) {
  const Vector3 center = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  if (request.kind == "blocks") AddBlocks(request, name, drawing, random, plan);
  if (request.kind == "ring") AddRing(name, drawing, random, plan);
  if (request.kind == "plate") AddPlate(request, name, 0, drawing, random, plan);
  if (request.kind == "plate_turned_90") {
    AddPlate(request, name, 90, drawing, random, plan);
  }
  if (request.kind == "straightedge") {
    AddStraightedge(request, name, drawing, random, plan);
  }
  if (request.kind != "square") return;
  if (request.vertical) {
    AddStandingSquare(name, request.axis, drawing, random, plan);
  } else {
    AddFlatSquare(name, center, plan);
  }
  plan->artefacts["square"] = {.type = "square", .sizes_mm = {180}, .u_um = 0.5};
  plan->campaigns.push_back(
      {name, "square", request.vertical ? "{vertical: true}" : "{turns: 2}", "probe"});
}

}  // namespace blind
