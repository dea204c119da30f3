#include "tests/blind/machine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace blind {
namespace {

constexpr double kStandOff_mm = 4;
constexpr double kSearch_mm = 0.15;

double Rad(double angle_deg) {
  return angle_deg * std::numbers::pi / 180;
}

}  // namespace

Machine::Machine(const Drawing& drawing, const Truth& truth)
    : drawing_(drawing), truth_(truth) {
  for (int i = 0; i < 3; ++i) {
    carriages_[static_cast<std::size_t>(i)].commanded_mm = drawing_.axis(i).Mid_mm();
  }
}

double Machine::Gap_mm(int axis, double q_mm) const {
  double gap_mm = truth_.gap_mm[static_cast<std::size_t>(axis)];
  for (const Defect& defect : truth_.defects) {
    if (defect.gap) gap_mm += defect.size * defect.gap(axis, q_mm);
  }
  return gap_mm;
}

// The play operator: the carriage stays until the nut has crossed the gap. The gap may
// vary along the screw, so a long move is taken in parts.
void Machine::MoveAxis(int axis, double to_mm, Carriage* carriage) const {
  const double way_mm = to_mm - carriage->commanded_mm;
  if (std::abs(way_mm) < 1e-12) return;
  const double dir = way_mm > 0 ? 1 : -1;
  if (dir != carriage->dir) carriage->since_rev_mm = 0;
  carriage->dir = dir;
  carriage->since_rev_mm += std::abs(way_mm);
  const int parts = std::abs(way_mm) > 1 ? 4 : 1;
  for (int i = 1; i <= parts; ++i) {
    const double half_mm = 0.5 * Gap_mm(axis, to_mm - way_mm * (parts - i) / parts);
    carriage->lag_mm = std::clamp(carriage->lag_mm - way_mm / parts, -half_mm, half_mm);
  }
  carriage->commanded_mm = to_mm;
}

Machine::Carriages Machine::Moved(Carriages carriages, const Vector3& to_mm) const {
  for (std::size_t i = 0; i < 3; ++i) {
    MoveAxis(static_cast<int>(i), to_mm[i], &carriages[i]);
  }
  return carriages;
}

Instant Machine::InstantOf(const Stop& stop,
                           const Carriages& carriages,
                           double t_s) const {
  Instant at;
  at.kind = stop.kind;
  at.t_s = t_s;
  at.home = home_;
  at.homed_t_s = homed_t_s_;
  for (std::size_t i = 0; i < 3; ++i) {
    at.q_mm[i] = carriages[i].commanded_mm;
    at.dir[i] = carriages[i].dir;
    at.since_rev_mm[i] = carriages[i].since_rev_mm;
  }
  at.feed_mm_s = stop.feed_mm_s;
  const std::size_t main = std::abs(stop.n[0]) > 0.7   ? 0
                           : std::abs(stop.n[1]) > 0.7 ? 1
                                                       : 2;
  at.load_n = stop.load_n < 0 ? drawing_.axes[main].friction_n : stop.load_n;
  at.n = stop.n;
  at.spindle_rad = Rad(stop.spindle_deg);
  at.offset_mm = stop.offset_mm;
  at.artefact = stop.feature.substr(0, stop.feature.find('.'));
  at.turn_rad = Rad(stop.turn_deg);
  at.point_mm = stop.at_mm;
  at.on_circle = stop.circle_radius_mm > 0;
  at.radius_mm = stop.circle_radius_mm;
  at.sense = stop.sense;
  at.center_mm = plan_->placements.at(stop.setup).center_mm;
  return at;
}

// Position errors of the three drives, then everything that bends the tip away:
// actual tip = commanded + offset + motion error.
Vector3 Machine::Tip_mm(const Carriages& carriages, const Instant& instant) const {
  Vector3 tip = instant.q_mm + instant.offset_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisDrawing& axis = drawing_.axes[i];
    const double home_mm = i == 2 ? axis.max_mm : axis.min_mm;
    // An axis that moves 1 % too far: +0.01 (q - q_home).
    tip[i] += truth_.scale[i] * (instant.q_mm[i] - home_mm) + carriages[i].lag_mm;
  }
  for (const Defect& defect : truth_.defects) {
    if (defect.motion) tip = tip + defect.size * defect.motion(instant);
  }
  return tip;
}

// The stylus is a spring of its own stiffness along each axis; between them the
// pre-travel is the ellipse 1 / sqrt(sum (n_i / p_i)^2).
double Machine::Pretravel_mm(const Instant& instant) const {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double ratio = instant.n[i] / truth_.pretravel_mm[i];
    sum += ratio * ratio;
  }
  double pretravel_mm = 1 / std::sqrt(sum);
  for (const Defect& defect : truth_.defects) {
    if (defect.pretravel) pretravel_mm += defect.size * defect.pretravel(instant);
  }
  return pretravel_mm;
}

// Distance of the tip's centre from the true surface, minus its radius, plus the
// pre-travel: zero at the trigger, positive outside.
double Machine::Clearance_mm(const Stop& stop,
                             const Vector3& tip_mm,
                             const Instant& at) const {
  const Placement& placement = plan_->placements.at(stop.setup);
  const Standing& standing = truth_.standing.at(stop.setup);
  double radius_mm = truth_.tip_radius_mm;
  double surface_mm = 0;
  for (const Defect& defect : truth_.defects) {
    radius_mm += defect.size * defect.tip_radius_mm;
    if (defect.surface) surface_mm += defect.size * defect.surface(at);
  }
  const double trigger_mm = radius_mm + surface_mm - Pretravel_mm(at);
  if (stop.ring_radius_mm > 0) {
    const Vector3 away = tip_mm - placement.center_mm - standing.offset_mm;
    return stop.ring_radius_mm - std::hypot(away[0], away[1]) - trigger_mm;
  }
  // The plane through the nominal point, turned about the artefact's vertical, moved,
  // then leant with the table about the middle of the travel at z = 0.
  Vector3 point = placement.center_mm + standing.offset_mm +
                  TurnedAboutZ(stop.at_mm - placement.center_mm, standing.turn_rad);
  Vector3 normal = TurnedAboutZ(stop.n, standing.turn_rad);
  if (placement.on_table) {
    // Rotation w with dz = s_x x + s_y y: w = (s_y, -s_x, 0); dx = -s_x z.
    const Vector3 w = {truth_.bed_slope_y, -truth_.bed_slope_x, 0};
    const Vector3 middle = {drawing_.axis(0).Mid_mm(), drawing_.axis(1).Mid_mm(), 0};
    point = point + Cross(w, point - middle);
    normal = normal + Cross(w, normal);
    normal = (1 / Norm(normal)) * normal;
  }
  return Dot(tip_mm - point, normal) - trigger_mm;
}

Reading Machine::Gauge(const Stop& stop, double t_s) {
  const Vector3 before = {carriages_[0].commanded_mm,
                          carriages_[1].commanded_mm,
                          carriages_[2].commanded_mm};
  Vector3 last = before;
  for (const Vector3& via : stop.via) {
    carriages_ = Moved(carriages_, via);
    last = via;
  }
  carriages_ = Moved(carriages_, stop.at_mm);
  Reading reading{.stop = &stop, .instant = InstantOf(stop, carriages_, t_s)};
  for (std::size_t i = 0; i < 3; ++i) {
    const bool moved = std::abs(stop.at_mm[i] - last[i]) > 1e-9;
    reading.dir[i] = moved ? carriages_[i].dir : 0;
  }
  const Standing& standing = truth_.standing.at(stop.setup);
  const Vector3 tip = Tip_mm(carriages_, reading.instant);
  if (stop.kind == Kind::kRadial) {
    // The bar reads its length between the tip and where its pivot truly stands.
    const Vector3 bar =
        tip - plan_->placements.at(stop.setup).center_mm - standing.offset_mm;
    reading.value_mm = Norm(bar) - stop.circle_radius_mm;
  } else {
    // (actual - commanded) . n, from a zero set by hand.
    reading.value_mm = Dot(tip - stop.at_mm + standing.offset_mm, stop.n);
  }
  for (const Defect& defect : truth_.defects) {
    if (defect.reading)
      reading.value_mm += defect.size * defect.reading(reading.instant);
  }
  return reading;
}

// The tip goes along -n until it triggers. s: how far the commanded tip centre stands
// outside the nominal contact. value = (reported - nominal) . n
//   = (tip centre - nominal) . n - R_cfg = s.
Reading Machine::Touch(const Stop& stop, double t_s) {
  const auto commanded = [&](double s_mm) {
    return stop.at_mm + (drawing_.tip_radius_cfg_mm + s_mm) * stop.n - stop.offset_mm;
  };
  carriages_ = Moved(carriages_, commanded(kStandOff_mm));
  const Carriages outside = carriages_;
  const auto clearance = [&](double s_mm) {
    const Carriages now = Moved(outside, commanded(s_mm));
    const Instant at = InstantOf(stop, now, t_s);
    return Clearance_mm(stop, Tip_mm(now, at), at);
  };
  double guess_mm = 0;  // Then the first crossing on the way in, then its bisection.
  for (int i = 0; i < 4; ++i) guess_mm -= clearance(guess_mm);
  double outer_mm = std::min(guess_mm + kSearch_mm, kStandOff_mm);
  double inner_mm = outer_mm;
  while (clearance(inner_mm) > 0 && inner_mm > guess_mm - kSearch_mm) {
    outer_mm = inner_mm;
    inner_mm -= 0.004;
  }
  for (int i = 0; i < 28; ++i) {
    const double middle_mm = 0.5 * (outer_mm + inner_mm);
    (clearance(middle_mm) > 0 ? outer_mm : inner_mm) = middle_mm;
  }
  carriages_ = Moved(outside, commanded(inner_mm));
  Reading reading{.stop = &stop, .instant = InstantOf(stop, carriages_, t_s)};
  for (std::size_t i = 0; i < 3; ++i) {
    reading.dir[i] = std::abs(stop.n[i]) > 1e-9 ? carriages_[i].dir : 0;
  }
  reading.value_mm = reading.trigger_mm = inner_mm;
  for (const Defect& defect : truth_.defects) {
    if (defect.reading)
      reading.value_mm += defect.size * defect.reading(reading.instant);
  }
  return reading;
}

std::vector<Reading> Machine::Perform(const Plan& plan,
                                      const std::vector<double>& times_s) {
  plan_ = &plan;
  std::vector<Reading> readings;
  readings.reserve(plan.stops.size());
  for (std::size_t i = 0; i < plan.stops.size(); ++i) {
    const Stop& stop = plan.stops[i];
    if (stop.rehome) {
      ++home_;
      homed_t_s_ = times_s[i] - 1;
      carriages_ = Moved(
          carriages_,
          {drawing_.axis(0).min_mm, drawing_.axis(1).min_mm, drawing_.axis(2).max_mm});
    }
    readings.push_back(stop.kind == Kind::kTouch ? Touch(stop, times_s[i])
                                                 : Gauge(stop, times_s[i]));
  }
  return readings;
}

std::vector<double> TimesOf_s(const Plan& plan) {
  std::vector<double> times_s;
  double t_s = 0;
  for (std::size_t i = 0; i < plan.stops.size(); ++i) {
    const Stop& stop = plan.stops[i];
    if (i > 0) {
      if (stop.campaign != plan.stops[i - 1].campaign) {
        t_s += 300;
      } else if (stop.setup != plan.stops[i - 1].setup && stop.pause_s == 0 &&
                 stop.campaign.rfind("drift", 0) != 0) {
        t_s += 180;
      }
    }
    if (stop.rehome) t_s += 30;
    const double reading_s = stop.kind == Kind::kTouch    ? 12
                             : stop.kind == Kind::kRadial ? 0.4
                                                          : 5;
    t_s += stop.pause_s + reading_s;
    times_s.push_back(t_s);
  }
  return times_s;
}

}  // namespace blind
