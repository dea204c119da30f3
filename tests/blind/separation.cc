#include "tests/blind/separation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace blind {
namespace {

constexpr int kVariants = 10;
// A rival that the baseline absorbs but for this share would have to be absurdly large.
constexpr double kHidden = 1e-3;
constexpr double kListed = 25;

double Product(const Column& a, const Column& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Squares of `effect` left after one column of free amplitude, or two.
double Left(const Column& effect, const std::vector<const Column*>& imitation) {
  std::vector<Column> columns;
  for (const Column* column : imitation) columns.push_back(*column);
  const Column rest = Projector(columns).Rest(effect);
  return Product(rest, rest);
}

/// What imitations are measured against.
struct Ground {
  const Case& made;
  const Circumstances& at;
  const std::vector<Reading>& readings;
  const Projector& baseline;
};

/// The best that one rival can do: a single variant, or two of another phase together.
double BestImitation(const Ground& ground,
                     const Cause& rival,
                     const std::string& axis,
                     const Column& rest) {
  std::vector<Column> variants;
  bool has_phase = false;
  for (int i = 0; i < kVariants; ++i) {
    const Defect defect = rival.make(axis, ground.at);
    has_phase = std::ranges::any_of(defect.parameters, [](const auto& parameter) {
      return parameter.name == "phase_deg";
    });
    const Column whole = LinearEffect(ground.made, defect, ground.readings);
    Column column = ground.baseline.Rest(whole);
    if (Product(column, column) <= kHidden * Product(whole, whole)) continue;
    variants.push_back(std::move(column));
  }
  double best = Product(rest, rest);
  for (std::size_t i = 0; i < variants.size(); ++i) {
    std::vector<const Column*> imitation = {&variants[i]};
    if (has_phase) imitation.push_back(&variants[(i + 1) % variants.size()]);
    best = std::min(best, Left(rest, imitation));
  }
  return best;
}

}  // namespace

Column LinearEffect(const Case& made,
                    const Defect& defect,
                    const std::vector<Reading>& readings) {
  Column column;
  column.reserve(readings.size());
  for (const Reading& reading : readings) {
    const Instant& at = reading.instant;
    Vector3 motion = defect.motion ? defect.motion(at) : Vector3{};
    for (std::size_t i = 0; i < 3 && defect.gap; ++i) {
      motion[i] -= 0.5 * at.dir[i] * defect.gap(static_cast<int>(i), at.q_mm[i]);
    }
    double effect = Dot(motion, at.n);
    if (at.kind == Kind::kTouch) {
      effect = -effect + defect.tip_radius_mm;
      if (defect.pretravel) effect -= defect.pretravel(at);
      if (defect.surface) effect += defect.surface(at);
    }
    column.push_back(effect / Sigma_mm(made, reading));
  }
  return column;
}

std::map<std::string, double> Separation(const Case& made,
                                         const Circumstances& at,
                                         const Hidden& hidden,
                                         const Column& effect,
                                         const std::vector<Reading>& readings,
                                         const Projector& baseline) {
  std::map<std::string, double> separation;
  if (FindCause(hidden.cause)->fixed_size > 0) return separation;  // Told by its size.
  const Ground ground{made, at, readings, baseline};
  const Column rest = baseline.Rest(effect);
  const double whole = Product(rest, rest);
  for (const Cause& rival : LibraryCauses()) {
    if (rival.name == "pitch_map" || rival.name == "homing_scatter") continue;
    for (const std::string& axis : rival.axes) {
      if (rival.name == hidden.cause && axis == hidden.axis) continue;
      const bool is_belt = made.drawing.axis(AxisIndex(axis)).is_belt;
      if (rival.name == "cyclic_lead" && is_belt) continue;
      if (rival.name == "pulley_eccentric" && !is_belt) continue;
      const double left = BestImitation(ground, rival, axis, rest);
      if (left < std::max(0.1 * whole, kListed))
        separation[rival.name + " " + axis] = left;
    }
  }
  return separation;
}

}  // namespace blind
