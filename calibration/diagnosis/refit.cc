#include "calibration/diagnosis/refit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <ceres/dynamic_numeric_diff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "calibration/diagnosis/bent.h"
#include "calibration/diagnosis/fit_tables.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

// Standard deviation of what was believed before.
double PriorSd(const Distribution& prior) {
  if (const auto* normal = std::get_if<Normal>(&prior)) return normal->sd;
  if (const auto* uniform = std::get_if<Uniform>(&prior)) {
    return (uniform->max - uniform->min) / std::sqrt(12.0);
  }
  if (const auto* spread = std::get_if<LogNormal>(&prior)) {
    const double variance = std::pow(std::log(spread->factor), 2);
    return spread->median * std::exp(variance / 2) * std::sqrt(std::expm1(variance));
  }
  return std::numeric_limits<double>::infinity();
}

constexpr double kFormStep = 1e-3;
constexpr double kFarthest = 0.25;  // A form may move by so much of its value.
constexpr double kLonger = 2;       // A lag or time constant: to the grid's neighbour.

struct Reach {
  double min = 0;
  double max = 0;
};

Reach ReachOf(const Parameter& parameter, double form) {
  if (parameter.name == "lag_s" || parameter.name == "tau_s") {
    return {form / kLonger, std::max(form * kLonger, 1e-6)};
  }
  const double reach = std::max(std::abs(form) * kFarthest, 1e-6);
  return {form - reach, form + reach};
}

// The findings that keep their names, and where their forms stand in one vector.
class Findings {
 public:
  Findings(const Observed& observed,
           const std::vector<Candidate>& candidates,
           const SearchResult& search)
      : observed_(observed), candidates_(candidates), search_(search) {
    for (std::size_t i = 0; i < search.found.size(); ++i) {
      const Found& found = search.found[i];
      if (candidates[found.candidate].is_free() || found.lost_its_name) continue;
      named_.push_back(i);
      std::size_t form = 0;
      for (const Parameter& parameter :
           EffectAt(candidates[found.candidate].effect).parameters) {
        if (parameter.role != Role::kForm) continue;
        forms_.push_back(found.variant.forms.at(form++));
        reaches_.push_back(ReachOf(parameter, forms_.back()));
      }
    }
  }

  const std::vector<std::size_t>& named() const { return named_; }
  std::vector<double>& forms() { return forms_; }
  const std::vector<Reach>& reaches() const { return reaches_; }
  const Found& found(std::size_t k) const { return search_.found[named_[k]]; }
  const Candidate& candidate(std::size_t k) const {
    return candidates_[found(k).candidate];
  }

  // The forms of the k-th, out of a vector of all.
  std::vector<double> FormsOf(std::size_t k, const double* all) const {
    for (std::size_t j = 0; j < k; ++j) all += found(j).variant.forms.size();
    return {all, all + found(k).variant.forms.size()};
  }

  // Columns of all named findings at these forms; none where one shows nothing there.
  std::optional<Eigen::MatrixXd> ColumnsAt(const double* all) const {
    std::vector<Variant> variants;
    Eigen::Index num = 0;
    for (std::size_t k = 0; k < named_.size(); ++k) {
      variants.push_back(VariantOf(
          observed_, candidate(k).effect, candidate(k).axis, FormsOf(k, all)));
      if (variants.back().columns_mm.cols() == 0) return std::nullopt;
      num += variants.back().columns_mm.cols();
    }
    Eigen::MatrixXd columns(observed_.num_rows(), num);
    Eigen::Index at = 0;
    for (const Variant& variant : variants) {
      columns.middleCols(at, variant.columns_mm.cols()) = variant.columns_mm;
      at += variant.columns_mm.cols();
    }
    return columns;
  }

 private:
  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const SearchResult& search_;
  std::vector<std::size_t> named_{};
  std::vector<double> forms_{};
  std::vector<Reach> reaches_{};  ///< Of each form.
};

Eigen::VectorXd SolveSizes(const Evidence& evidence, const Eigen::MatrixXd& white) {
  Projected projected = evidence.Project(white);
  projected.gram.diagonal().array() +=
      1e-12 * (projected.gram.diagonal().maxCoeff() + 1e-300);
  return Cholesky(projected.gram).Solve(projected.match);
}

// What is left of the white rows at these forms, all sizes at their best.
struct Remainder {
  const Findings* findings;
  const Evidence* evidence;

  bool operator()(const double* const* parameters, double* residuals) const {
    const auto columns = findings->ColumnsAt(parameters[0]);
    if (!columns) return false;
    const Eigen::MatrixXd white = evidence->Whiten(*columns);
    const Eigen::VectorXd sizes = SolveSizes(*evidence, white);
    const Eigen::VectorXd left =
        evidence->Left(evidence->white_residual() - white * sizes);
    Eigen::Map<Eigen::VectorXd>(residuals, left.size()) = left;
    return true;
  }
};

void RefineForms(const Evidence& evidence, Eigen::Index num_rows, Findings* findings) {
  std::vector<double>& forms = findings->forms();
  if (forms.empty()) return;
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Remainder, ceres::CENTRAL>(
      new Remainder{findings, &evidence});
  cost->AddParameterBlock(static_cast<int>(forms.size()));
  cost->SetNumResiduals(static_cast<int>(num_rows));
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, forms.data());
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const Reach& reach = findings->reaches()[i];
    problem.SetParameterLowerBound(forms.data(), static_cast<int>(i), reach.min);
    problem.SetParameterUpperBound(forms.data(), static_cast<int>(i), reach.max);
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 20;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const std::vector<double> before = forms;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) forms = before;
}

// Half the time between the rows on either side of a jump, as a uniform's deviation.
double JumpSd_s(const Observed& observed, double at_s) {
  double before_s = -1e300, after_s = 1e300;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double t_s = observed.at(i).t_s;
    if (t_s < at_s) before_s = std::max(before_s, t_s);
    if (t_s >= at_s) after_s = std::min(after_s, t_s);
  }
  return (after_s - before_s) / std::sqrt(12.0);
}

// Sizes and forms of one finding with the covariance of the linearised problem, the
// other findings and all freedom of form being nuisances.
class Final {
 public:
  Final(const Observed& observed,
        const std::vector<Candidate>& candidates,
        const SearchResult& search)
      : observed_(observed), candidates_(candidates), search_(search) {}

  // `together_mm`: its sizes in the fit of all findings together; empty: it shows
  // nothing at these forms.
  Refined Of(std::size_t index,
             const std::vector<double>& forms,
             const Eigen::VectorXd& together_mm) const {
    const Found& found = search_.found[index];
    const Candidate& candidate = candidates_[found.candidate];
    Refined refined{.variant =
                        VariantOf(observed_, candidate.effect, candidate.axis, forms)};
    if (refined.variant.columns_mm.cols() == 0) refined.variant = found.variant;
    const Evidence evidence =
        EvidenceWithout(index, refined.variant, /*is_free=*/!IsRigid(candidate));
    const Eigen::Index num_sizes = refined.variant.columns_mm.cols();
    Eigen::MatrixXd columns = refined.variant.columns_mm;
    // The effects act without their freedom of form, so they are fitted without; how
    // sure a size is, the freedom decides.
    refined.sizes_mm = together_mm;
    if (together_mm.size() != num_sizes) {
      const Evidence plain = EvidenceWithout(index, refined.variant, /*is_free=*/false);
      refined.sizes_mm = SolveSizes(plain, plain.Whiten(columns));
    }
    const std::size_t num_forms = refined.variant.forms.size();
    columns.conservativeResize(Eigen::NoChange,
                               num_sizes + static_cast<Eigen::Index>(num_forms));
    for (std::size_t f = 0; f < num_forms; ++f) {
      columns.col(num_sizes + static_cast<Eigen::Index>(f)) =
          Slope(candidate, refined, f);
    }
    const Eigen::MatrixXd covariance = Covariance(evidence, columns);
    refined.effect = ValuesOf(observed_, candidate, refined.variant, refined.sizes_mm);
    refined.sds = SdsOf(candidate, refined, covariance);
    return refined;
  }

 private:
  // All but the sizes of one finding; `is_free`: with the freedom of its form.
  Evidence EvidenceWithout(std::size_t index,
                           const Variant& variant,
                           bool is_free) const {
    std::vector<Nuisance> nuisances = search_.circumstances.nuisances;
    for (std::size_t i = 0; i < search_.found.size(); ++i) {
      const Candidate& candidate = candidates_[search_.found[i].candidate];
      Found found = search_.found[i];
      if (i == index) found.variant = variant;
      auto more = NuisancesOf(observed_, candidate, found);
      if (i == index && !is_free) continue;
      if (i == index) {
        more.erase(more.begin(), more.begin() + variant.columns_mm.cols());
      }
      nuisances.insert(nuisances.end(), more.begin(), more.end());
    }
    return {observed_,
            {search_.circumstances.sigma_mm, search_.wander_mm2_per_s},
            nuisances,
            search_.circumstances.left_out};
  }

  // What one unit of a form changes, sizes as found [mm]. Nothing of a time where no
  // row has one: rows in their order say nothing of seconds.
  Eigen::VectorXd Slope(const Candidate& candidate,
                        const Refined& refined,
                        std::size_t f) const {
    const bool is_time = FormNamed(candidate, f).ends_with("_s");
    if (is_time && !observed_.has_times()) {
      return Eigen::VectorXd::Zero(observed_.num_rows());
    }
    const auto at = [&](double step) {
      std::vector<double> forms = refined.variant.forms;
      forms[f] += step;
      const Variant variant =
          VariantOf(observed_, candidate.effect, candidate.axis, forms);
      Eigen::VectorXd change = Eigen::VectorXd::Zero(observed_.num_rows());
      if (variant.columns_mm.cols() == refined.sizes_mm.size()) {
        change = variant.columns_mm * refined.sizes_mm *
                 (refined.variant.size_per_mm / variant.size_per_mm);
      }
      return change;
    };
    const double step = std::max(std::abs(refined.variant.forms[f]), 1e-3) * kFormStep;
    return (at(step) - at(-step)) / (2 * step);
  }

  static std::string_view FormNamed(const Candidate& candidate, std::size_t f) {
    for (const Parameter& parameter : EffectAt(candidate.effect).parameters) {
      if (parameter.role == Role::kForm && f-- == 0) return parameter.name;
    }
    return {};
  }

  static Eigen::MatrixXd Covariance(const Evidence& evidence,
                                    const Eigen::MatrixXd& columns) {
    Eigen::MatrixXd gram = evidence.Project(evidence.Whiten(columns)).gram;
    // A form that changes nothing (a jump between rows) is not told here.
    for (Eigen::Index k = 0; k < gram.cols(); ++k) {
      gram(k, k) += 1e-12 * gram.diagonal().maxCoeff() + 1e-300;
    }
    return PivotedCholesky(gram).Inverse() * (evidence.chi2() / evidence.dof());
  }

  // Of the root mean square of n draws it is 1 / sqrt(2 n) of that. What all homings
  // share, and those that stand alone in their setups, the placements take up: only
  // what is told better than the draws scatter counts.
  static double ScatterSd_mm(const Eigen::VectorXd& draws_mm,
                             const Eigen::MatrixXd& covariance_mm2) {
    const double rms_mm =
        draws_mm.norm() / std::sqrt(static_cast<double>(draws_mm.size()));
    const auto told = (EigenvaluesOf(covariance_mm2).array() < rms_mm * rms_mm).count();
    return rms_mm /
           std::sqrt(2.0 * static_cast<double>(std::max<Eigen::Index>(told, 1)));
  }

  std::vector<double> SdsOf(const Candidate& candidate,
                            const Refined& refined,
                            const Eigen::MatrixXd& covariance) const {
    const auto parameters = EffectAt(candidate.effect).parameters;
    const Eigen::Index num_sizes = refined.sizes_mm.size();
    const Eigen::VectorXd& a = refined.sizes_mm;
    std::vector<double> sds(parameters.size(), 0);
    const double norm = std::max(a.norm(), 1e-300);
    Eigen::Index form = num_sizes, size = 0;
    const bool has_one_size =
        std::ranges::count(parameters, Role::kSize, &Parameter::role) == 1;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].role == Role::kSize && !has_one_size) {
        sds[i] = std::sqrt(covariance(size, size)) * refined.variant.size_per_mm;
        ++size;
      } else if (candidate.effect == EffectIndex<HomingScatter>()) {
        sds[i] = ScatterSd_mm(a, covariance.topLeftCorner(num_sizes, num_sizes)) *
                 refined.variant.size_per_mm;
      } else if (parameters[i].role == Role::kSize) {
        const Eigen::VectorXd along = a / norm;
        const auto block = covariance.topLeftCorner(num_sizes, num_sizes);
        sds[i] = std::sqrt(along.dot(block * along)) * refined.variant.size_per_mm;
      } else if (parameters[i].role == Role::kPhase && num_sizes == 2) {
        const Eigen::Vector2d across(-a[1] / norm, a[0] / norm);
        const Eigen::Matrix2d block = covariance.topLeftCorner<2, 2>();
        sds[i] = DegFromRad(std::sqrt(across.dot(block * across)) / norm);
      } else {
        const std::string_view name = parameters[i].name;
        const double value = refined.effect.values[i];
        sds[i] = name == "at_t_s" ? JumpSd_s(observed_, value)
                                  : std::sqrt(covariance(form, form));
        // What the rows say little of, or in steps, is known as it was before.
        sds[i] = std::min(sds[i], PriorSd(parameters[i].prior));
        ++form;
      }
    }
    return sds;
  }

  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  const SearchResult& search_;
};

}  // namespace

std::vector<Refined> Refit(const Observed& observed,
                           const std::vector<Candidate>& candidates,
                           const SearchResult& search) {
  Findings findings(observed, candidates, search);
  std::vector<Nuisance> nuisances = search.circumstances.nuisances;
  for (const Found& found : search.found) {
    const Candidate& candidate = candidates[found.candidate];
    if (!candidate.is_free() && !found.lost_its_name) continue;
    const auto more = NuisancesOf(observed, candidate, found);
    nuisances.insert(nuisances.end(), more.begin(), more.end());
  }
  const Evidence evidence(observed,
                          {search.circumstances.sigma_mm, search.wander_mm2_per_s},
                          nuisances,
                          search.circumstances.left_out);
  RefineForms(evidence, observed.num_rows(), &findings);
  std::vector<Refined> refined(search.found.size(), {.effect = {.effect = -1}});
  const Final final(observed, candidates, search);
  Eigen::VectorXd together_mm;
  const auto columns = findings.ColumnsAt(findings.forms().data());
  if (columns && columns->cols() > 0) {
    together_mm = SolveSizes(evidence, evidence.Whiten(*columns));
  }
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < findings.named().size(); ++k) {
    const Eigen::Index num = findings.found(k).variant.columns_mm.cols();
    Eigen::VectorXd own_mm;
    if (together_mm.size() > 0) own_mm = together_mm.segment(at, num);
    refined[findings.named()[k]] = final.Of(
        findings.named()[k], findings.FormsOf(k, findings.forms().data()), own_mm);
    at += num;
  }
  for (Bent& bent : Bend(observed, candidates, search)) {
    refined[bent.finding] = std::move(bent.refined);
  }
  FitTables(observed, candidates, search, &refined);
  return refined;
}

}  // namespace caltwin
