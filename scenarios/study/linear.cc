#include "scenarios/study/linear.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "sim/base/input_error.h"

namespace caltwin {
namespace {

constexpr std::int64_t kCheckedTrials = 1000;
constexpr std::int64_t kBlock = 8192;  // Trials that a worker takes at a time.
constexpr double kMayDiffer = 0.1;
constexpr double kChanceSigmas = 5;

// What one worker has seen.
struct Seen {
  explicit Seen(std::size_t unknowns) : parameters(unknowns) {}

  void Add(const Seen& other) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      parameters[i].Add(other.parameters[i]);
    }
    worst.Add(other.worst);
  }

  std::vector<StreamedParameter> parameters;
  Worst worst{};
};

// The shard's trials, from its first-th to before its last-th.
void Draw(const PlanStudy& plan,
          const Shard& shard,
          std::int64_t first,
          std::int64_t last,
          Seen* seen) {
  const auto& unknowns = plan.design().unknowns;
  std::vector<double> about_middle(unknowns.size()), errors(unknowns.size());
  for (std::int64_t own = first; own < last; ++own) {
    const std::int64_t trial = shard.index + own * shard.count;
    plan.LinearErrors(trial, about_middle.data(), errors.data());
    double largest_sd = 0;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      if (!unknowns[i].identifiable) {
        seen->parameters[i].Add(std::nullopt, std::nullopt);
        continue;
      }
      seen->parameters[i].Add(errors[i], unknowns[i].sd);
      largest_sd = std::max(largest_sd, std::abs(errors[i]) / unknowns[i].sd);
    }
    seen->worst.Add(largest_sd, trial);
  }
}

Aggregate AggregateOf(const PlanStudy& plan, std::int64_t trials, const Seen& seen) {
  std::vector<std::pair<std::string, StreamedParameter>> parameters;
  for (std::size_t i = 0; i < seen.parameters.size(); ++i) {
    const LinearDesign::Unknown& unknown = plan.design().unknowns[i];
    parameters.emplace_back(unknown.name, seen.parameters[i]);
    parameters.back().second.unit = unknown.unit;
  }
  return {trials, parameters, seen.worst};
}

struct BothWays {
  std::string unit{};
  StreamedQuantiles fast{}, linear{};
};

}  // namespace

LinearCheck CheckLinear(const Study& study, const StudyOptions& options) {
  Study sample = study;
  sample.trials = kCheckedTrials;
  sample.is_linear = false;
  std::vector<std::string> order;
  std::map<std::string, BothWays> both;
  const auto add = [&](const TrialResult& result, bool is_linear) {
    for (const ParameterResult& parameter : result.parameters) {
      if (!parameter.error) continue;
      const auto [it, is_new] = both.try_emplace(parameter.name);
      if (is_new) order.push_back(parameter.name);
      it->second.unit = parameter.unit;
      (is_linear ? it->second.linear : it->second.fast).Add(*parameter.error);
    }
  };
  for (std::int64_t trial = 0; trial < sample.trials; ++trial) {
    add(KeptOf(study.plan->Linear(trial), 0, trial), true);
  }
  StudyOptions whole = options;
  whole.shard = {};
  RunTrials(sample, whole, {}, [&](const TrialResult& result) { add(result, false); });
  LinearCheck check{.trials = sample.trials};
  const double root = std::sqrt(static_cast<double>(sample.trials));
  for (const std::string& name : order) {
    const Quantiles fast = both.at(name).fast.Summary();
    const Quantiles linear = both.at(name).linear.Summary();
    // Both ways have noise of their own.
    const double chance = kChanceSigmas * std::sqrt(2.0) / root;
    const double off = std::abs(fast.mean - linear.mean);
    const bool agrees =
        fast.count == linear.count && off <= (kMayDiffer + chance) * linear.sd &&
        std::abs(fast.sd / linear.sd - 1) <= kMayDiffer + chance / std::sqrt(2.0);
    check.unknowns.push_back({.name = name,
                              .unit = both.at(name).unit,
                              .fast_mean = fast.mean,
                              .fast_sd = fast.sd,
                              .linear_mean = linear.mean,
                              .linear_sd = linear.sd,
                              .agrees = agrees});
  }
  return check;
}

void RequireLinear(const Study& study, const LinearCheck& check) {
  for (const LinearCheck::Unknown& unknown : check.unknowns) {
    if (unknown.agrees) continue;
    throw InputError(
        {.file = study.file.string()},
        fmt::format("linear is not good enough for {}: over {} machines its errors are "
                    "{:.3g} +- {:.3g} {} by the closed forms, {:.3g} +- {:.3g} by the "
                    "linear design",
                    unknown.name,
                    check.trials,
                    unknown.fast_mean,
                    unknown.fast_sd,
                    unknown.unit,
                    unknown.linear_mean,
                    unknown.linear_sd),
        "use `fidelity: fast`");
  }
}

Aggregate RunLinear(const Study& study, const StudyOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const std::size_t unknowns = study.plan->design().unknowns.size();
  const std::int64_t all = options.shard.NumOf(study.trials);
  std::vector<Seen> seen(static_cast<std::size_t>(options.workers), Seen(unknowns));
  std::atomic<std::int64_t> next = 0, done = 0;
  std::atomic<int> working = options.workers;
  const auto work = [&](Seen* own) {
    for (std::int64_t first = next.fetch_add(kBlock);
         first < all && !InterruptRequested();
         first = next.fetch_add(kBlock)) {
      const std::int64_t last = std::min(first + kBlock, all);
      Draw(*study.plan, options.shard, first, last, own);
      done += last - first;
    }
    --working;
  };
  std::vector<std::thread> workers;
  for (Seen& own : seen) workers.emplace_back(work, &own);
  while (working > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::chrono::duration<double> spent = Clock::now() - start;
    options.progress(
        {.done = done, .all = all, .per_s = static_cast<double>(done) / spent.count()});
  }
  for (std::thread& worker : workers) worker.join();
  for (std::size_t i = 1; i < seen.size(); ++i) seen[0].Add(seen[i]);
  return AggregateOf(*study.plan, all, seen[0]);
}

std::string CheckText(const LinearCheck& check) {
  std::string text = fmt::format(
      "\nLinear against the closed forms, errors of {} machines (mean +- sd)\n",
      check.trials);
  for (const LinearCheck::Unknown& unknown : check.unknowns) {
    text += fmt::format(
        "  {:<28} {:<6} fast {:>10.3g} +- {:<9.3g} linear {:>10.3g} +- {:.3g}\n",
        unknown.name,
        unknown.unit,
        unknown.fast_mean,
        unknown.fast_sd,
        unknown.linear_mean,
        unknown.linear_sd);
  }
  return text;
}

}  // namespace caltwin
