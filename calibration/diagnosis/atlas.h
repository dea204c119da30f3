#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/observed.h"
#include "sim/measure/plan.h"

namespace caltwin {

/// One cause on one axis, as some rows would see it, whatever they read.
struct AtlasCause {
  std::string cause{};
  std::string axis{};
  /// Near-peak [um] that would be seen at odds of about 20:1, in its worst phase: five
  /// sigma of what the baseline leaves, |M W Phi a|^2 = 25. Of a wave the worst
  /// period, of another cause with a form (a time constant) the median over its forms.
  double smallest_um = 0;
  double usual_um = 0;    ///< Near-peak that its declared prior expects.
  double share_left = 0;  ///< |M W Phi| over |W Phi|: what the baseline leaves.
  std::string into{};     ///< The baseline's lines that take the rest.

  /// "cyclic_lead.x".
  std::string Name() const;
};

/// Two causes that these rows could hardly tell apart.
struct ConfoundedPair {
  AtlasCause first{}, second{};
  /// Square root of lambda_sep, at the usual size (at the smallest visible one, where
  /// that is larger), the less favourable of both ways round; below 3.
  double separation_sigma = 0;
};

/// What rows can and cannot show, from derivatives alone, before any reading.
struct Atlas {
  std::vector<AtlasCause> visible{};         ///< In the catalog's order.
  std::vector<AtlasCause> absorbed{};        ///< The baseline imitates them.
  std::vector<AtlasCause> unseen{};          ///< No row responds to them at all.
  std::vector<ConfoundedPair> confounded{};  ///< The closest first.
};

/// The atlas of rows under a noise. Free forms among the candidates are left aside.
/// Absorbed: less than 2 % of it is left, or no tenfold of its usual size is seen.
Atlas AtlasOf(const Observed& observed,
              const std::vector<Candidate>& candidates,
              const Eigen::VectorXd& sigma_mm);
/// Its absorbed causes alone: far quicker.
std::vector<AtlasCause> AbsorbedOf(const Observed& observed,
                                   const std::vector<Candidate>& candidates,
                                   const Eigen::VectorXd& sigma_mm,
                                   const std::vector<Nuisance>& baseline);

/// The sigma of each row as its instrument states it; 1 um where nobody said.
Eigen::VectorXd PlannedSigma_mm(const Observed& observed);

/// How far two causes are apart: least |(I - P_[B,rival]) W Phi a|^2 over all that the
/// rival can do, for whitened columns already projected.
///
///   lambda = min eig(own - cross' rival^-1 cross) . size^2
///
/// @param cross  rival columns by own columns
double Lambda(const Eigen::MatrixXd& own,
              const Eigen::MatrixXd& cross,
              const Eigen::MatrixXd& rival,
              double size_mm,
              bool is_random);

/// A campaign that could be added to a plan.
struct Addition {
  std::string kind{};
  std::map<std::string, std::string> options{};  ///< Those that differ from the usual.
  std::vector<std::string> separates{};          ///< Causes, each once.
  std::vector<std::pair<std::string, std::string>> pairs{};  ///< Told apart by it.
  std::vector<std::string> shows{};  ///< Neither absorbed nor unseen any more.
  double minutes = 0;
  /// Sigmas gained, at most ten a pair or cause; the list's order is this per minute.
  double sigmas_gained = 0;
};

struct PlanAtlas {
  Atlas atlas{};
  std::vector<Addition> add{};
  std::size_t num_rows = 0;
  double minutes = 0;
};

/// The atlas of a plan on a machine (with the effects its model holds), and what each
/// kind of campaign would add.
PlanAtlas AtlasOfPlan(const Plan& plan,
                      const Machine& machine,
                      const std::vector<Injected>& effects,
                      std::uint64_t seed);

/// Every kind of campaign with its usual options, once along each axis or plane it
/// knows. `changed`: those options that differ from the usual.
struct CampaignChoice {
  PlannedCampaign campaign{};
  std::map<std::string, std::string> changed{};
};
std::vector<CampaignChoice> CampaignChoices();

}  // namespace caltwin
