#include "calibration/loop/contact_ahead.h"

#include <algorithm>
#include <cmath>

#include "calibration/loop/face.h"

namespace caltwin {
namespace {

constexpr double kFurther_mm = 50;

// Whether the tip meets the face there, and not the air beside it.
bool IsBeside(const Artefact& artefact,
              const Face& face,
              const Vec3<double>& tip_mm,
              double tip_radius_mm) {
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    if (std::abs(face.n[i]) > 0.5) continue;
    const bool is_up = axis == Axis::kZ;
    const double low_mm =
        is_up ? artefact.at_mm[2] : artefact.at_mm[i] - artefact.size_mm[i] / 2;
    const double high_mm =
        is_up ? Top_mm(artefact) : artefact.at_mm[i] + artefact.size_mm[i] / 2;
    if (tip_mm[i] < low_mm - tip_radius_mm || tip_mm[i] > high_mm + tip_radius_mm) {
      return true;
    }
  }
  return false;
}

std::optional<double> After_mm(const Face& face,
                               const ProbeMove& move,
                               const Vec3<double>& along,
                               double tip_radius_mm) {
  const double closing = -along.dot(face.n);
  if (closing < 0.5) return std::nullopt;
  const double after_mm =
      ((move.from_mm - face.at_mm).dot(face.n) - tip_radius_mm) / closing;
  if (after_mm < 0) return std::nullopt;
  return after_mm;
}

}  // namespace

std::optional<ContactAhead> FindContactAhead(const std::vector<Artefact>& artefacts,
                                             const ProbeMove& move,
                                             double tip_radius_mm) {
  const Vec3<double> way_mm = move.target_mm - move.from_mm;
  const double length_mm = way_mm.norm();
  if (length_mm == 0) return std::nullopt;
  const Vec3<double> along = way_mm / length_mm;
  std::optional<ContactAhead> first;
  const auto keep = [&](const std::string& feature, double after_mm) {
    const bool is_near = after_mm <= length_mm + kFurther_mm;
    if (!is_near || (first && first->after_mm <= after_mm)) return;
    first = {
        .feature = feature, .after_mm = after_mm, .beyond_mm = length_mm - after_mm};
  };
  for (const Artefact& artefact : artefacts) {
    for (const Face& face : FacesOf(artefact)) {
      const auto after_mm = After_mm(face, move, along, tip_radius_mm);
      if (!after_mm || face.from_below) continue;
      const Vec3<double> tip_mm = move.from_mm + *after_mm * along;
      if (!IsBeside(artefact, face, tip_mm, tip_radius_mm))
        keep(face.feature, *after_mm);
    }
  }
  const Face table = TableAt(0, 0);
  if (const auto after_mm = After_mm(table, move, along, tip_radius_mm)) {
    keep(table.feature, *after_mm);
  }
  return first;
}

}  // namespace caltwin
