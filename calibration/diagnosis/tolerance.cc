// How far a cause may deviate from its textbook shape (candidates.h: ToleranceOf).

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/diagnosis/candidates.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

constexpr double kToleranceShare = 0.2;
constexpr double kFormStep = 0.03;

// Columns to append, each scaled to a peak of 1 mm.
class Columns {
 public:
  explicit Columns(Eigen::Index rows) : rows_(rows) {}
  void Add(const Eigen::VectorXd& column) {
    const double peak = Peak_mm(column);
    if (peak > 1e-6) columns_.emplace_back(column / peak);
  }
  Eigen::MatrixXd Take() const {
    Eigen::MatrixXd all(rows_, static_cast<Eigen::Index>(columns_.size()));
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      all.col(static_cast<Eigen::Index>(k)) = columns_[k];
    }
    return all;
  }

 private:
  Eigen::Index rows_;
  std::vector<Eigen::VectorXd> columns_{};
};

void AddModulated(const Observed& o,
                  const Candidate& candidate,
                  const Variant& variant,
                  Columns* columns) {
  for (const std::string& word : candidate.shown.covariates) {
    if (word.starts_with("dir_")) continue;
    const auto covariate = CovariateOf(o, word);
    if (!covariate || covariate->num_distinct < 3 || covariate->is_periodic) continue;
    for (Eigen::Index k = 0; k < variant.columns_mm.cols(); ++k) {
      Eigen::VectorXd once = variant.columns_mm.col(k), twice = once;
      for (Eigen::Index i = 0; i < once.size(); ++i) {
        const double u = covariate->Scaled(covariate->values[i]);
        once[i] *= u;
        twice[i] *= (3 * u * u - 1) / 2;
      }
      columns->Add(once);
      columns->Add(twice);
    }
  }
}

// The two columns are w sin(a) and w cos(a), w the channel's sign and size: harmonics
// are w sin(k a) and w cos(k a).
void AddHarmonics(const Observed& o,
                  const Candidate& candidate,
                  const Variant& variant,
                  Columns* columns) {
  const int most = EffectAt(candidate.effect).sight->harmonics;
  if (most < 2 || variant.columns_mm.cols() != 2) return;
  const Eigen::VectorXd shows = ChannelOf(o, candidate.shown.channel);
  for (int order = 2; order <= most; ++order) {
    Eigen::VectorXd sine(o.num_rows()), cosine(o.num_rows());
    for (Eigen::Index i = 0; i < o.num_rows(); ++i) {
      const double sign = shows[i] < 0 ? -1 : 1;
      const double size = variant.columns_mm.row(i).norm();
      const double angle =
          std::atan2(sign * variant.columns_mm(i, 0), sign * variant.columns_mm(i, 1));
      sine[i] = sign * size * std::sin(order * angle);
      cosine[i] = sign * size * std::cos(order * angle);
    }
    columns->Add(sine);
    columns->Add(cosine);
  }
}

// Whether it is a bend of a round bed over the place. Baseline and other bends take
// up most of one there: were its freedom any smooth function of the place, it would
// take up the others.
bool IsBendOfRoundBed(const Observed& o, const Candidate& candidate) {
  return o.num_rows() > 0 && o.at(0).rim_mm > 0 && candidate.shown.channel == "bed" &&
         std::ranges::all_of(candidate.shown.covariates, [](const std::string& word) {
           return word == "x" || word == "y";
         });
}

// How else plates bend, in the bend's own variable (r of a bowl, u of a cylinder, the
// product of a twist): couples at its rim make c, forces at points c ln h, its own
// weight c h, h = |c| / max |c|.
void AddBends(const Variant& variant, Columns* columns) {
  for (Eigen::Index k = 0; k < variant.columns_mm.cols(); ++k) {
    Eigen::VectorXd by_points = variant.columns_mm.col(k), by_weight = by_points;
    const double most_mm = by_points.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < by_points.size(); ++i) {
      const double height = std::abs(by_points[i]) / most_mm;
      by_points[i] *= height > 0 ? std::log(height) : 0;
      by_weight[i] *= height;
    }
    columns->Add(by_points);
    columns->Add(by_weight);
  }
}

void AddDerivatives(const Observed& o,
                    const Candidate& candidate,
                    const Variant& variant,
                    Columns* columns) {
  for (std::size_t f = 0; f < variant.forms.size(); ++f) {
    std::vector<double> forms = variant.forms;
    forms[f] *= 1 + kFormStep;
    if (forms[f] == variant.forms[f]) continue;
    const Variant moved = VariantOf(o, candidate.effect, candidate.axis, forms);
    if (moved.columns_mm.cols() != variant.columns_mm.cols()) continue;
    for (Eigen::Index k = 0; k < moved.columns_mm.cols(); ++k) {
      columns->Add(moved.columns_mm.col(k) - variant.columns_mm.col(k));
    }
  }
}

}  // namespace

Tolerance ToleranceOf(const Observed& observed,
                      const Candidate& candidate,
                      const Variant& variant) {
  Columns columns(observed.num_rows());
  const bool has_freedom = !candidate.is_free() &&
                           candidate.cause != HomingScatter::kDeclaration.name &&
                           !IsRigid(candidate);
  if (has_freedom && IsBendOfRoundBed(observed, candidate)) {
    AddBends(variant, &columns);
  } else if (has_freedom) {
    AddModulated(observed, candidate, variant, &columns);
    AddHarmonics(observed, candidate, variant, &columns);
    AddDerivatives(observed, candidate, variant, &columns);
    constexpr int kSmoothTerms = 6;
    const FreeForm smooth = FreeFormOf(
        observed, candidate.shown.channel, candidate.shown.covariates, kSmoothTerms);
    for (Eigen::Index k = 0; k < smooth.columns_mm.cols(); ++k) {
      columns.Add(smooth.columns_mm.col(k));
    }
  }
  Tolerance tolerance{.columns_mm = columns.Take()};
  const auto m = tolerance.columns_mm.cols();
  tolerance.prior =
      Eigen::VectorXd::Constant(m,
                                kToleranceShare * kToleranceShare /
                                    static_cast<double>(std::max<Eigen::Index>(m, 1)));
  return tolerance;
}

}  // namespace caltwin
