#include "calibration/diagnosis/table_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "sim/base/dense.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr int kDegrees = 4;  // Legendre's 0 to 3.

bool IsSense(const Covariate& covariate) {
  return covariate.word.starts_with("dir_");
}

std::array<double, kDegrees> LegendreAt(double u) {
  return {1, u, (3 * u * u - 1) / 2, (5 * u * u * u - 3 * u) / 2};
}

/// What a coefficient of Legendre's polynomial makes of a range: from end to end, the
/// middle over its chord, the S over its chord.
constexpr std::array<double, kDegrees> kSizeOf = {1, 2, -1.5, -0.9622504486};
constexpr std::array<const char*, kDegrees> kNameOf = {"", "straight", "bow", "cubic"};

/// The places of a table, each once, and its terms there.
class Places {
 public:
  Places(const std::vector<Covariate>& covariates,
         const std::vector<FreeTerm>& terms,
         const std::vector<bool>& shows) {
    std::set<std::vector<double>> places;
    for (std::size_t i = 0; i < shows.size(); ++i) {
      if (!shows[i]) continue;
      std::vector<double> place;
      for (const Covariate& c : covariates) {
        place.push_back(c.values[static_cast<Eigen::Index>(i)]);
      }
      places.insert(std::move(place));
    }
    at_.assign(places.begin(), places.end());
    terms_.resize(num(), std::ssize(terms));
    for (Eigen::Index i = 0; i < terms_.rows(); ++i) {
      for (Eigen::Index k = 0; k < terms_.cols(); ++k) {
        terms_(i, k) = ProductAt(terms[static_cast<std::size_t>(k)],
                                 covariates,
                                 at_[static_cast<std::size_t>(i)]);
      }
    }
  }

  Eigen::Index num() const { return std::ssize(at_); }
  const std::vector<std::vector<double>>& at() const { return at_; }
  const Eigen::MatrixXd& terms() const { return terms_; }

 private:
  std::vector<std::vector<double>> at_{};
  Eigen::MatrixXd terms_{};
};

Eigen::MatrixXd LeastSquaresEach(const Eigen::MatrixXd& columns,
                                 const Eigen::MatrixXd& right) {
  Eigen::MatrixXd solved(columns.cols(), right.cols());
  for (Eigen::Index k = 0; k < right.cols(); ++k) {
    solved.col(k) = LeastSquares(columns, right.col(k));
  }
  return solved;
}

/// The table at its places, and how each of its coefficients' directions moves it.
struct Heights {
  Eigen::VectorXd mm{};
  Eigen::MatrixXd half_mm{};
};

Heights Rest(const Heights& of, const Eigen::MatrixXd& columns) {
  return {of.mm - columns * LeastSquares(columns, of.mm),
          of.half_mm - columns * LeastSquaresEach(columns, of.half_mm)};
}

// The root mean square, and its standard deviation to first order.
TablePart RootMeanSquare(const char* name, const Heights& of) {
  const double rms_mm = of.mm.norm() / std::sqrt(static_cast<double>(of.mm.size()));
  const double sd_mm = rms_mm == 0 ? 0
                                   : (of.half_mm.transpose() * of.mm).norm() /
                                         (rms_mm * static_cast<double>(of.mm.size()));
  return {.name = name, .size_um = UmFromMm(rms_mm), .sd_um = UmFromMm(sd_mm)};
}

TablePart PartOf(int degree,
                 const std::string& along,
                 Eigen::Index at,
                 const Eigen::VectorXd& sizes_mm,
                 const Eigen::MatrixXd& half_mm) {
  const auto d = static_cast<std::size_t>(degree);
  return {.name = kNameOf[d],
          .along = along,
          .size_um = UmFromMm(kSizeOf[d] * sizes_mm[at]),
          .sd_um = UmFromMm(std::abs(kSizeOf[d]) * half_mm.row(at).norm())};
}

/// A table over one covariate; over a sense and one other, the sense's half of it.
class OnALine {
 public:
  OnALine(const Covariate& covariate,
          std::size_t word,
          const Places& places,
          bool has_sense)
      : covariate_(covariate), sense_(places.num()), u_(places.num()) {
    for (Eigen::Index i = 0; i < places.num(); ++i) {
      const std::vector<double>& at = places.at()[static_cast<std::size_t>(i)];
      sense_[i] = has_sense ? at[0] : 1;
      u_[i] = covariate.Scaled(at[word]);
    }
    degrees_ = std::min(kDegrees, covariate.num_distinct - 1);
  }

  std::vector<TablePart> Parts(const Heights& heights) const {
    std::vector<TablePart> parts;
    const Eigen::MatrixXd straight = Polynomials();
    const Eigen::VectorXd sizes_mm = LeastSquares(straight, heights.mm);
    const Eigen::MatrixXd half_mm = LeastSquaresEach(straight, heights.half_mm);
    for (int d = 1; d < degrees_; ++d) {
      parts.push_back(PartOf(d, covariate_.word, d, sizes_mm, half_mm));
    }
    constexpr int kFewestForWaves = 8;
    if (covariate_.num_distinct < kFewestForWaves) return parts;
    const Heights rest = Rest(heights, straight);
    const double half_waves = LikeliestHalfWaves(straight, rest);
    const Eigen::MatrixXd wave = WithWave(straight, half_waves);
    parts.push_back(WavesOf(heights, wave, half_waves));
    TablePart left = RootMeanSquare("rest", Rest(heights, wave));
    left.along = covariate_.word;
    parts.push_back(left);
    return parts;
  }

 private:
  Eigen::MatrixXd Polynomials() const {
    Eigen::MatrixXd columns(u_.size(), degrees_);
    for (Eigen::Index i = 0; i < u_.size(); ++i) {
      const auto legendre = LegendreAt(u_[i]);
      for (int d = 0; d < degrees_; ++d) {
        columns(i, d) = sense_[i] * legendre[static_cast<std::size_t>(d)];
      }
    }
    return columns;
  }

  Eigen::MatrixXd WithWave(const Eigen::MatrixXd& straight, double half_waves) const {
    Eigen::MatrixXd columns(u_.size(), straight.cols() + 2);
    columns.leftCols(straight.cols()) = straight;
    for (Eigen::Index i = 0; i < u_.size(); ++i) {
      const double phase = half_waves * std::numbers::pi * (u_[i] + 1) / 2;
      columns(i, straight.cols()) = sense_[i] * std::cos(phase);
      columns(i, straight.cols() + 1) = sense_[i] * std::sin(phase);
    }
    return columns;
  }

  // From one and a half waves, which a cubic is nearly, to what the places can tell:
  // two of them a wave.
  double LikeliestHalfWaves(const Eigen::MatrixXd& straight,
                            const Heights& rest) const {
    constexpr double kFewest = 3, kStep = 0.25;
    double likeliest = kFewest, least_mm2 = HUGE_VAL;
    const double most = covariate_.num_distinct - 2;
    const auto num_steps = static_cast<int>((most - kFewest) / kStep);
    for (int step = 0; step <= num_steps; ++step) {
      const double half_waves = kFewest + step * kStep;
      const double left_mm2 = Rest({rest.mm, Eigen::MatrixXd(rest.mm.size(), 0)},
                                   WithWave(straight, half_waves))
                                  .mm.squaredNorm();
      if (left_mm2 >= least_mm2) continue;
      least_mm2 = left_mm2;
      likeliest = half_waves;
    }
    return likeliest;
  }

  TablePart WavesOf(const Heights& heights,
                    const Eigen::MatrixXd& wave,
                    double half_waves) const {
    const Eigen::VectorXd sizes = LeastSquares(wave, heights.mm).tail(2);
    const Eigen::MatrixXd half = LeastSquaresEach(wave, heights.half_mm).bottomRows(2);
    const double amplitude_mm = sizes.norm();
    const double sd_mm =
        amplitude_mm == 0 ? 0 : (half.transpose() * sizes).norm() / amplitude_mm;
    return {.name = "waves",
            .along = covariate_.word,
            .size_um = UmFromMm(amplitude_mm),
            .sd_um = UmFromMm(sd_mm),
            .period = 2 * (covariate_.max - covariate_.min) / half_waves};
  }

  const Covariate& covariate_;
  Eigen::VectorXd sense_{}, u_{};
  int degrees_ = 0;
};

// A table over a place of two words: products of Legendre's polynomials to degree 3.
std::vector<TablePart> PartsOfSurface(const std::vector<Covariate>& covariates,
                                      const Places& places,
                                      const Heights& heights) {
  std::vector<std::pair<int, int>> degrees;
  for (int both = 0; both < kDegrees; ++both) {
    for (int second = 0; second <= both; ++second) {
      if (both - second < covariates[0].num_distinct - 1 &&
          second < covariates[1].num_distinct - 1)
        degrees.emplace_back(both - second, second);
    }
  }
  if (std::ssize(degrees) >= places.num()) return {};
  Eigen::MatrixXd columns(places.num(), std::ssize(degrees));
  for (Eigen::Index i = 0; i < places.num(); ++i) {
    const std::vector<double>& at = places.at()[static_cast<std::size_t>(i)];
    const auto first = LegendreAt(covariates[0].Scaled(at[0]));
    const auto second = LegendreAt(covariates[1].Scaled(at[1]));
    for (std::size_t k = 0; k < degrees.size(); ++k) {
      columns(i, static_cast<Eigen::Index>(k)) =
          first[static_cast<std::size_t>(degrees[k].first)] *
          second[static_cast<std::size_t>(degrees[k].second)];
    }
  }
  const Eigen::VectorXd sizes_mm = LeastSquares(columns, heights.mm);
  const Eigen::MatrixXd half_mm = LeastSquaresEach(columns, heights.half_mm);
  std::vector<TablePart> parts;
  std::vector<Eigen::Index> cubic;
  for (std::size_t k = 0; k < degrees.size(); ++k) {
    const auto [first, second] = degrees[k];
    const auto at = static_cast<Eigen::Index>(k);
    if (first + second == kDegrees - 1) {
      cubic.push_back(at);
    } else if (first == 1 && second == 1) {
      parts.push_back({.name = "twist",
                       .size_um = UmFromMm(sizes_mm[at]),
                       .sd_um = UmFromMm(half_mm.row(at).norm())});
    } else if (first + second > 0) {
      const Covariate& along = covariates[first > 0 ? 0 : 1];
      parts.push_back(PartOf(first + second, along.word, at, sizes_mm, half_mm));
    }
  }
  if (!cubic.empty()) {
    const Eigen::MatrixXd third = columns(Eigen::all, cubic);
    parts.push_back(RootMeanSquare(
        "cubic", {third * sizes_mm(cubic), third * half_mm(cubic, Eigen::all)}));
  }
  parts.push_back(RootMeanSquare("rest", Rest(heights, columns)));
  return parts;
}

}  // namespace

std::vector<TablePart> PartsOfTable(const std::vector<Covariate>& covariates,
                                    const std::vector<FreeTerm>& terms,
                                    const TableFit& fit,
                                    const std::vector<bool>& shows) {
  const bool has_sense = IsSense(covariates[0]);
  const std::size_t first = has_sense ? 1 : 0;
  if (covariates.size() <= first) return {};
  constexpr int kFewestPlaces = 3;
  for (std::size_t c = first; c < covariates.size(); ++c) {
    const Covariate& covariate = covariates[c];
    if (IsSense(covariate) || covariate.is_periodic ||
        covariate.num_distinct < kFewestPlaces)
      return {};
  }
  const Places places(covariates, terms, shows);
  const Heights heights{places.terms() * fit.sizes_mm, places.terms() * fit.half_mm};
  if (covariates.size() - first == 2) {
    return PartsOfSurface(covariates, places, heights);
  }
  return OnALine(covariates[first], first, places, has_sense).Parts(heights);
}

}  // namespace caltwin
