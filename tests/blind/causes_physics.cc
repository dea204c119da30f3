// Causes that a model.xml can have when it is edited as text. Each has its closed form
// too, by which its size is chosen; the data come from MuJoCo.

#include <cmath>
#include <numbers>

#include "tests/blind/causes.h"
#include "tests/blind/model_text.h"

namespace blind {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::string NutOf(const std::string& axis) {
  return axis + "_nut";
}

Polynomial Times(double factor, Polynomial polynomial) {
  for (double& coefficient : polynomial) coefficient *= factor;
  return polynomial;
}

/// Cranks on the carriage, and a second pair at twice the rate. Size 1: 1 um.
Defect Cranks(const std::string& cause,
              const std::string& axis,
              double period_mm,
              const Circumstances& at) {
  const int a = AxisIndex(axis);
  const bool is_motor = cause == "microstep";
  const double off = is_motor ? 0 : at.random->Uniform(-0.0015, 0.0015);
  const double true_mm = period_mm * (1 + off);
  const double phase_rad = at.random->Uniform(0, kTurn);
  const double second = is_motor ? 0 : at.random->Uniform(0.05, 0.2);
  const double second_rad = at.random->Uniform(0, kTurn);
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{"amplitude_um", 1},
                       {"phase_deg", phase_rad * 360 / kTurn, false},
                       {"period_mm", true_mm, false}};
  if (is_motor) defect.parameters.pop_back();
  defect.motion = [=](const Instant& now) {
    const double turn_rad = kTurn * now.q_mm[static_cast<std::size_t>(a)] / true_mm;
    return Along(a,
                 kMmPerUm * (std::sin(turn_rad + phase_rad) +
                             second * std::sin(2 * turn_rad + second_rad)));
  };
  defect.build = [=](double size, ModelText* model) {
    model->AddCranks(a, size * kMmPerUm, true_mm, phase_rad);
    if (second == 0) return;
    model->AddCranks(a, second * size * kMmPerUm, true_mm / 2, second_rad);
  };
  return defect;
}

Defect CyclicLead(const std::string& axis, const Circumstances& at) {
  return Cranks("cyclic_lead", axis, at.drawing.axis(AxisIndex(axis)).lead_mm, at);
}
Defect PulleyEccentric(const std::string& axis, const Circumstances& at) {
  return Cranks("pulley_eccentric", axis, at.drawing.axis(AxisIndex(axis)).lead_mm, at);
}
Defect Microstep(const std::string& axis, const Circumstances& at) {
  const AxisDrawing& drawing = at.drawing.axis(AxisIndex(axis));
  return Cranks(
      "microstep", axis, 4 * drawing.lead_mm / drawing.full_steps_per_rev, at);
}

/// A bow of U: its vertex off the middle, skew, flatter or steeper than a parabola.
Polynomial DrawBow(Random* random) {
  const double vertex = random->Uniform(-0.1, 0.1);
  const double skew = random->Uniform(-0.1, 0.1);
  const double steep = random->Uniform(-0.15, 0.15);
  return {vertex * vertex, -2 * vertex - skew, 1 - steep, skew, steep};
}

/// An error that follows an axis by a polynomial of U, along a direction.
struct Bend {
  int carriage = 0;
  std::string leader{};
  Vector3 along{};
  Polynomial over_u{};
};

/// Size 1: 1 um.
void Carry(const Bend& bend, const Circumstances& at, Defect* defect) {
  const AxisDrawing drawing = at.drawing.axis(bend.carriage);
  defect->motion = [=](const Instant& now) {
    const double q_mm = now.q_mm[static_cast<std::size_t>(bend.carriage)];
    return kMmPerUm * Value(bend.over_u, drawing.Scaled(q_mm)) * bend.along;
  };
  defect->build = [=](double size, ModelText* model) {
    model->AddSlide(bend.carriage,
                    bend.leader,
                    bend.along,
                    Times(size * kMmPerUm, OverTravel(bend.over_u, drawing)));
  };
}

Defect PitchProgressive(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  const double sign = at.random->Sign();
  Defect defect{.cause = "pitch_progressive", .axis = axis};
  defect.parameters = {{"bow_um", sign}};
  Carry({a, NutOf(axis), Along(a), Times(sign, DrawBow(at.random))}, at, &defect);
  return defect;
}

/// Cubic and quartic waves over the travel: no bow.
Defect PitchMap(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  const double cubic = at.random->Sign() * at.random->Uniform(0.5, 1);
  const double quartic = at.random->Sign() * at.random->Uniform(0.5, 1);
  Defect defect{.cause = "pitch_map", .axis = axis};
  Carry({a,
         NutOf(axis),
         Along(a),
         {quartic, -3 * cubic, -8 * quartic, 4 * cubic, 8 * quartic}},
        at,
        &defect);
  return defect;
}

Defect Straightness(const std::string& axis, const Circumstances& at) {
  const int moving = axis[2] - 'X';
  const double sign = at.random->Sign();
  Defect defect{.cause = "straightness", .axis = axis};
  defect.parameters = {{"bow_um", sign}};
  Carry({moving,
         std::string(1, "xyz"[moving]),
         Along(axis[1] - 'X'),
         Times(sign, DrawBow(at.random))},
        at,
        &defect);
  return defect;
}

Defect GantrySag(const std::string& axis, const Circumstances& at) {
  Defect defect{.cause = "gantry_sag", .axis = axis};
  defect.parameters = {{"sag_um", 1}};
  Carry({0, "x", Along(2), DrawBow(at.random)}, at, &defect);
  return defect;
}

/// A rotation that follows an axis: 1 urad over the whole travel, a little cubic.
Defect Turning(const std::string& cause,
               const std::string& axis,
               const char* parameter,
               double unit,
               const Circumstances& at) {
  const Vector3 about = Along(axis[1] - 'A');
  const int moving = axis[2] - 'X';
  const AxisDrawing drawing = at.drawing.axis(moving);
  const double sign = at.random->Sign();
  const double cubic = at.random->Uniform(-0.12, 0.12);
  const Polynomial over_u = {0, 0.5 * sign * (1 - cubic), 0, 0.5 * sign * cubic, 0};
  // The middle of what is carried further out: Y carries the beam, X the head.
  Vector3 pivot_mm{};
  if (moving == 1) pivot_mm[0] = at.drawing.axis(0).Mid_mm();
  if (moving != 2) pivot_mm[2] = at.drawing.axis(2).Mid_mm();
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{parameter, sign * unit}};
  defect.motion = [=](const Instant& now) {
    const double q_mm = now.q_mm[static_cast<std::size_t>(moving)];
    Vector3 lever_mm = now.offset_mm;
    if (moving == 1) lever_mm[0] += now.q_mm[0] - pivot_mm[0];
    if (moving != 2) lever_mm[2] += now.q_mm[2] - pivot_mm[2];
    return 1e-6 * Value(over_u, drawing.Scaled(q_mm)) * Cross(about, lever_mm);
  };
  defect.build = [=](double size, ModelText* model) {
    model->AddHinge(moving,
                    std::string(1, "xyz"[moving]),
                    about,
                    pivot_mm,
                    Times(1e-6 * size, OverTravel(over_u, drawing)));
  };
  return defect;
}

Defect Angular(const std::string& axis, const Circumstances& at) {
  return Turning("angular", axis, "slope_urad", 1, at);
}
Defect AxisTwist(const std::string& axis, const Circumstances& at) {
  return Turning("axis_twist", axis, "twist_mrad", 1e-3, at);
}

/// The rail itself leans. Size 1: 1 urad.
Defect Squareness(const std::string& axis, const Circumstances& at) {
  const int moving = axis[2] - 'X';
  const double sign = at.random->Sign();
  const Vector3 lean = sign * 1e-6 * Cross(Along(axis[0] - 'A'), Along(moving));
  Defect defect{.cause = "squareness", .axis = axis};
  defect.parameters = {{"angle_mrad", sign * 1e-3}};
  defect.motion = [=](const Instant& now) {
    return now.q_mm[static_cast<std::size_t>(moving)] * lean;
  };
  defect.build = [=](double size, ModelText* model) {
    model->LeanRail(moving, size * lean);
  };
  return defect;
}

/// (1 - s^2)^2 over almost the whole screw, its peak near the middle. Size 1: 1 um.
Defect BacklashWorn(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  const AxisDrawing& drawing = at.drawing.axis(a);
  const double centre = at.random->Uniform(-0.12, 0.12);  // Of U; s = (U - c) / w.
  const double w = at.random->Uniform(1.0, 1.1);
  const Polynomial over_s = {1, 0, -2, 0, 1};
  const AxisDrawing part{.min_mm = drawing.Mid_mm() + (centre - w) * drawing.Half_mm(),
                         .max_mm = drawing.Mid_mm() + (centre + w) * drawing.Half_mm()};
  const Polynomial wider = OverTravel(over_s, part);
  const double half_height = std::sqrt(1 - std::sqrt(0.5));
  Defect defect{.cause = "backlash_worn", .axis = axis};
  defect.parameters = {{"extra_mm", kMmPerUm},
                       {"center_mm", part.Mid_mm(), false},
                       {"width_mm", 2 * half_height * part.Half_mm(), false}};
  defect.gap = [=](int which, double q_mm) {
    return which == a ? kMmPerUm * Value(wider, q_mm) : 0.0;
  };
  defect.build = [=](double size, ModelText* model) {
    model->WidenGap(a, Times(size * kMmPerUm, wider));
  };
  return defect;
}

/// A spring between nut and carriage, 2 / compliance. Size 1: 0.01 um/N.
Defect WindupLoad(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  const double friction_n = at.drawing.axis(a).friction_n;
  Defect defect{.cause = "windup_load", .axis = axis};
  defect.parameters = {{"compliance_um_per_n", 0.01}};
  defect.motion = [=](const Instant& now) {
    const auto k = static_cast<std::size_t>(a);
    const double load_n = std::abs(now.n[k]) > 0.5 ? now.load_n : friction_n;
    return Along(a, -0.5 * now.dir[k] * kMmPerUm * 0.01 * load_n);
  };
  defect.build = [=](double size, ModelText* model) {
    model->SetSpring(a, 2 / (0.01 * size * kMmPerUm));
  };
  return defect;
}

/// The table itself is shaped, in tiles. Size 1: 1 um.
template <typename Shape>
Defect TableShape(const std::string& cause,
                  const std::string& axis,
                  const Circumstances& at,
                  Shape shape) {
  const Drawing drawing = at.drawing;
  const double sign = at.random->Sign();
  const auto height_mm = [=](double x_mm, double y_mm) {
    return sign * kMmPerUm *
           shape(drawing.axis(0).Scaled(x_mm), drawing.axis(1).Scaled(y_mm));
  };
  const Vector3 middle_mm = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{"height_um", sign}};
  defect.surface = [=](const Instant& now) {
    if (now.artefact != "plate") return 0.0;
    const Vector3 own =
        middle_mm + TurnedAboutZ(now.point_mm - middle_mm, -now.turn_rad);
    return height_mm(own[0], own[1]);
  };
  defect.build = [=](double size, ModelText* model) {
    model->ShapeTable(
        [=](double x_mm, double y_mm) { return size * height_mm(x_mm, y_mm); });
  };
  return defect;
}

Defect BedBowl(const std::string& axis, const Circumstances& at) {
  const double power = at.random->Uniform(1.8, 2.3);
  const double oval = at.random->Uniform(-0.1, 0.1);
  return TableShape("bed_bowl", axis, at, [=](double u, double v) {
    return 0.5 * ((1 + oval) * std::pow(std::abs(u), power) +
                  (1 - oval) * std::pow(std::abs(v), power));
  });
}

Defect BedCylinder(const std::string& axis, const Circumstances& at) {
  const Polynomial bow = DrawBow(at.random);
  const bool along_x = axis == "x";
  return TableShape("bed_cylinder", axis, at, [=](double u, double v) {
    return Value(bow, along_x ? u : v);
  });
}

Defect BedTwist(const std::string& axis, const Circumstances& at) {
  const double skew = at.random->Uniform(-0.12, 0.12);
  return TableShape("bed_twist", axis, at, [=](double u, double v) {
    return u * v * (1 + skew * u);
  });
}

/// A ball of another radius. Size 1: 1 mm.
Defect TipSize(const std::string& axis, const Circumstances& at) {
  const double error_mm = at.random->Chance(0.7) ? -0.5 * at.drawing.tip_radius_cfg_mm
                                                 : at.random->Uniform(0.35, 0.8);
  Defect defect{.cause = "tip_size", .axis = axis};
  defect.parameters = {{"radius_error_mm", error_mm}};
  defect.tip_radius_mm = error_mm;
  defect.build = [=](double size, ModelText* model) {
    model->GrowTip(size * error_mm);
  };
  return defect;
}

struct Form {
  const char* cause;
  Defect (*make)(const std::string& axis, const Circumstances& at);
};
constexpr Form kForms[] = {{"cyclic_lead", CyclicLead},
                           {"microstep", Microstep},
                           {"pulley_eccentric", PulleyEccentric},
                           {"pitch_progressive", PitchProgressive},
                           {"pitch_map", PitchMap},
                           {"backlash_worn", BacklashWorn},
                           {"windup_load", WindupLoad},
                           {"squareness", Squareness},
                           {"straightness", Straightness},
                           {"angular", Angular},
                           {"gantry_sag", GantrySag},
                           {"axis_twist", AxisTwist},
                           {"bed_bowl", BedBowl},
                           {"bed_cylinder", BedCylinder},
                           {"bed_twist", BedTwist},
                           {"tip_size", TipSize}};

}  // namespace

// The same campaigns, axes and sizes as of the closed forms.
const std::vector<Cause>& PhysicsCauses() {
  static const std::vector<Cause> causes = [] {
    std::vector<Cause> all;
    for (const Form& form : kForms) {
      Cause cause = *FindCause(form.cause);
      cause.make = form.make;
      all.push_back(cause);
    }
    return all;
  }();
  return causes;
}

}  // namespace blind
