// The inner loop of linear studies, compiled for speed (CMakeLists.txt).

#include <array>
#include <vector>

#include "scenarios/study/plan_study.h"
#include "sim/base/normals.h"

namespace caltwin {

void PlanStudy::LinearErrors(std::int64_t trial,
                             double* about_middle,
                             double* errors) const {
  DrawAboutMiddle(trial, about_middle);
  const std::size_t count = drawn_.size();
  for (std::size_t i = 0; i < count; ++i) {
    errors[i] = 0;
    for (std::size_t j = 0; j < count; ++j) {
      errors[i] +=
          design_.bias(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) *
          about_middle[j];
    }
  }
  Rng rng(seed_, static_cast<std::uint64_t>(trial), "linear.readings");
  const double* gain = gain_.data();
  for (std::size_t row = 0; row < num_rows(); ++row, gain += count) {
    const double noise = QuickNormal(&rng);
    for (std::size_t i = 0; i < count; ++i) errors[i] += gain[i] * noise;
  }
}

}  // namespace caltwin
