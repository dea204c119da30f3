#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/joint.h"

namespace caltwin {

/// The joint estimate of one plan, straight about its priors' middle: what FitJoint
/// does with any readings as long as errors are small, as two matrices.
///
///   estimate - truth = bias (truth - middle) + gain noise
///
/// noise: by reading, in its standard deviations. Nuisances are estimated along and
/// left out here. Neglects all that is not straight in the unknowns; a study measures
/// how much that is.
struct LinearDesign {
  struct Unknown {
    std::string name{}, unit{};
    double middle = 0;          ///< Mean of its prior.
    double sd = 0;              ///< Of the estimate, beliefs included.
    double readings_sd = 0;     ///< Of the readings alone.
    bool identifiable = false;  ///< As JointEstimate's.
  };
  std::vector<Unknown> unknowns{};  ///< The problem's free parameters, in order.
  Eigen::MatrixXd gain{};           ///< A row an unknown, a column a reading.
  Eigen::MatrixXd bias{};
};

/// `problem` with readings as the middle of the priors would give them. Every free
/// parameter has a prior.
LinearDesign DesignOf(const JointProblem& problem);

/// What makes a reading the best one.
enum class Optimal {
  kD,  ///< The volume of what is not known: det of the covariance.
  kA   ///< The mean of (sd / prior sd)^2 over the unknowns.
};

/// A reading, and what is known with it.
struct NextReading {
  std::size_t reading = 0;  ///< Of the problem's, taken once more.
  /// Root of the mean over the free parameters of (sd / prior sd)^2.
  double relative_sd = 1;
};

/// The best one to take again after all of them.
NextReading BestAfterAll(const JointProblem& problem, Optimal optimal);
/// Root of the mean of (sd / prior sd)^2 after all readings.
double RelativeSdOfAll(const JointProblem& problem);

/// Readings that do the work of all: of every free parameter that all readings tell
/// (LinearDesign::Unknown::identifiable) the sd stays within `most` times what all of
/// them leave. Of the readings without which that holds the one is left out that is
/// missed least (least sum of variances over those of all), and again. What the
/// readings do not tell has no say: its sd is its belief's whatever is left out.
struct EnoughReadings {
  std::vector<std::size_t> readings{};  ///< Ascending.
  double largest_ratio = 1;  ///< Over the parameters told, of sd to that of all.
  std::string worst{};       ///< Which parameter has it.
  int num_told = 0;          ///< How many parameters count.
};
EnoughReadings EnoughOf(const JointProblem& problem, double most);

}  // namespace caltwin
