#include "scenarios/study/linear.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "scenarios/study/aggregate.h"
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

// Trials first .. last - 1.
void Draw(const PlanStudy& plan, std::int64_t first, std::int64_t last, Seen* seen) {
  const auto& unknowns = plan.design().unknowns;
  std::vector<double> about_middle(unknowns.size()), errors(unknowns.size());
  for (std::int64_t trial = first; trial < last; ++trial) {
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

StudySummary SummaryOfSeen(const Study& study, const Seen& seen) {
  CaseSummary summary{.name = study.cases.at(0).Name(),
                      .scenario = study.cases.at(0).scenario.file.string(),
                      .status = {{"fitted", study.trials}},
                      .worst = seen.worst.trials()};
  StreamedQuantiles time_s, rows;
  time_s.Add(study.plan->duration_s());
  rows.Add(static_cast<double>(study.plan->num_rows()));
  summary.machine_time_s = time_s.Summary();
  summary.touches = rows.Summary();
  for (std::size_t i = 0; i < seen.parameters.size(); ++i) {
    const LinearDesign::Unknown& unknown = study.plan->design().unknowns[i];
    summary.parameters.push_back(seen.parameters[i].Summary(unknown.name));
    summary.parameters.back().unit = unknown.unit;
  }
  return {.trials = study.trials, .cases = {summary}};
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

StudySummary RunLinear(const Study& study, const StudyOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const std::size_t unknowns = study.plan->design().unknowns.size();
  std::vector<Seen> seen(static_cast<std::size_t>(options.workers), Seen(unknowns));
  std::atomic<std::int64_t> next = 0, done = 0;
  std::atomic<int> working = options.workers;
  const auto work = [&](Seen* own) {
    for (std::int64_t first = next.fetch_add(kBlock);
         first < study.trials && !InterruptRequested();
         first = next.fetch_add(kBlock)) {
      const std::int64_t last = std::min(first + kBlock, study.trials);
      Draw(*study.plan, first, last, own);
      done += last - first;
    }
    --working;
  };
  std::vector<std::thread> workers;
  for (Seen& own : seen) workers.emplace_back(work, &own);
  while (working > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::chrono::duration<double> spent = Clock::now() - start;
    options.progress({.done = done,
                      .all = study.trials,
                      .per_s = static_cast<double>(done) / spent.count()});
  }
  for (std::thread& worker : workers) worker.join();
  for (std::size_t i = 1; i < seen.size(); ++i) seen[0].Add(seen[i]);
  return SummaryOfSeen(study, seen[0]);
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
