#include "scenarios/study/adaptive.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "scenarios/study/summary.h"

namespace caltwin {
namespace {

// The errors told by a range of trials, by "case: parameter".
std::map<std::string, std::vector<double>> ErrorsOf(const Study& study,
                                                    const StudyStore& store,
                                                    std::int64_t first,
                                                    std::int64_t last) {
  std::map<std::string, std::vector<double>> errors;
  store.ForEach(
      [&](const TrialResult& result) {
        const std::string of =
            study.cases.size() > 1 ? study.cases[result.of_case].Name() + ": " : "";
        for (const ParameterResult& parameter : result.parameters) {
          if (parameter.error) errors[of + parameter.name].push_back(*parameter.error);
        }
      },
      first,
      last);
  return errors;
}

}  // namespace

double NumericalTolerance(double u, int digits) {
  if (!(u > 0)) return 0;
  double exponent = std::floor(std::log10(u)) - (digits - 1);
  // 9.96 with two digits is 10: one digit more in front.
  if (std::round(u / std::pow(10, exponent)) >= std::pow(10, digits)) ++exponent;
  return std::pow(10, exponent) / 2;
}

void AdaptiveStop::AddBatch(const std::map<std::string, std::vector<double>>& values) {
  ++batches_;
  for (const auto& [name, of_batch] : values) {
    if (of_batch.size() < 2) continue;
    const Quantiles quantiles = QuantilesOf(of_batch);
    by_quantity_[name].push_back(
        {quantiles.mean, quantiles.sd, quantiles.q025, quantiles.q975});
  }
}

std::map<std::string, Settling> AdaptiveStop::State() const {
  std::map<std::string, Settling> state;
  for (const auto& [name, batches] : by_quantity_) {
    if (batches.size() != batches_ || batches_ < 2) continue;
    const auto h = static_cast<double>(batches.size());
    Settling& settling = state[name];
    Batch mean{};
    for (std::size_t i = 0; i < mean.size(); ++i) {
      double square = 0;
      for (const Batch& batch : batches) mean[i] += batch[i] / h;
      for (const Batch& batch : batches) square += std::pow(batch[i] - mean[i], 2);
      settling.twice_sd =
          std::max(settling.twice_sd, 2 * std::sqrt(square / (h * (h - 1))));
    }
    settling.y = mean[0];
    settling.u = mean[1];
    settling.low = mean[2];
    settling.high = mean[3];
    settling.delta = NumericalTolerance(settling.u, digits_);
  }
  return state;
}

bool AdaptiveStop::IsSettled() const {
  if (batches_ < 2) return false;
  const auto state = State();
  return !state.empty() && std::ranges::all_of(state, [](const auto& one) {
    return one.second.IsSettled();
  });
}

StudyProgress RunAdaptive(Study* study,
                          const StudyOptions& options,
                          StudyStore* store,
                          AdaptiveStop* stop) {
  StudyProgress progress;
  for (std::int64_t first = 0; !stop->IsSettled() && first < study->most_trials;
       first += kAdaptiveBatch) {
    study->trials = first + kAdaptiveBatch;
    progress = RunStudy(*study, options, store);
    if (InterruptRequested()) break;
    stop->AddBatch(ErrorsOf(*study, *store, first, study->trials));
  }
  return progress;
}

std::string SettlingText(const AdaptiveStop& stop) {
  std::string text = fmt::format(
      "\nAdaptive Monte Carlo (JCGM 101, 7.9): {}\n  {:<34} {:>10} {:>10} {:>11} "
      "{:>11} "
      "{:>9} {:>9}\n",
      stop.IsSettled() ? "settled" : "not settled within its limit",
      "error of",
      "y",
      "u(y)",
      "2.5 %",
      "97.5 %",
      "2 sd",
      "delta");
  for (const auto& [name, one] : stop.State()) {
    text += fmt::format(
        "  {:<34} {:>10.2g} {:>10.3g} {:>11.4g} {:>11.4g} {:>9.2g} {:>9.2g}\n",
        name,
        one.y,
        one.u,
        one.low,
        one.high,
        one.twice_sd,
        one.delta);
  }
  return text;
}

}  // namespace caltwin
