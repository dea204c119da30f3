#include "calibration/kinds/delta/g33_grid.h"

#include <array>
#include <cmath>
#include <numbers>

#include "sim/base/input_error.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr int kNumRing = 6;
constexpr double kCentreCircle = 0.1;  // Of the calibration radius.

struct Layout {
  bool has_centre = true;
  int num_around_centre = 0;
  int per_sixth = 0;  // Of touches on the circle in 60 deg; 0: a tower each.
};

Layout LayoutOf(int points, G33Variant variant) {
  constexpr std::array<Layout, 11> kLayouts = {{{false, 0, 0},
                                                {true, 0, 0},
                                                {true, 0, 0},
                                                {false, 3, 1},
                                                {true, 3, 2},
                                                {true, 6, 3},
                                                {false, 6, 5},
                                                {true, 6, 7},
                                                {true, 9, 3},
                                                {false, 9, 4},
                                                {true, 9, 5}}};
  if (points < 0 || points >= static_cast<int>(kLayouts.size())) {
    throw InputError({}, "?(P)oints implausible (0-10).");
  }
  Layout layout = kLayouts[static_cast<std::size_t>(points)];
  if (points == 6 && variant == G33Variant::kAsPublished) layout.per_sixth = 6;
  return layout;
}

G33Touch TouchAt(double radius_mm, double angle_deg) {
  const double angle_rad = RadFromDeg(angle_deg);
  return {.x_mm = radius_mm * std::cos(angle_rad),
          .y_mm = radius_mm * std::sin(angle_rad)};
}

// The centre and what stands around it, which share alike.
std::vector<G33Touch> CentreTouches(const Layout& layout, double radius_mm) {
  std::vector<G33Touch> touches;
  if (layout.has_centre) touches.push_back(TouchAt(0, 0));
  const int num = layout.num_around_centre;
  // From the tower at 90 deg clockwise; nine begin 20 deg past 150 deg.
  const double first_deg = num == 3 ? 90 : num == 6 ? 150 : 170;
  for (int i = 0; i < num; ++i) {
    touches.push_back(TouchAt(kCentreCircle * radius_mm, first_deg - 360.0 / num * i));
  }
  for (G33Touch& touch : touches) {
    touch.share[0] = 1 / static_cast<double>(touches.size());
  }
  return touches;
}

// One angle of the circle; `step` counts 60 deg / per_sixth from tower a.
std::vector<G33Touch> RadiusTouches(int step,
                                    int per_sixth,
                                    int circles,
                                    double radius_mm) {
  constexpr double kBetweenCircles = 0.1;
  const double past = static_cast<double>(step % per_sixth) / per_sixth;
  const double turn_rad = std::numbers::pi / 2 * past;
  const int near = step / per_sixth, far = (near + 1) % kNumRing;
  std::vector<G33Touch> touches;
  for (int i = 0; i < circles; ++i) {
    // Outward and inward in turn: the shortest way.
    const int circle = step % 2 == 0 ? circles - 1 - i : i;
    G33Touch touch = TouchAt(radius_mm * (1 - kBetweenCircles * circle),
                             210 + 60.0 * step / per_sixth);
    touch.share[1 + near] = std::pow(std::cos(turn_rad), 2) / (per_sixth * circles);
    touch.share[1 + far] += std::pow(std::sin(turn_rad), 2) / (per_sixth * circles);
    touches.push_back(touch);
  }
  return touches;
}

}  // namespace

std::vector<G33Touch> G33Grid(int points,
                              double radius_mm,
                              bool opposite,
                              G33Variant variant) {
  constexpr int kThreeCircles = 8;
  const Layout layout = LayoutOf(points, variant);
  std::vector<G33Touch> touches = CentreTouches(layout, radius_mm);
  if (points == 2) {
    for (int i = opposite ? 1 : 0; i < kNumRing; i += 2) {
      touches.push_back(TouchAt(radius_mm, 210 + 60.0 * i));
      touches.back().share[1 + i] = 1;
    }
  }
  const int circles = points >= kThreeCircles ? 3 : 1;
  for (int step = 0; step < kNumRing * layout.per_sixth; ++step) {
    for (const G33Touch& touch :
         RadiusTouches(step, layout.per_sixth, circles, radius_mm)) {
      touches.push_back(touch);
    }
  }
  return touches;
}

int G33PerSixth(int points, G33Variant variant) {
  return LayoutOf(points, variant).per_sixth;
}

double G33Passes(int harmonic, int per_sixth) {
  double passes = 0;
  for (int j = 1 - per_sixth; j < per_sixth; ++j) {
    const double past = static_cast<double>(j) / per_sixth;
    passes += std::pow(std::cos(std::numbers::pi / 2 * past), 2) *
              std::cos(std::numbers::pi / 3 * harmonic * past);
  }
  return passes / per_sixth;
}

G33Heights G33Restored(const G33Heights& heights_mm, int per_sixth) {
  // Each harmonic of the six, taken out and put back whole.
  G33Heights restored = G33Heights::Zero();
  restored[0] = heights_mm[0];
  for (int i = 0; i < kNumRing; ++i) {
    for (int k = 0; k < kNumRing; ++k) {
      double share = 0;
      for (int harmonic = 0; harmonic <= 3; ++harmonic) {
        const double both = harmonic == 0 || harmonic == 3 ? 1 : 2;
        share += both / kNumRing * std::cos(std::numbers::pi / 3 * harmonic * (i - k)) /
                 G33Passes(harmonic, per_sixth);
      }
      restored[1 + i] += share * heights_mm[1 + k];
    }
  }
  return restored;
}

}  // namespace caltwin
