#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/free_form.h"
#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// A candidate with its form parameters at one place of their grid.
struct Variant {
  std::vector<double> forms{};
  /// Rows by sizes (a phase makes two of one: at 0 and 90 deg). Scaled so that the
  /// near-peak of what they do (95th percentile over the rows they reach) is 1 mm.
  Eigen::MatrixXd columns_mm{};
  double weight = 1;       ///< How likely these forms are beside the others'.
  double size_per_mm = 1;  ///< In the size's own unit, for that peak.
  double usual_mm = 0.01;  ///< What the cause usually does, from its declared prior.
};

/// One cause on one axis that might be in the rows, or a free form.
struct Candidate {
  int effect = -1;  ///< Index in the catalog; -1: a free form ("unknown").
  std::string cause{};
  std::string axis{};
  Shown shown{};
  double log_prior = 0;
  bool must_be_positive = false;
  std::vector<Variant> variants{};
  Eigen::VectorXd free_prior{};        ///< Of a free form's terms.
  std::vector<FreeTerm> free_terms{};  ///< The same terms.

  bool is_free() const { return effect < 0; }
  /// "cyclic_lead.x", "unknown.z{x,y}".
  std::string Name() const;
};

/// Whether it is a part of a closed chain in the wrong place: such a part acts by the
/// chain's geometry, exactly, and its shape has no freedom.
bool IsRigid(const Candidate& candidate);

/// Every cause that these rows could show, on every axis, and the free forms.
std::vector<Candidate> AllCandidates(const Observed& observed);

/// The variant of one effect at given forms; no columns where it shows nothing.
Variant VariantOf(const Observed& observed,
                  int effect,
                  const std::string& axis,
                  const std::vector<double>& forms);

/// How far a cause may deviate from its textbook shape: harmonics, smooth functions of
/// its own covariates, its shape changing along them, its derivative by its forms. The
/// columns are scaled like a Variant's; `share` of the cause's size in all.
struct Tolerance {
  Eigen::MatrixXd columns_mm{};
  Eigen::VectorXd prior{};  ///< Relative variance: to be multiplied by size^2.
};
Tolerance ToleranceOf(const Observed& observed,
                      const Candidate& candidate,
                      const Variant& variant);

/// The values of an effect's parameters, as injected, for sizes of a variant.
Injected ValuesOf(const Observed& observed,
                  const Candidate& candidate,
                  const Variant& variant,
                  const Eigen::VectorXd& sizes_mm);

/// Near-peak of what columns times sizes do: the 95th percentile of its magnitude over
/// the rows it reaches [mm].
double Peak_mm(const Eigen::VectorXd& change_mm);

}  // namespace caltwin
