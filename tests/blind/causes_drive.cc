// What goes wrong between motor and carriage. Shapes are near the textbook's, never on
// it: periods slightly off, harmonics, bumps that are no Gaussians.

#include <cmath>
#include <numbers>

#include "tests/blind/causes.h"

namespace blind {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::vector<CampaignRequest> Lines(const std::string& axis) {
  const int a = AxisIndex(axis);
  return {{.kind = "iso230", .axis = a}, {.kind = "dense", .axis = a}};
}

std::vector<CampaignRequest> LongLine(const std::string& axis) {
  return {{.kind = "iso230", .axis = AxisIndex(axis)}};
}

std::vector<CampaignRequest> LoadedLine(const std::string& axis) {
  const int a = AxisIndex(axis);
  return {{.kind = "iso230", .axis = a, .two_loads = true},
          {.kind = "alternating", .axis = a}};
}

std::vector<CampaignRequest> DenseAndCircle(const std::string& axis) {
  return {{.kind = "dense", .axis = AxisIndex(axis)}, {.kind = "ballbar"}};
}

/// +A sin(2 pi q / period + phase) on the axis, with harmonics and a slowly varying
/// amplitude; size 1: A = 1 um.
Defect Wave(const std::string& cause,
            const std::string& axis,
            double period_mm,
            const Circumstances& at) {
  Random& random = *at.random;
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const AxisDrawing drawing = at.drawing.axes[a];
  // A screw or pulley is a little off its drawing; the motor's full steps are counted
  // by the firmware itself and cannot be.
  const double off = random.Uniform(-0.0015, 0.0015);
  const double true_period_mm = period_mm * (1 + (cause == "microstep" ? 0 : off));
  const double phase_rad = random.Uniform(0, kTurn);
  const double second = random.Uniform(0.05, 0.2);
  const double second_rad = random.Uniform(0, kTurn);
  const double third = random.Uniform(0, 0.08);
  const double third_rad = random.Uniform(0, kTurn);
  const double swell = random.Uniform(-0.12, 0.12);
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{"amplitude_um", 1},
                       {"phase_deg", phase_rad * 360 / kTurn, false},
                       {"period_mm", true_period_mm, false}};
  if (cause == "microstep") defect.parameters.pop_back();
  defect.motion = [=](const Instant& now) {
    const double turn_rad = kTurn * now.q_mm[a] / true_period_mm;
    const double wave = std::sin(turn_rad + phase_rad) +
                        second * std::sin(2 * turn_rad + second_rad) +
                        third * std::sin(3 * turn_rad + third_rad);
    return kMmPerUm * (1 + swell * drawing.Scaled(now.q_mm[a])) * wave *
           Along(static_cast<int>(a));
  };
  return defect;
}

Defect CyclicLead(const std::string& axis, const Circumstances& at) {
  return Wave("cyclic_lead", axis, at.drawing.axis(AxisIndex(axis)).lead_mm, at);
}

Defect PulleyEccentric(const std::string& axis, const Circumstances& at) {
  return Wave("pulley_eccentric", axis, at.drawing.axis(AxisIndex(axis)).lead_mm, at);
}

Defect Microstep(const std::string& axis, const Circumstances& at) {
  const AxisDrawing& drawing = at.drawing.axis(AxisIndex(axis));
  return Wave("microstep", axis, 4 * drawing.lead_mm / drawing.full_steps_per_rev, at);
}

/// Both ends go to + against the middle by 1 um: |U|^p with p near 2, its vertex off
/// the middle, and a little skew.
Defect PitchProgressive(const std::string& axis, const Circumstances& at) {
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const AxisDrawing drawing = at.drawing.axes[a];
  const double power = at.random->Uniform(1.8, 2.4);
  const double vertex = at.random->Uniform(-0.1, 0.1);
  const double skew = at.random->Uniform(-0.1, 0.1);
  const double sign = at.random->Sign();
  Defect defect{.cause = "pitch_progressive", .axis = axis};
  defect.parameters = {{"bow_um", sign}};
  defect.motion = [=](const Instant& now) {
    const double u = drawing.Scaled(now.q_mm[a]);
    const double bow = std::pow(std::abs(u - vertex), power) + skew * u * (u * u - 1);
    return sign * kMmPerUm * bow * Along(static_cast<int>(a));
  };
  return defect;
}

/// An axis whose error has no formula: hills and a kink.
Defect PitchMap(const std::string& axis, const Circumstances& at) {
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const AxisDrawing drawing = at.drawing.axes[a];
  struct Hill {
    double waves, phase_rad, height;
  };
  std::vector<Hill> hills;
  for (int i = 0; i < 3; ++i) {
    hills.push_back({at.random->Uniform(1.2, 2.8),
                     at.random->Uniform(0, kTurn),
                     at.random->Uniform(0.4, 1.0)});
  }
  const double kink = at.random->Uniform(-0.5, 0.5);
  Defect defect{.cause = "pitch_map", .axis = axis};
  defect.motion = [=](const Instant& now) {
    const double u = drawing.Scaled(now.q_mm[a]);
    double height = 0.8 * std::abs(u - kink);
    for (const Hill& hill : hills) {
      height += hill.height * std::sin(0.5 * kTurn * hill.waves * u + hill.phase_rad);
    }
    return kMmPerUm * height * Along(static_cast<int>(a));
  };
  return defect;
}

/// The gap is wider by 1 um where the screw is worn: a plateau with soft shoulders,
/// steeper on one side.
Defect BacklashWorn(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  const AxisDrawing& drawing = at.drawing.axis(a);
  const double center_mm =
      drawing.min_mm + 2 * drawing.Half_mm() * at.random->Uniform(0.25, 0.75);
  const double width_mm = 2 * drawing.Half_mm() * at.random->Uniform(0.15, 0.4);
  const double lean = at.random->Uniform(-0.15, 0.15);
  const double power = at.random->Uniform(2.5, 5);
  Defect defect{.cause = "backlash_worn", .axis = axis};
  defect.parameters = {{"extra_mm", kMmPerUm},
                       {"center_mm", center_mm, false},
                       {"width_mm", width_mm, false}};
  defect.gap = [=](int which, double q_mm) {
    if (which != a) return 0.0;
    const double side = q_mm > center_mm ? 1 + lean : 1 - lean;
    const double u = std::abs(q_mm - center_mm) / (0.5 * width_mm * side);
    return kMmPerUm / (1 + std::pow(u, power));
  };
  return defect;
}

/// Half the lost motion, F / (2 k), behind the sense of motion; the drive stiffens a
/// little under load. Size 1: 0.01 um/N.
Defect WindupLoad(const std::string& axis, const Circumstances& at) {
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const double stiffening = at.random->Uniform(0, 0.001);
  const double friction_n = at.drawing.axes[a].friction_n;
  Defect defect{.cause = "windup_load", .axis = axis};
  defect.parameters = {{"compliance_um_per_n", 0.01}};
  defect.motion = [=](const Instant& now) {
    const double load_n = std::abs(now.n[a]) > 0.5 ? now.load_n : friction_n;
    const double lost_um = 0.01 * load_n * (1 - stiffening * load_n);
    return -0.5 * now.dir[a] * kMmPerUm * lost_um * Along(static_cast<int>(a));
  };
  return defect;
}

/// -s h exp(-d / lambda), d the travel since the reversal, with a faster part.
Defect ReversalSpike(const std::string& axis, const Circumstances& at) {
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const double decay_mm = at.random->LogUniform(0.8, 4);
  const double fast = at.random->Uniform(0, 0.2);
  Defect defect{.cause = "reversal_spike", .axis = axis};
  defect.parameters = {{"height_um", 1}, {"decay_mm", decay_mm, false}};
  defect.motion = [=](const Instant& now) {
    const double d = now.since_rev_mm[a] / decay_mm;
    const double height = (1 - fast) * std::exp(-d) + fast * std::exp(-3 * d);
    return -now.dir[a] * kMmPerUm * height * Along(static_cast<int>(a));
  };
  return defect;
}

}  // namespace

std::vector<Cause> DriveCauses() {
  const std::vector<std::string> xy = {"x", "y"};
  return {{"cyclic_lead", xy, Lines, CyclicLead, 5},
          {"microstep", xy, Lines, Microstep, 4},
          {"pulley_eccentric", xy, Lines, PulleyEccentric, 20},
          {"pitch_progressive", xy, LongLine, PitchProgressive, 20},
          {"pitch_map", xy, LongLine, PitchMap, 15},
          {"backlash_worn", xy, LongLine, BacklashWorn, 30},
          {"windup_load", xy, LoadedLine, WindupLoad, 30},
          {"reversal_spike", xy, DenseAndCircle, ReversalSpike, 8}};
}

}  // namespace blind
