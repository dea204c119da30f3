#include "calibration/loop/face.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kLedgeUnderside_mm = 30;  // Above its base, see Artefact.
constexpr double kDeepestTouch_mm = 12.7;  // Half of the flattest block.
constexpr double kLedgeOverlap_mm = 3;     // Of the stylus' axis beside the lip.
constexpr double kAlignedWithin = 1e-9;

bool IsHole(const Artefact& artefact) {
  return artefact.type == ArtefactType::kRing || artefact.type == ArtefactType::kPocket;
}

Vec3<double> Extent_mm(const Artefact& artefact) {
  if (artefact.type != ArtefactType::kRing) return artefact.size_mm;
  return {artefact.size_mm[0], artefact.size_mm[0], artefact.size_mm[2]};
}

Vec3<double> Turned(const Vec3<double>& v, double turn_deg) {
  const double turn_rad = RadFromDeg(turn_deg);
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  return {c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
}

// Along the local axes, `sense` +1: the side that lies at the larger coordinate.
Face Side(const Artefact& artefact, Axis axis, int sense, const std::string& name) {
  const Vec3<double> extent_mm = Extent_mm(artefact);
  const double half_mm = extent_mm[Index(axis)] / 2;
  const double top_mm = extent_mm[2];
  Vec3<double> local_mm = Unit(axis) * (sense * half_mm);
  local_mm[2] = top_mm - std::min(top_mm / 2, kDeepestTouch_mm);
  const bool hole = IsHole(artefact);
  const Vec3<double> n = Unit(axis) * (hole ? -sense : sense);
  return {.artefact = artefact.id,
          .feature = artefact.id + "." + name,
          .at_mm = artefact.at_mm + Turned(local_mm, artefact.turn_deg),
          .n = Turned(n, artefact.turn_deg),
          .internal = hole,
          .room_mm = hole ? half_mm : 0};
}

Face Bottom(const Artefact& ledge) {
  // The lip stands on a pillar at its -y end, so the disc comes in at the other.
  const Vec3<double> beside_mm(0, ledge.size_mm[1] / 2 + kLedgeOverlap_mm, 0);
  return {.artefact = ledge.id,
          .feature = ledge.id + ".bottom",
          .at_mm = ledge.at_mm + Turned(beside_mm, ledge.turn_deg) +
                   Vec3<double>(0, 0, kLedgeUnderside_mm),
          .n = -Vec3<double>::UnitZ(),
          .from_below = true};
}

}  // namespace

int Face::ApproachSense(Axis axis) const {
  const double along = -n[Index(axis)];
  if (std::abs(along) < kAlignedWithin) return 0;
  return along > 0 ? 1 : -1;
}

double Top_mm(const Artefact& artefact) {
  const double base_mm = artefact.at_mm[2];
  if (artefact.type == ArtefactType::kLedge) {
    return base_mm + kLedgeUnderside_mm + artefact.size_mm[2];
  }
  return base_mm + artefact.size_mm[2];
}

std::optional<Face> TopOf(const Artefact& artefact) {
  if (IsHole(artefact)) return std::nullopt;
  Vec3<double> at_mm = artefact.at_mm;
  at_mm[2] = Top_mm(artefact);
  return Face{.artefact = artefact.id,
              .feature = artefact.id + ".top",
              .at_mm = at_mm,
              .n = Vec3<double>::UnitZ()};
}

Face TableAt(double x_mm, double y_mm) {
  return {.artefact = "bed",
          .feature = "bed.top",
          .at_mm = {x_mm, y_mm, 0},
          .n = Vec3<double>::UnitZ()};
}

std::vector<Face> FacesOf(const Artefact& artefact) {
  std::vector<Face> faces;
  if (artefact.type == ArtefactType::kLedge) {
    faces.push_back(Bottom(artefact));
  } else if (artefact.type != ArtefactType::kPlate) {
    faces = {Side(artefact, Axis::kX, -1, "left"),
             Side(artefact, Axis::kX, +1, "right"),
             Side(artefact, Axis::kY, -1, "front"),
             Side(artefact, Axis::kY, +1, "back")};
  }
  if (const auto top = TopOf(artefact)) faces.push_back(*top);
  return faces;
}

std::vector<Face> FacesAcross(const Artefact& artefact, Axis axis) {
  std::vector<Face> across;
  for (const Face& face : FacesOf(artefact)) {
    const bool aligned = std::abs(face.n[Index(axis)]) > 1 - kAlignedWithin;
    if (aligned) across.push_back(face);
  }
  std::sort(across.begin(), across.end(), [axis](const Face& a, const Face& b) {
    return a.at_mm[Index(axis)] < b.at_mm[Index(axis)];
  });
  if (across.size() != 2) across.clear();
  return across;
}

}  // namespace caltwin
