#pragma once

#include <vector>

#include "renders/report.h"
#include "renders/scene.h"
#include "scenarios/result.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// How far the tip ends up from where it was asked for, at one pose.
struct PoseError {
  Vec3<double> at_mm = Vec3<double>::Zero();
  Vec3<double> error_mm = Vec3<double>::Zero();  ///< Actual minus commanded.
  bool is_forward = true;  ///< Reached in the sense + + +, or - - -.
};

/// Position errors of a machine with these settings over a grid on the table, in both
/// senses, the mean offset removed as in RunResult; the closed forms' answer.
std::vector<PoseError> GridErrors(const TwinConfig& config, const Settings& settings);

/// What enlarges the largest of these errors to about 40 mm: 1, 2 or 5 times a power of
/// ten; 1 where all are zero.
double Magnification(const std::vector<PoseError>& errors);

/// An arrow from where the tip was asked for towards where it is, `magnification` times
/// as long; orange forward, blue backward.
std::vector<Arrow> ArrowsOf(const std::vector<PoseError>& errors, double magnification);

/// The pictures of a run's report, made from its scenario's text: the machine with its
/// errors enlarged, the errors of position before and after to the same scale, what is
/// left magnified until it shows, and the run played back where its transcript was held
/// (RunOptions). Throws InputError where the text is no scenario.
ReportPictures PicturesOf(const RunResult& result);

}  // namespace caltwin
