// What bends or turns between the carriages and the tool, and the shape of the bed.

#include <cmath>

#include "tests/blind/causes.h"

namespace blind {
namespace {

/// Rotation vectors of ISO 230-1: A about x, B about y, C about z.
Vector3 About(char letter) {
  return Along(letter - 'A');
}
int Moving(char letter) {
  return letter - 'X';
}

Vector3 Middle(const Drawing& drawing) {
  return {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), drawing.axis(2).Mid_mm()};
}

std::vector<CampaignRequest> SquareAndMore(const std::string& axis) {
  if (axis == "C0Y") return {{.kind = "square"}, {.kind = "ballbar"}};
  const int across = axis == "B0Z" ? 0 : 1;
  return {{.kind = "square", .axis = across, .vertical = true}, {.kind = "plate"}};
}

/// C0Y turns Y about z: dx = -a (y - mid). B0Z turns Z about y: dx = +a (z - mid). A0Z
/// turns Z about x: dy = -a (z - mid). All are w x r. Size 1: 1 urad.
Defect Squareness(const std::string& axis, const Circumstances& at) {
  const Vector3 about = About(axis[0]);
  const auto moving = static_cast<std::size_t>(Moving(axis[2]));
  const double mid_mm = at.drawing.axes[moving].Mid_mm();
  const double sign = at.random->Sign();
  Defect defect{.cause = "squareness", .axis = axis};
  defect.parameters = {{"angle_mrad", sign * 1e-3}};
  defect.motion = [=](const Instant& now) {
    const double along_mm = now.q_mm[moving] - mid_mm;
    return sign * 1e-6 * Cross(about, Along(static_cast<int>(moving), along_mm));
  };
  return defect;
}

/// |U|^p, vertex off the middle, a little skew; 1 at the ends against the middle.
struct Bow {
  double power, vertex, skew;
  explicit Bow(Random* random)
      : power(random->Uniform(1.8, 2.4)),
        vertex(random->Uniform(-0.1, 0.1)),
        skew(random->Uniform(-0.1, 0.1)) {}
  double operator()(double u) const {
    return std::pow(std::abs(u - vertex), power) + skew * u * (u * u - 1);
  }
};

std::vector<CampaignRequest> EdgeAlong(const std::string& axis) {
  return {{.kind = "straightedge", .axis = Moving(axis[2])}, {.kind = "ballbar"}};
}

/// EYX: error in y as x moves; +: both ends go to + against the middle.
Defect Straightness(const std::string& axis, const Circumstances& at) {
  const int across = Moving(axis[1]);
  const auto moving = static_cast<std::size_t>(Moving(axis[2]));
  const AxisDrawing drawing = at.drawing.axes[moving];
  const Bow bow(at.random);
  const double sign = at.random->Sign();
  Defect defect{.cause = "straightness", .axis = axis};
  defect.parameters = {{"bow_um", sign}};
  defect.motion = [=](const Instant& now) {
    return sign * kMmPerUm * bow(drawing.Scaled(now.q_mm[moving])) * Along(across);
  };
  return defect;
}

std::vector<CampaignRequest> TwoHeights(const std::string& axis) {
  const int moving = Moving(axis[2]);
  return {{.kind = "abbe", .axis = moving, .lever = axis == "ECY" ? 0 : 2},
          {.kind = "iso230", .axis = 1 - moving}};
}

/// Rotation about a letter's axis as another moves, zero at mid-travel, changing by
/// 1 urad over the whole travel. Y carries the beam, X the head, Z the tool: the lever
/// is what lies between the turning part and the tip.
Defect Angular(const std::string& axis, const Circumstances& at) {
  const Vector3 about = About(axis[1]);
  const int moving = Moving(axis[2]);
  const AxisDrawing drawing = at.drawing.axis(moving);
  const Vector3 middle = Middle(at.drawing);
  const double sign = at.random->Sign();
  const double cubic = at.random->Uniform(-0.12, 0.12);
  Defect defect{.cause = "angular", .axis = axis};
  defect.parameters = {{"slope_urad", sign}};
  defect.motion = [=](const Instant& now) {
    const double u = drawing.Scaled(now.q_mm[static_cast<std::size_t>(moving)]);
    const double angle_rad = sign * 1e-6 * 0.5 * (u + cubic * u * (u * u - 1));
    Vector3 lever = now.offset_mm;
    if (moving == 1) lever[0] += now.q_mm[0] - middle[0];
    if (moving != 2) lever[2] += now.q_mm[2] - middle[2];
    return angle_rad * Cross(about, lever);
  };
  return defect;
}

std::vector<CampaignRequest> PlateAndTurned(const std::string&) {
  return {{.kind = "plate"}, {.kind = "plate_turned_90"}};
}

/// The beam's middle hangs lower by 1 um: dz = -(1 - bow).
Defect GantrySag(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(0);
  const Bow bow(at.random);
  Defect defect{.cause = "gantry_sag", .axis = axis};
  defect.parameters = {{"sag_um", 1}};
  defect.motion = [=](const Instant& now) {
    return kMmPerUm * (bow(drawing.Scaled(now.q_mm[0])) - 1) * Along(2);
  };
  return defect;
}

std::vector<CampaignRequest> PlateTwoOffsets(const std::string&) {
  return {{.kind = "plate", .two_offsets = true}, {.kind = "blocks"}};
}

/// The beam turns about its own axis by 1 urad over its length; the tip, standing off
/// the beam, goes up and down with it: dz = a off_y.
Defect AxisTwist(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(0);
  const double mid_z_mm = at.drawing.axis(2).Mid_mm();
  const double sign = at.random->Sign();
  const double cubic = at.random->Uniform(-0.12, 0.12);
  Defect defect{.cause = "axis_twist", .axis = axis};
  defect.parameters = {{"twist_mrad", sign * 1e-3}};
  defect.motion = [=](const Instant& now) {
    const double u = drawing.Scaled(now.q_mm[0]);
    const double angle_rad = sign * 1e-6 * 0.5 * (u + cubic * u * (u * u - 1));
    const Vector3 lever = now.offset_mm + Vector3{0, 0, now.q_mm[2] - mid_z_mm};
    return angle_rad * Cross(Along(0), lever);
  };
  return defect;
}

/// A plate that is not flat, in its own axes; height 1 um at the corners (cylinder: at
/// the edges) over the middle.
template <typename Shape>
Defect PlateShape(const std::string& cause,
                  const std::string& axis,
                  const Circumstances& at,
                  double sign,
                  Shape shape) {
  const Drawing drawing = at.drawing;
  const Vector3 middle = Middle(drawing);
  Defect defect{.cause = cause, .axis = axis};
  defect.parameters = {{"height_um", sign}};
  defect.surface = [=](const Instant& now) {
    if (now.artefact != "plate") return 0.0;
    const Vector3 own = TurnedAboutZ(now.point_mm - middle, -now.turn_rad);
    const double u = own[0] / drawing.axis(0).Half_mm();
    const double v = own[1] / drawing.axis(1).Half_mm();
    return sign * kMmPerUm * now.n[2] * shape(u, v);
  };
  return defect;
}

Defect BedBowl(const std::string& axis, const Circumstances& at) {
  const double power = at.random->Uniform(1.8, 2.3);
  const double oval = at.random->Uniform(-0.1, 0.1);
  return PlateShape("bed_bowl", axis, at, at.random->Sign(), [=](double u, double v) {
    return 0.5 * ((1 + oval) * std::pow(std::abs(u), power) +
                  (1 - oval) * std::pow(std::abs(v), power));
  });
}

Defect BedCylinder(const std::string& axis, const Circumstances& at) {
  const Bow bow(at.random);
  const bool along_x = axis == "x";
  return PlateShape(
      "bed_cylinder", axis, at, at.random->Sign(), [=](double u, double v) {
        return bow(along_x ? u : v);
      });
}

Defect BedTwist(const std::string& axis, const Circumstances& at) {
  const double skew = at.random->Uniform(-0.12, 0.12);
  return PlateShape("bed_twist", axis, at, at.random->Sign(), [=](double u, double v) {
    return u * v * (1 + skew * u);
  });
}

}  // namespace

std::vector<Cause> FrameCauses() {
  return {{"squareness", {"C0Y", "B0Z", "A0Z"}, SquareAndMore, Squareness, 50},
          {"straightness", {"EYX", "EXY"}, EdgeAlong, Straightness, 10},
          {"angular", {"EBX", "EAY", "ECY"}, TwoHeights, Angular, 50},
          {"gantry_sag", {"EZX"}, PlateAndTurned, GantrySag, 20},
          {"axis_twist", {"EAX"}, PlateTwoOffsets, AxisTwist, 200},
          {"bed_bowl", {""}, PlateAndTurned, BedBowl, 30},
          {"bed_cylinder", {"x", "y"}, PlateAndTurned, BedCylinder, 30},
          {"bed_twist", {""}, PlateAndTurned, BedTwist, 30}};
}

}  // namespace blind
