#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "calibration/estimate/inner_products.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

Eigen::MatrixXd Normal(Eigen::Index rows, Eigen::Index columns, Rng* rng) {
  Eigen::MatrixXd matrix(rows, columns);
  for (double& value : matrix.reshaped()) value = rng->Normal();
  return matrix;
}

ColumnsView ViewOf(const Eigen::MatrixXd& matrix, Eigen::Index columns) {
  return {matrix.data(), matrix.rows(), columns, matrix.rows()};
}

struct Sums {
  double sum = 0, rounding = 0;
};

// In long double, with what doubles may be off by.
Sums SumsOf(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  long double sum = 0, size = 0;
  for (Eigen::Index r = 0; r < a.size(); ++r) {
    const long double product = static_cast<long double>(a[r]) * b[r];
    sum += product;
    size += std::abs(product);
  }
  return {static_cast<double>(sum),
          static_cast<double>(size) * static_cast<double>(a.size()) *
              std::numeric_limits<double>::epsilon()};
}

// Against sums in long double, at lengths and numbers on both sides of every tile.
TEST(InnerProducts, AreSumsOverRows) {
  Rng rng(1, 0, "inner_products_test");
  for (const Eigen::Index rows : {1, 3, 4, 5, 255, 256, 257, 700}) {
    for (Eigen::Index num = 1; num <= 9; ++num) {
      const Eigen::MatrixXd a = Normal(rows, num, &rng), b = Normal(rows, 9, &rng);
      Eigen::MatrixXd products(num, 9);

      InnerProducts(ViewOf(a, num), ViewOf(b, 9), products.data());

      for (Eigen::Index ij = 0; ij < num * 9; ++ij) {
        const Eigen::Index i = ij / 9, j = ij % 9;
        const Sums exact = SumsOf(a.col(i), b.col(j));
        EXPECT_NEAR(products(i, j), exact.sum, exact.rounding);
      }
    }
  }
}

TEST(InnerProducts, DoNotDependOnTheColumnsBeside) {
  Rng rng(2, 0, "inner_products_test");
  const Eigen::MatrixXd a = Normal(300, 8, &rng), b = Normal(300, 8, &rng);
  Eigen::MatrixXd few(2, 3), all(8, 8);

  InnerProducts(ViewOf(a, 2), ViewOf(b, 3), few.data());
  InnerProducts(ViewOf(a, 8), ViewOf(b, 8), all.data());

  EXPECT_EQ(few, all.topLeftCorner(2, 3));
}

TEST(InnerProducts, OfNoRowsAreNothing) {
  Eigen::MatrixXd products = Eigen::MatrixXd::Ones(2, 2);
  const Eigen::MatrixXd none(0, 2);

  InnerProducts(ViewOf(none, 2), ViewOf(none, 2), products.data());

  EXPECT_EQ(products, Eigen::MatrixXd::Zero(2, 2));
}

}  // namespace
}  // namespace caltwin
