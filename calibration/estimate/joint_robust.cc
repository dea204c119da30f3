#include "calibration/estimate/joint_robust.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace caltwin {
namespace {

// Numbers of the groups of observations, in the order in which they first occur.
std::vector<int> GroupsOf(const JointProblem& problem) {
  std::map<std::string, int> numbers;
  std::vector<int> groups;
  for (const Observation& observation : problem.observations) {
    const int next = static_cast<int>(numbers.size());
    groups.push_back(numbers.try_emplace(observation.group, next).first->second);
  }
  return groups;
}

// From the unknowns' own scale to their units, both ways.
Eigen::MatrixXd InUnits(const JointModel& model, const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd scales(model.size());
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    scales[i] = model.unknowns()[static_cast<std::size_t>(i)].scale;
  }
  return scales.asDiagonal() * covariance * scales.asDiagonal();
}

}  // namespace

void AddRobust(const JointModel& model,
               const JointProblem& problem,
               const Sandwich& sandwich,
               JointFit* fit) {
  const std::vector<int> groups = GroupsOf(problem);
  fit->hc3_covariance = InUnits(model, SandwichHc3(sandwich));
  fit->group_covariance = InUnits(model, SandwichByGroup(sandwich, groups));
  fit->num_groups = groups.empty() ? 0 : 1 + *std::ranges::max_element(groups);
}

}  // namespace caltwin
