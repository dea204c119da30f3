#include "tests/blind/triple_z/session.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace blind {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Where each nut stands when told so much.
ByScrew NutsFor(const TzTruth& truth, const TzStop& stop, const ByScrew& told_mm) {
  ByScrew nut_mm{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double own_mm = told_mm[static_cast<std::size_t>(truth.driver[i])];
    const double turns = told_mm[i] / truth.wave_length_mm[i];
    // A bent screw is no pure sine.
    const double wave = std::sin(kTurn * turns + truth.wave_phase[i]) +
                        0.08 * std::sin(2 * kTurn * turns + 1);
    nut_mm[i] = own_mm + told_mm[i] * (truth.scale + truth.pitch[i]) +
                truth.wave_mm[i] * wave -
                stop.bed_sense * (truth.gap_mm[i] + truth.all_gap_mm) / 2;
    if (stop.t_s >= truth.jump_at_s) nut_mm[i] += truth.jump_mm[i];
    if (nut_mm[i] > 120) nut_mm[i] -= i == 1 ? truth.sticky_mm : 0;
  }
  return nut_mm;
}

// The plane through three balls, over (x, y): by its normal.
double PlaneOver(const TzPaper& paper,
                 const TzTruth& truth,
                 const ByScrew& nut_mm,
                 double x_mm,
                 double y_mm) {
  std::array<std::array<double, 3>, 3> ball{};
  for (std::size_t i = 0; i < 3; ++i) {
    ball[i] = {paper.screw_x_mm[i] + truth.off_x_mm[i],
               paper.screw_y_mm[i] + truth.off_y_mm[i],
               nut_mm[i]};
  }
  std::array<double, 3> u{}, v{};
  for (std::size_t k = 0; k < 3; ++k) {
    u[k] = ball[1][k] - ball[0][k];
    v[k] = ball[2][k] - ball[0][k];
  }
  const std::array<double, 3> n = {
      u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  return ball[0][2] - (n[0] * (x_mm - ball[0][0]) + n[1] * (y_mm - ball[0][1])) / n[2];
}

// What is left to carry the bed where guides turn it back: each support gives until
// the forces balance, found by letting it settle.
ByScrew Settled(const TzPaper& paper, const TzTruth& truth, const ByScrew& nut_mm) {
  if (truth.held_mm2 == 0) return nut_mm;
  constexpr int kSettle = 200;
  constexpr double kGive = 0.25;  // Of what is out of balance.
  ByScrew x_mm{}, y_mm{}, at_mm = nut_mm;
  double mid_x_mm = 0, mid_y_mm = 0, reach_mm2 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    x_mm[i] = paper.screw_x_mm[i] + truth.off_x_mm[i];
    y_mm[i] = paper.screw_y_mm[i] + truth.off_y_mm[i];
    mid_x_mm += x_mm[i] / 3;
    mid_y_mm += y_mm[i] / 3;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    reach_mm2 += std::pow(x_mm[i] - mid_x_mm, 2) + std::pow(y_mm[i] - mid_y_mm, 2);
  }
  // A rigid bed at rest on its supports: height of its middle, its slopes.
  double mid_mm = (nut_mm[0] + nut_mm[1] + nut_mm[2]) / 3, slope_x = 0, slope_y = 0;
  for (int round = 0; round < kSettle; ++round) {
    double force_mm = 0, turn_x = -truth.held_mm2 * slope_x,
           turn_y = -truth.held_mm2 * slope_y;
    for (std::size_t i = 0; i < 3; ++i) {
      const double dx_mm = x_mm[i] - mid_x_mm, dy_mm = y_mm[i] - mid_y_mm;
      at_mm[i] = mid_mm + slope_x * dx_mm + slope_y * dy_mm;
      force_mm += nut_mm[i] - at_mm[i];
      turn_x += (nut_mm[i] - at_mm[i]) * dx_mm;
      turn_y += (nut_mm[i] - at_mm[i]) * dy_mm;
    }
    mid_mm += kGive * force_mm;
    slope_x += turn_x / (reach_mm2 + truth.held_mm2);
    slope_y += turn_y / (reach_mm2 + truth.held_mm2);
  }
  return at_mm;
}

double Bed(const TzPaper& paper,
           const TzTruth& truth,
           const TzStop& stop,
           double z_mm) {
  TzStop there = stop;
  there.z_mm = z_mm;
  const ByScrew told_mm = ToldFor(paper, there);
  const double x_mm = stop.x_mm, y_mm = stop.y_mm;
  const double u = 2 * x_mm / paper.wide_mm - 1, v = 2 * y_mm / paper.deep_mm - 1;
  const auto plane = truth.plane(stop.home);
  const double far = std::hypot(x_mm - truth.dent_x_mm, y_mm - truth.dent_y_mm) / 60;
  const ByScrew ball_mm = Settled(paper, truth, NutsFor(truth, stop, told_mm));
  return PlaneOver(paper, truth, ball_mm, x_mm, y_mm) + plane[0] +
         plane[1] * (x_mm - paper.wide_mm / 2) + plane[2] * (y_mm - paper.deep_mm / 2) +
         truth.bowl_mm * (u * u + v * v) / 2 + truth.along_x_mm * u * u +
         truth.along_y_mm * v * v + truth.twist_mm * u * v -
         (far < 1 ? truth.dent_mm * (1 - far) : 0) + truth.bed_mm_per_k * stop.bed_k;
}

double Nozzle(const TzPaper& paper,
              const TzTruth& truth,
              const TzStop& stop,
              double z_mm) {
  if (stop.is_on_frame) return paper.high_mm;
  // The carriage stands where the tip is less its offset.
  const double u = 2 * stop.x_mm / paper.wide_mm - 1;
  const double axis_y_mm = stop.y_mm - stop.off_y_mm;
  const double v = 2 * axis_y_mm / paper.deep_mm - 1, w = 2 * z_mm / paper.high_mm - 1;
  const double from_x_mm = stop.x_mm - paper.wide_mm / 2;
  const double from_y_mm = stop.y_mm - paper.deep_mm / 2;
  return paper.high_mm + truth.sag_mm * u * u + truth.rail_mm * v * v -
         std::sin(truth.roll * v / 2) * from_x_mm +
         std::sin(truth.nod * u / 2) * stop.off_y_mm +
         std::sin(truth.lean_y * w / 2) * from_y_mm -
         std::sin(truth.lean_x * w / 2) * from_x_mm +
         truth.frame_mm_per_k * stop.frame_k;
}

double Gap(const TzPaper& paper,
           const TzTruth& truth,
           const TzStop& stop,
           double z_mm) {
  return Nozzle(paper, truth, stop, z_mm) - Bed(paper, truth, stop, z_mm);
}

double Along(double most_mm, int i, int count) {
  constexpr double kMargin_mm = 15;
  return kMargin_mm + (most_mm - 2 * kMargin_mm) * i / (count - 1);
}

TzStop TouchAt(const std::string& campaign, double x_mm, double y_mm) {
  return {.campaign = campaign,
          .setup = "bed",
          .feature = "bed.top",
          .x_mm = x_mm,
          .y_mm = y_mm};
}

void AddColumn(const TzPaper& paper,
               TzStop stop,
               int heights,
               Random* random,
               std::vector<TzStop>* stops) {
  stop.is_touch = false;
  for (int i = 0; i < heights; ++i) {
    stop.z_mm = 8 + (paper.high_mm - 18) * i / (heights - 1.0) + random->Uniform(-2, 2);
    for (const int sense : {1, -1}) {
      stop.bed_sense = sense;
      stops->push_back(stop);
    }
  }
}

}  // namespace

ByScrew ToldFor(const TzPaper& paper, const TzStop& stop) {
  ByScrew told_mm{};
  for (std::size_t i = 0; i < 3; ++i) {
    told_mm[i] = paper.high_mm - stop.z_mm + stop.raised_mm[i];
  }
  return told_mm;
}

double ReadTz(const TzPaper& paper, const TzTruth& truth, const TzStop& stop) {
  if (!stop.is_touch) {
    return Gap(paper, truth, stop, stop.z_mm) - stop.z_mm + truth.zero_mm(stop.setup);
  }
  // The bed rises until nothing is left between it and the nozzle.
  double z_mm = 0;
  for (int i = 0; i < 30; ++i) z_mm -= Gap(paper, truth, stop, z_mm);
  return z_mm - truth.latency_s * stop.feed_mm_s;
}

void AddTzGrid(const TzPaper& paper, Random* random, std::vector<TzStop>* stops) {
  const int side = 5 + random->Index(3);
  const double off_mm = random->Uniform(10, 14);
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (int i = 0; i < side * side; ++i) {
      TzStop stop = TouchAt("tz_grid",
                            Along(paper.wide_mm, i % side, side),
                            Along(paper.deep_mm, i / side, side));
      stop.off_y_mm = repeat * off_mm;
      stop.feed_mm_s = 3 + 3 * ((i + repeat) % 3);
      stops->push_back(stop);
    }
  }
}

void AddTzHeights(const TzPaper& paper, Random* random, std::vector<TzStop>* stops) {
  const int heights = 9 + random->Index(6);
  for (int i = 0; i < 9; ++i) {
    AddColumn(paper,
              {.campaign = "tz_heights",
               .setup = "sensor",
               .feature = "bed.top",
               .x_mm = Along(paper.wide_mm, i % 3, 3),
               .y_mm = Along(paper.deep_mm, i / 3, 3)},
              heights,
              random,
              stops);
  }
}

void AddFixedPost(const TzPaper& paper, Random* random, std::vector<TzStop>* stops) {
  const int heights = 9 + random->Index(6);
  for (std::size_t i = 0; i < 3; ++i) {
    AddColumn(paper,
              {.campaign = "fixed_post",
               .setup = fmt::format("post{}", i + 1),
               .feature = "post.bed",
               .is_on_frame = true,
               .x_mm = paper.screw_x_mm[i],
               .y_mm = paper.screw_y_mm[i]},
              heights,
              random,
              stops);
  }
}

void AddOneByOne(const TzPaper& paper, Random* random, std::vector<TzStop>* stops) {
  const double up_mm = random->Uniform(0.4, 1.5);
  for (int stand = 0; stand < 7; ++stand) {
    for (int i = 0; i < 9; ++i) {
      TzStop stop = TouchAt("screws_one_by_one",
                            Along(paper.wide_mm, i % 3, 3),
                            Along(paper.deep_mm, i / 3, 3));
      if (stand > 0) {
        stop.raised_mm[static_cast<std::size_t>((stand - 1) / 2)] =
            stand % 2 == 1 ? up_mm : -up_mm;
      }
      stops->push_back(stop);
    }
  }
}

}  // namespace blind
