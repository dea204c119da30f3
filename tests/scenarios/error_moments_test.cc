#include "scenarios/study/error_moments.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

struct Told {
  std::string name{};
  double error = 0;
};

void Add(const std::vector<Told>& told, ErrorMoments* moments) {
  TrialResult result;
  for (const Told& one : told) {
    result.parameters.push_back({.name = one.name, .error = one.error});
  }
  moments->Add(result);
}

// Errors of 10 about 1e6: sums about zero would have lost them.
constexpr double kFar = 1e6;

TEST(ErrorMoments, IsPearsonsCoefficientOfEachPair) {
  ErrorMoments moments;
  const std::vector<double> a = {1, 2, 3, 4, 5}, b = {2, 1, 4, 3, 5};
  for (std::size_t i = 0; i < a.size(); ++i) {
    Add({{"a", kFar + a[i]}, {"b", -b[i]}, {"same", 7}}, &moments);
  }

  const Correlations of = moments.Result();

  ASSERT_EQ(of.names, (std::vector<std::string>{"a", "b", "same"}));
  EXPECT_NEAR(of.matrix(0, 1), -0.8, 1e-9);  // 1 - 6 sum d^2 / (n (n^2 - 1)), by ranks.
  EXPECT_EQ(of.matrix(0, 1), of.matrix(1, 0));
  EXPECT_EQ(of.matrix(0, 2), 0);  // What never errs goes with nothing.
  EXPECT_EQ(of.matrix(2, 2), 1);
}

TEST(ErrorMoments, APairIsOfTheTrialsThatTellBoth) {
  ErrorMoments moments;
  Add({{"a", 1}, {"b", 1}}, &moments);
  Add({{"b", 50}}, &moments);
  Add({{"b", 2}, {"a", 2}}, &moments);
  Add({{"a", 3}, {"b", 3}}, &moments);
  Add({{"a", -40}}, &moments);

  EXPECT_EQ(moments.least_trials(), 3);
  EXPECT_NEAR(moments.Result().matrix(0, 1), 1, 1e-12);
}

TEST(ErrorMoments, SaysNothingOfTooFew) {
  ErrorMoments moments;
  EXPECT_TRUE(moments.Result().names.empty());
  Add({{"a", 1}, {"b", 1}}, &moments);
  Add({{"a", 2}, {"b", 3}}, &moments);

  EXPECT_TRUE(moments.Result().names.empty());
}

}  // namespace
}  // namespace caltwin
