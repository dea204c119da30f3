#include "sim/physics/coupled_joints.h"

#include <cmath>
#include <set>

namespace caltwin {
namespace {

constexpr int kNumCoefficients = 5;
constexpr int kMostNewtonSteps = 30;

struct Polynomial {
  double value = 0;
  double slope = 0;
};

Polynomial Evaluate(const mjtNum* coefficients, double d) {
  Polynomial result;
  for (int i = kNumCoefficients - 1; i >= 0; --i) {
    result.slope = result.slope * d + result.value;
    result.value = result.value * d + coefficients[i];
  }
  return result;
}

// Where the polynomial has that value, sought from `start`; `start` where it is flat.
double Solve(const mjtNum* coefficients, double value, double start) {
  double d = start;
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const Polynomial at = Evaluate(coefficients, d);
    if (at.slope == 0) return start;
    const double step = (at.value - value) / at.slope;
    d -= step;
    if (std::abs(step) <= 1e-15 * (1 + std::abs(d))) break;
  }
  return d;
}

}  // namespace

CoupledJoints::CoupledJoints(const mjModel* model, std::span<const int> placed) {
  std::set<int> settled(placed.begin(), placed.end());
  std::vector<bool> is_used(static_cast<std::size_t>(model->neq), false);
  for (std::size_t before = ~std::size_t{0}; ties_.size() != before;) {
    before = ties_.size();
    for (int equality = 0; equality < model->neq; ++equality) {
      const auto k = static_cast<std::size_t>(equality);
      if (is_used[k] || model->eq_type[equality] != mjEQ_JOINT) continue;
      const int first = model->eq_obj1id[equality];
      const int second = model->eq_obj2id[equality];
      const bool has_leader = second < 0 || settled.contains(second);
      if (has_leader && !settled.contains(first)) {
        ties_.push_back({.equality = equality, .follower = first, .leader = second});
      } else if (second >= 0 && !settled.contains(second) && settled.contains(first)) {
        ties_.push_back({.equality = equality,
                         .follower = second,
                         .leader = first,
                         .is_inverse = true});
      } else {
        continue;
      }
      settled.insert(ties_.back().follower);
      is_used[k] = true;
    }
  }
}

void CoupledJoints::Follow(const mjModel* model, mjData* data) const {
  for (const Tie& tie : ties_) {
    if (data->eq_active[tie.equality] == 0) continue;
    const mjtNum* coefficients = model->eq_data + mjNEQDATA * tie.equality;
    const int to = model->jnt_qposadr[tie.follower];
    const auto speed = [&](int joint) -> mjtNum& {
      return data->qvel[model->jnt_dofadr[joint]];
    };
    double led = 0;
    double led_speed = 0;
    if (tie.leader >= 0) {
      const int from = model->jnt_qposadr[tie.leader];
      led = data->qpos[from] - model->qpos0[from];
      led_speed = speed(tie.leader);
    }
    if (tie.is_inverse) {
      const double d = Solve(coefficients, led, data->qpos[to] - model->qpos0[to]);
      const double slope = Evaluate(coefficients, d).slope;
      data->qpos[to] = model->qpos0[to] + d;
      speed(tie.follower) = slope == 0 ? 0 : led_speed / slope;
    } else {
      const Polynomial at = Evaluate(coefficients, led);
      data->qpos[to] = model->qpos0[to] + at.value;
      speed(tie.follower) = at.slope * led_speed;
    }
  }
}

}  // namespace caltwin
