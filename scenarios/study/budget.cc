#include "scenarios/study/budget.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Core>
#include <fmt/format.h>

#include "sim/base/dense.h"

namespace caltwin {
namespace {

constexpr double kBeyondChance = 3;

// Sums of one estimate's errors and of the inputs of the same trials, as moments.
struct Moments {
  std::string unit{};
  std::size_t position = 0;
  double count = 0;
  Eigen::VectorXd sum{};  ///< Inputs, then the error, each less its first value.
  Eigen::MatrixXd square{};
};

// Names of what differs between machines: injected values that vary.
struct Inputs {
  std::vector<std::string> names{};
  std::map<std::string, double> first{};
};

std::vector<Inputs> InputsOf(const Study& study, const StudyStore& store) {
  std::vector<std::map<std::string, std::pair<double, bool>>> seen(study.cases.size());
  store.ForEach([&](const TrialResult& result) {
    for (const ParameterResult& parameter : result.parameters) {
      auto& of_case = seen.at(result.of_case);
      const auto [it, is_new] =
          of_case.try_emplace(parameter.name, parameter.injected, false);
      it->second.second |= it->second.first != parameter.injected;
    }
  });
  std::vector<Inputs> inputs(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (const auto& [name, value] : seen[i]) {
      if (!value.second) continue;
      inputs[i].names.push_back(name);
      inputs[i].first[name] = value.first;
    }
  }
  return inputs;
}

// Every input of one trial, less its first value; false where one is missing.
bool Gather(const TrialResult& result, const Inputs& inputs, Eigen::VectorXd* x) {
  std::map<std::string, double> injected;
  for (const ParameterResult& parameter : result.parameters) {
    injected[parameter.name] = parameter.injected;
  }
  for (std::size_t i = 0; i < inputs.names.size(); ++i) {
    const auto found = injected.find(inputs.names[i]);
    if (found == injected.end()) return false;
    (*x)[static_cast<Eigen::Index>(i)] =
        found->second - inputs.first.at(inputs.names[i]);
  }
  return true;
}

// Of inputs with these correlations, those that the ones before them do not determine:
// an end of travel that is a fixed length from the other is the same input.
std::vector<Eigen::Index> Independent(const Eigen::MatrixXd& among) {
  constexpr double kLeast = 1e-6;  // Of an input's variance, left by the others.
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < among.rows(); ++i) {
    double left = 1;
    if (!kept.empty()) {
      const Eigen::VectorXd to = among(kept, i);
      left -= to.dot(PivotedCholesky(among(kept, kept)).Solve(to));
    }
    if (left > kLeast) kept.push_back(i);
  }
  return kept;
}

Budget Regress(const std::string& name, const Moments& moments, const Inputs& inputs) {
  const Eigen::Index count = moments.sum.size() - 1;
  const double n = moments.count;
  const Eigen::VectorXd mean = moments.sum / n;
  const Eigen::MatrixXd covariance =
      (moments.square - n * mean * mean.transpose()) / (n - 1);
  Budget budget{.name = name,
                .unit = moments.unit,
                .u = std::sqrt(std::max(0.0, covariance(count, count)))};
  // In units of their own spread, so that all are alike.
  const Eigen::VectorXd spread =
      covariance.diagonal().head(count).cwiseSqrt().cwiseMax(1e-300);
  const Eigen::MatrixXd scale = spread.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd all = scale * covariance.topLeftCorner(count, count) * scale;
  const std::vector<Eigen::Index> kept = Independent(all);
  const Eigen::MatrixXd among = all(kept, kept);
  const Eigen::VectorXd with_error =
      Eigen::VectorXd(scale * covariance.col(count).head(count))(kept);
  const PivotedCholesky solver(among);
  const Eigen::VectorXd slopes = solver.Solve(with_error);
  const double rest = std::max(0.0, covariance(count, count) - slopes.dot(with_error));
  const Eigen::MatrixXd inverse = solver.Inverse();
  double told = 0;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double chance = std::sqrt(rest * std::max(0.0, inverse(i, i)) / n);
    if (std::abs(slopes[i]) <= kBeyondChance * chance) continue;
    const double share = slopes[i] * slopes[i] / covariance(count, count);
    told += share;
    budget.lines.push_back({.input = inputs.names[static_cast<std::size_t>(kept[k])],
                            .u = spread[kept[k]],
                            .c = slopes[i] / spread[kept[k]],
                            .contribution = std::abs(slopes[i]),
                            .share = share});
  }
  const double left = std::max(0.0, 1 - told);
  budget.lines.push_back({.contribution = budget.u * std::sqrt(left), .share = left});
  std::ranges::stable_sort(budget.lines, std::ranges::greater{}, &BudgetLine::share);
  return budget;
}

}  // namespace

std::vector<std::vector<Budget>> BudgetsOf(const Study& study,
                                           const StudyStore& store) {
  const std::vector<Inputs> inputs = InputsOf(study, store);
  std::vector<std::map<std::string, Moments>> moments(study.cases.size());
  store.ForEach([&](const TrialResult& result) {
    const Inputs& of_case = inputs.at(result.of_case);
    const auto count = static_cast<Eigen::Index>(of_case.names.size());
    Eigen::VectorXd x(count + 1);
    if (!Gather(result, of_case, &x)) return;
    for (const ParameterResult& parameter : result.parameters) {
      if (!parameter.error) continue;
      auto& all = moments.at(result.of_case);
      const auto [it, is_new] = all.try_emplace(parameter.name);
      Moments& own = it->second;
      if (is_new) {
        own.unit = parameter.unit;
        own.position = all.size();
        own.sum = Eigen::VectorXd::Zero(count + 1);
        own.square = Eigen::MatrixXd::Zero(count + 1, count + 1);
      }
      x[count] = *parameter.error;
      ++own.count;
      own.sum += x;
      own.square += x * x.transpose();
    }
  });
  std::vector<std::vector<Budget>> budgets(study.cases.size());
  for (std::size_t i = 0; i < moments.size(); ++i) {
    std::vector<std::pair<std::size_t, Budget>> ordered;
    for (const auto& [name, of_parameter] : moments[i]) {
      // As many trials as would tell each slope.
      if (of_parameter.count < 10.0 * static_cast<double>(of_parameter.sum.size())) {
        continue;
      }
      Budget budget = Regress(name, of_parameter, inputs[i]);
      if (!(budget.u > 0)) continue;  // Never in error: nothing to take apart.
      ordered.emplace_back(of_parameter.position, std::move(budget));
    }
    std::ranges::sort(ordered, {}, [](const auto& one) { return one.first; });
    for (auto& [position, budget] : ordered) budgets[i].push_back(std::move(budget));
  }
  return budgets;
}

std::string BudgetText(const std::string& of, const std::vector<Budget>& budgets) {
  if (budgets.empty()) return "";
  std::string text = fmt::format(
      "\nBudget of {}: where errors come from (contribution, share of the variance)\n",
      of);
  for (const Budget& budget : budgets) {
    text += fmt::format("  {:<28} {:.3g} {}:", budget.name, budget.u, budget.unit);
    for (const BudgetLine& line : budget.lines) {
      constexpr double kPercent = 100;
      text += fmt::format(" {} {:.2g} ({:.0f} %)",
                          line.input.empty() ? "readings and all else" : line.input,
                          line.contribution,
                          kPercent * line.share);
    }
    text += "\n";
  }
  return text;
}

}  // namespace caltwin
