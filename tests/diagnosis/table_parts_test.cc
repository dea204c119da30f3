#include "calibration/diagnosis/table_parts.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/dense.h"

namespace caltwin {
namespace {

constexpr double kRange_mm = 300;

// Places apart by a little more or less, as a plan spreads them.
Covariate Along(const std::string& word, const std::vector<double>& places) {
  Covariate covariate{.word = word, .num_distinct = static_cast<int>(places.size())};
  covariate.values =
      Eigen::Map<const Eigen::VectorXd>(places.data(), std::ssize(places));
  covariate.min = covariate.values.minCoeff();
  covariate.max = covariate.values.maxCoeff();
  return covariate;
}

std::vector<double> Spread(int num) {
  std::vector<double> places;
  for (int i = 0; i < num; ++i) {
    const double wiggle = i % (num - 1) == 0 ? 0 : 0.3 * std::sin(7.0 * i);
    places.push_back(kRange_mm * (i + wiggle) / (num - 1));
  }
  return places;
}

/// The terms nearest to a function of the scaled place [mm].
TableFit Nearest(const std::vector<Covariate>& covariates,
                 const std::vector<FreeTerm>& terms,
                 const std::function<double(double, double)>& table_mm) {
  const Eigen::Index rows = covariates[0].values.size();
  Eigen::MatrixXd columns(rows, std::ssize(terms));
  Eigen::VectorXd wanted(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    std::vector<double> at;
    for (const Covariate& c : covariates) at.push_back(c.values[i]);
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      columns(i, k) = ProductAt(terms[static_cast<std::size_t>(k)], covariates, at);
    }
    wanted[i] = table_mm(covariates[0].Scaled(at[0]),
                         at.size() > 1 ? covariates[1].Scaled(at[1]) : 0);
  }
  return {LeastSquares(columns, wanted), Eigen::MatrixXd::Zero(columns.cols(), 1)};
}

const TablePart* Named(const std::vector<TablePart>& parts,
                       const std::string& name,
                       const std::string& along) {
  for (const TablePart& part : parts) {
    if (part.name == name && part.along == along) return &part;
  }
  return nullptr;
}

double SizeOf(const std::vector<TablePart>& parts,
              const std::string& name,
              const std::string& along) {
  const TablePart* part = Named(parts, name, along);
  return part == nullptr ? std::nan("") : part->size_um;
}

std::vector<bool> All(const Covariate& covariate) {
  return std::vector<bool>(static_cast<std::size_t>(covariate.values.size()), true);
}

// A line that rises by 12 um, a bow of 4 over its chord and an S of 2 over its own: of
// (5 u^3 - 3 u) / 2 that is 5 / (3 sqrt(3)) at u = 1 / sqrt(3).
TEST(TableParts, OfALineAreWhatItIsASumOf) {
  const std::vector<Covariate> x = {Along("x", Spread(41))};
  const auto terms = TermsOf(x);
  const double chord = 5 / (3 * std::numbers::sqrt3);
  const TableFit fit = Nearest(x, terms, [&](double u, double) {
    return 1e-3 * (6 * u + 4 * (1 - u * u) - 2 / chord * (5 * u * u * u - 3 * u) / 2);
  });
  const auto parts = PartsOfTable(x, terms, fit, All(x[0]));

  EXPECT_NEAR(SizeOf(parts, "straight", "x"), 12, 0.1);
  EXPECT_NEAR(SizeOf(parts, "bow", "x"), 4, 0.1);
  EXPECT_NEAR(SizeOf(parts, "cubic", "x"), 2, 0.1);
  // Cosines, which are flat at both ends, follow an S to so much.
  EXPECT_LT(SizeOf(parts, "waves", "x"), 0.3);
  EXPECT_LT(SizeOf(parts, "rest", "x"), 0.3);
}

TEST(TableParts, OfAWaveAreItsAmplitudeAndItsPeriod) {
  const std::vector<Covariate> x = {Along("x", Spread(41))};
  const auto terms = TermsOf(x);
  const TableFit fit = Nearest(x, terms, [&](double u, double) {
    const double at_mm = kRange_mm * (u + 1) / 2;
    return 3e-3 * std::sin(2 * std::numbers::pi * (at_mm - 20) / 80);
  });
  const auto parts = PartsOfTable(x, terms, fit, All(x[0]));

  EXPECT_NEAR(SizeOf(parts, "waves", "x"), 3, 0.1);
  EXPECT_NEAR(Named(parts, "waves", "x")->period, 80, 2);
  EXPECT_LT(SizeOf(parts, "rest", "x"), 0.2);
}

TEST(TableParts, AreAsSureAsTheTermsAre) {
  const std::vector<Covariate> x = {Along("x", Spread(21))};
  const std::vector<FreeTerm> line = {{-1, 0}};
  const TableFit fit{Eigen::VectorXd::Constant(1, 0.010),
                     Eigen::MatrixXd::Constant(1, 1, 0.002)};
  const auto parts = PartsOfTable(x, line, fit, All(x[0]));

  EXPECT_NEAR(SizeOf(parts, "straight", "x"), 20, 1e-6);
  EXPECT_NEAR(Named(parts, "straight", "x")->sd_um, 4, 1e-6);
  EXPECT_NEAR(Named(parts, "bow", "x")->sd_um, 0, 1e-6);
}

// As far as the places tell: three have no bow to speak of, and rows that the table is
// not of count for none.
TEST(TableParts, AreNoMoreThanThePlacesTell) {
  std::vector<Covariate> x = {Along("x", {0, 100, 300})};
  const std::vector<FreeTerm> line = {{-1, 0}};
  const TableFit fit{Eigen::VectorXd::Constant(1, 0.010),
                     Eigen::MatrixXd::Constant(1, 1, 0.002)};
  const auto parts = PartsOfTable(x, line, fit, {true, true, true});

  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].name, "straight");
  x[0].num_distinct = 2;
  EXPECT_TRUE(PartsOfTable(x, line, fit, {true, true, true}).empty());
}

// A gap that grows along the axis: half of it is what each sense reads.
TEST(TableParts, OfASenseAreThoseAlongTheAxis) {
  std::vector<double> senses, places;
  for (int i = 0; i < 11; ++i) {
    for (const double sense : {-1.0, 1.0}) {
      senses.push_back(sense);
      places.push_back(kRange_mm * i / 10);
    }
  }
  std::vector<Covariate> both = {Along("dir_x", senses), Along("x", places)};
  both[1].num_distinct = 11;
  const std::vector<FreeTerm> growing = {{1, -1}};
  const TableFit fit{Eigen::VectorXd::Constant(1, 0.004), Eigen::MatrixXd::Zero(1, 1)};
  const auto parts = PartsOfTable(both, growing, fit, All(both[0]));

  EXPECT_NEAR(SizeOf(parts, "straight", "x"), 8, 1e-6);
}

TEST(TableParts, OfASurfaceAreBowsAndATwist) {
  std::vector<double> first, second;
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) {
      first.push_back(kRange_mm * i / 6);
      second.push_back(kRange_mm * j / 6);
    }
  }
  std::vector<Covariate> place = {Along("x", first), Along("y", second)};
  place[0].num_distinct = place[1].num_distinct = 7;
  const auto terms = TermsOf(place, TermsOfTwo::kProducts);
  const TableFit twisted =
      Nearest(place, terms, [](double u, double v) { return 5e-3 * u * v; });
  const auto parts = PartsOfTable(place, terms, twisted, All(place[0]));

  EXPECT_NEAR(SizeOf(parts, "twist", ""), 5, 1e-6);
  EXPECT_NEAR(SizeOf(parts, "bow", "x"), 0, 1e-6);
  EXPECT_NEAR(SizeOf(parts, "cubic", ""), 0, 1e-6);
  EXPECT_NEAR(SizeOf(parts, "rest", ""), 0, 1e-6);
}

}  // namespace
}  // namespace caltwin
