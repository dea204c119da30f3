#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "calibration/estimate/linear_design.h"
#include "scenarios/result.h"
#include "scenarios/scenario.h"
#include "sim/measure/plan.h"

namespace caltwin {

/// A study of a measuring plan: its rows, taken on many machines, and the joint
/// estimate of what was varied. One design: the same rows in the same order for all.
class PlanStudy {
 public:
  /// `varied` has the plan's machine and what the study varies; numbers that are no
  /// distributions are known to the estimate. Throws InputError for a delta and where
  /// nothing is varied.
  PlanStudy(const std::filesystem::path& plan_file,
            Scenario varied,
            std::uint64_t seed);

  std::size_t num_rows() const { return session_.rows.size(); }
  double duration_s() const { return session_.duration_s; }

  /// One machine: its rows by the closed forms with noise, whole steps and resolution,
  /// then FitJoint.
  RunResult Fast(std::int64_t trial) const;

  /// What all rows tell, by derivatives and noise alone: what is blind, in words.
  ObservabilityReport Observe() const;
  /// The joint problem at the median machine, noise-free.
  const JointProblem& problem() const { return problem_; }
  const Row& row(std::size_t i) const { return session_.rows.at(i); }

  /// Straight about the median machine.
  const LinearDesign& design() const { return design_; }
  /// How far the unknowns of machine `trial` are from the middle of their priors: the
  /// same machine as Fast's. Writes design().unknowns.size() numbers.
  void DrawAboutMiddle(std::int64_t trial, double* about_middle) const;
  /// The errors of estimates of machine `trial`; both as many as there are unknowns.
  void LinearErrors(std::int64_t trial, double* about_middle, double* errors) const;
  /// The same with names, stated uncertainty and the injected values.
  RunResult Linear(std::int64_t trial) const;
  /// What chance and counting added to each reading that Fast takes of machine `trial`,
  /// in its standard deviations.
  Eigen::VectorXd NoiseOf(std::int64_t trial) const;

 private:
  JointProblem ProblemOf(const RowTable& table,
                         const std::vector<Injected>& known) const;
  RunResult ResultOf(std::int64_t trial, const char* fidelity) const;
  // Machine `trial` with its readings as Fast takes them, with chance or without.
  JointProblem Measured(std::int64_t trial, bool is_noisy) const;
  void MakeDesign();

  // What is drawn of one unknown, as DrawEffects does.
  struct Drawn {
    std::string stream{};
    Distribution value = 0.0;
    double min = 0, max = 0;
  };

  Scenario varied_;
  std::uint64_t seed_;
  PlannedSession session_{};
  std::vector<FreeParameter> free_{};
  std::vector<Drawn> drawn_{};
  JointProblem problem_{};
  LinearDesign design_{};
  std::vector<double> gain_{};  ///< Reading by reading, its unknowns together.
};

}  // namespace caltwin
