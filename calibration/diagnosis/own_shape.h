#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// What the plain shape of a name, without freedom of form, does beside the rest in the
/// rows that show it; sums of squares in sigma.
struct PlainFit {
  double explained = 0;  ///< That the residual falls by.
  double left = 0;       ///< Beyond noise, with it.
  double doubt = 0;      ///< Standard deviation that noise alone gives `left`.
};

/// `beside`: the baseline and all other findings. Rows where baseline and others would
/// hide the shape say nothing of it, whatever else is wrong there; what a wander of the
/// machine takes up is noise.
PlainFit FitPlain(const Observed& observed,
                  const Circumstances& beside,
                  double wander_mm2_per_s,
                  const Eigen::MatrixXd& columns_mm,
                  const Eigen::VectorXd& sizes_mm);

/// How truly a cause must have the shape that its formula says.
enum class Form {
  kLike,   ///< Real causes are like it: about half of its height may be left.
  kClose,  ///< Plates bend nearly so: a fifth.
  kExact,  ///< Geometry: a fifth, for what else is wrong; never seen by its size alone.
};
Form FormOf(const Candidate& candidate, const Machine& machine);

/// A lack of fit that a name has no right to leave: beyond a standard deviation of
/// noise, three tenths of what it explains, about half of its height; of what is close
/// or exact 0.04, a fifth of its height. Where next to nothing is explained, a cause
/// may be known by its size, not by its shape; geometry is not.
bool LeavesTooMuch(const PlainFit& fit, Form form = Form::kLike);

/// Whether the rows prove a shape of which the rest takes up nearly all: what it leaves
/// is less than 0.04 of what it explains, a fifth of its height, even where noise hides
/// a standard deviation of it. `shown_of_freedom`: how much of it shows, in parts of
/// what shows of all that its form may differ by; below 1 what is left has to be less
/// by the square of that, for so much may be the form's.
bool IsProven(const PlainFit& fit, double shown_of_freedom);

/// How much of a shape shows beside the rest: the root of its squares, in sigma, over
/// those of all of it. 1: all; 0: the rest takes it up whole.
double ShownPart(const Observed& observed,
                 const Circumstances& beside,
                 const Eigen::VectorXd& change_mm);

/// Whether a shape is borrowed from a cause far larger than any: more than ten times
/// its usual size, of which less than a twentieth shows. So a wave of 0.8 mm, of which
/// plates touched within 0.1 mm of one height show but the curve, is a bowl. False for
/// free forms and for what does not vary along an axis.
bool IsBorrowed(const Observed& observed,
                const Circumstances& beside,
                const Candidate& candidate,
                const Weighed& weighed);

/// By how many nats a gradual change of the same rows, a ramp over several of them or a
/// creep that slows down, is likelier than a jump. The rows next to a jump tell both
/// apart. Minus infinity for causes that do not jump.
double GradualOdds(const Observed& observed,
                   const Circumstances& beside,
                   const Candidate& candidate);

/// Whether the rows next to a jump are full of outliers: then the readings were
/// disturbed there, and no level can be told from them. False for causes that do not
/// jump.
bool IsAmongOutliers(const Observed& observed,
                     const std::vector<bool>& is_outlier,
                     const Candidate& candidate,
                     const Variant& variant);

/// Whether all rows along a jump's axis before it lie on one side, in place, of all
/// rows after it: a step in the axis' own scale would read alike. False for causes that
/// do not jump.
bool IsPlaceAsWell(const Observed& observed,
                   const Candidate& candidate,
                   const Variant& variant);

}  // namespace caltwin
