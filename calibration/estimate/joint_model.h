#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/joint.h"

namespace caltwin {

/// The joint problem as a vector of unknowns u of order 1: free parameters, then
/// nuisances in alphabetical order; value = start + scale * u.
class JointModel {
 public:
  explicit JointModel(const JointProblem& problem);

  /// One unknown.
  struct Unknown {
    std::string name{};
    std::string unit{};
    double start = 0;
    double scale = 1;
    Given prior{};     ///< Belief; sd infinite: none.
    Given measured{};  ///< Reading of another instrument; sd infinite: none.
    double min = 0;    ///< Hard bound, where going beyond has no meaning; else -inf.
    bool is_nuisance = false;
  };

  std::span<const Unknown> unknowns() const { return unknowns_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(unknowns_.size()); }
  std::size_t num_observations() const { return observations_.size(); }
  double sigma_mm(std::size_t i) const { return observations_[i].sigma_mm; }

  /// (reading - prediction) / sigma of one observation; `gradient` (null: not wanted)
  /// receives its derivatives by u.
  double Residual(std::size_t observation, const double* u, double* gradient) const;

  /// All of them. `gradient`: a row each.
  Eigen::VectorXd Residuals(const Eigen::VectorXd& u, Eigen::MatrixXd* gradient) const;

  /// Values in their own units.
  Eigen::VectorXd Values(const Eigen::VectorXd& u) const;

 private:
  // Where a free parameter stands in the list of effects.
  struct Slot {
    std::size_t effect = 0;
    std::size_t parameter = 0;
  };
  struct Term {
    Eigen::Index unknown = 0;
    double coefficient = 0;
  };

  void AddParameter(const JointProblem& problem, const FreeParameter& parameter);
  void AddNuisances(const JointProblem& problem);

  template <typename T>
  std::vector<Valued<T>> Effects() const;

  Machine machine_{};
  std::vector<Injected> effects_{};  // Fixed and free, free ones at their start.
  std::vector<Slot> slots_{};        // Of the free parameters, in order.
  std::vector<Unknown> unknowns_{};
  std::vector<Observation> observations_{};
  std::vector<std::vector<Term>> terms_{};  // Nuisances by observation.
};

}  // namespace caltwin
