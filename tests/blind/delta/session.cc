#include "tests/blind/delta/session.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace blind {
namespace {

// Where the carriages end up for a commanded pose, and the nozzle with them.
std::optional<Vec> TrueNozzle(const DeltaPaper& paper,
                              const DeltaTruth& truth,
                              const DeltaStop& stop,
                              const Vec& commanded_mm) {
  Vec travel_mm = TravelFor(paper, commanded_mm);
  const ByTower sense = SensesOf(paper, stop);
  DeltaMade made = truth.made;
  for (std::size_t i = 0; i < 3; ++i) {
    double& travel = travel_mm[static_cast<Eigen::Index>(i)];
    travel -= sense[i] * truth.gap_mm[i] / 2;
    if (stop.t_s >= truth.jump_at_s) travel += truth.jump_mm[i];
    // Worn joints: both rods give to the side the carriage is pulled to.
    made.radius_mm[i] += commanded_mm.x() > 0 ? made.slack_mm[i] : -made.slack_mm[i];
  }
  auto nozzle = NozzleAt(paper, made, travel_mm);
  if (nozzle) nozzle->z() += truth.frame_mm_per_k * stop.frame_k;
  return nozzle;
}

std::optional<double> TouchBed(const DeltaPaper& paper,
                               const DeltaTruth& truth,
                               const DeltaStop& stop) {
  Vec commanded_mm = stop.at_mm;
  for (int round = 0; round < 12; ++round) {
    const auto nozzle = TrueNozzle(paper, truth, stop, commanded_mm);
    if (!nozzle) return std::nullopt;
    const double surface_mm = truth.bed.Height_mm(nozzle->x(), nozzle->y()) +
                              truth.offset_mm(stop.setup).z() +
                              truth.bed_mm_per_k * stop.bed_k;
    commanded_mm.z() -= nozzle->z() - surface_mm;
  }
  return commanded_mm.z() - stop.at_mm.z() - truth.probe_mm_per_k * stop.screw_k -
         truth.latency_s * stop.feed_mm_s;
}

DeltaStop TouchAt(const std::string& campaign, double x_mm, double y_mm) {
  return {.campaign = campaign,
          .setup = "bed",
          .feature = "bed.top",
          .at_mm = {x_mm, y_mm, 0},
          .from_mm = {0, 0, 5}};
}

Vec AnySide(Random* random, double far_mm) {
  const double angle = random->Uniform(0, 2 * std::numbers::pi);
  return {far_mm * std::cos(angle), far_mm * std::sin(angle), 0};
}

}  // namespace

double DeltaSurface::Height_mm(double x_mm, double y_mm) const {
  const double u = x_mm / rim_mm, v = y_mm / rim_mm, r = std::hypot(u, v);
  const double twisted = r > 0 ? 2 * u * v * std::pow(r, power - 2) : 0;
  double height_mm = slope_x * x_mm + slope_y * y_mm + bowl_mm * std::pow(r, power) +
                     along_x_mm * std::pow(std::abs(u), power) +
                     along_y_mm * std::pow(std::abs(v), power) + twist_mm * twisted;
  const double far = std::hypot(x_mm - dent_x_mm, y_mm - dent_y_mm) / dent_radius_mm;
  if (far < 1) height_mm -= dent_mm * (1 - far);
  if (r > edge_from) height_mm += edge_mm * (r - edge_from) / (1 - edge_from);
  return height_mm;
}

ByTower SensesOf(const DeltaPaper& paper, const DeltaStop& stop) {
  const Vec moved =
      TravelFor(paper, stop.at_mm) - TravelFor(paper, stop.at_mm + stop.from_mm);
  ByTower sense{};
  for (std::size_t i = 0; i < 3; ++i) {
    sense[i] = moved[static_cast<Eigen::Index>(i)] > 0 ? 1 : -1;
  }
  return sense;
}

std::optional<double> ReadStop(const DeltaPaper& paper,
                               const DeltaTruth& truth,
                               const DeltaStop& stop) {
  if (stop.is_touch) return TouchBed(paper, truth, stop);
  const auto nozzle = TrueNozzle(paper, truth, stop, stop.at_mm);
  if (!nozzle) return std::nullopt;
  const Eigen::AngleAxisd turn(truth.turn(stop.setup), Vec::UnitZ());
  const Vec seen = turn * *nozzle + truth.offset_mm(stop.setup);
  return (seen - stop.at_mm).dot(stop.n);
}

void AddDeltaGrid(const DeltaPaper& paper,
                  Random* random,
                  std::vector<DeltaStop>* stops) {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  const int count = 25 + random->Index(25);
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (int i = 0; i < count; ++i) {
      const double out_mm = paper.bed_radius_mm * std::sqrt(i / (count - 1.0));
      stops->push_back(TouchAt(
          "delta_grid", out_mm * std::cos(golden * i), out_mm * std::sin(golden * i)));
      stops->back().feed_mm_s = 3 + 3 * (repeat + i % 2);
    }
  }
}

void AddDeltaRing(const DeltaPaper& paper,
                  Random* random,
                  std::vector<DeltaStop>* stops) {
  for (const double share : {0.4, 0.7, 1.0}) {
    const int count = 12 + random->Index(13);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      stops->push_back(TouchAt("ring",
                               share * paper.bed_radius_mm * std::cos(angle),
                               share * paper.bed_radius_mm * std::sin(angle)));
      stops->back().feed_mm_s = 3 + 3 * (i % 3);
    }
  }
}

void AddDeltaXy(const DeltaPaper& paper,
                Random* random,
                std::vector<DeltaStop>* stops) {
  const int side = 5 + random->Index(2);
  const std::vector<double> heights_mm =
      random->Chance(0.5) ? std::vector<double>{2} : std::vector<double>{2, 60};
  for (const double z_mm : heights_mm) {
    for (int i = 0; i < side * side; ++i) {
      const int across = i % side, up = i / side;
      const double u = 2.0 * across / (side - 1) - 1;
      const double v = 2.0 * up / (side - 1) - 1;
      const double half_mm = 0.7 * paper.bed_radius_mm;
      DeltaStop stop{.campaign = "delta_xy",
                     .setup = fmt::format("plate{}", z_mm > 30 ? 2 : 1),
                     .feature = "plate.marks",
                     .is_touch = false,
                     .at_mm = {half_mm * u, half_mm * v, z_mm},
                     .from_mm = AnySide(random, 8)};
      for (const Vec& n : {Vec(1, 0, 0), Vec(0, 1, 0)}) {
        stop.n = n;
        stops->push_back(stop);
      }
    }
  }
}

void AddZColumns(const DeltaPaper& paper,
                 Random* random,
                 std::vector<DeltaStop>* stops) {
  const int heights = 6 + random->Index(4);
  for (int place = 0; place < 7; ++place) {
    const double out_mm = place == 0 ? 0 : 0.85 * paper.bed_radius_mm;
    const double angle = std::numbers::pi / 3 * place;
    for (int i = 0; i < heights; ++i) {
      for (const double from_mm : {6.0, -6.0}) {
        stops->push_back({.campaign = "z_columns",
                          .setup = fmt::format("column{}", place + 1),
                          .is_touch = false,
                          .at_mm = {out_mm * std::cos(angle),
                                    out_mm * std::sin(angle),
                                    8 + 100.0 * i / (heights - 1)},
                          .from_mm = {0, 0, from_mm}});
      }
    }
  }
}

}  // namespace blind
