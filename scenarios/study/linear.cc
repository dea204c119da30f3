#include "scenarios/study/linear.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
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

// Blocks of trials, taken by workers that each sum up for themselves and hand over what
// they have a few times a second.
class LinearRun {
 public:
  LinearRun(const Study& study, const Shard& shard, HalfDone* half)
      : plan_(*study.plan),
        shard_(shard),
        all_(shard.NumOf(study.trials)),
        before_(half->done),
        half_(*half) {
    if (half_.aggregates.empty()) half_.aggregates = {AggregateOf(plan_, 0, Nothing())};
    num_done_ = half_.aggregates.front().trials();
  }

  void Run(const StudyOptions& options,
           const std::function<void(const HalfDone&)>& save) {
    const auto start = Clock::now();
    const std::int64_t num_before = num_done_;
    auto saved = start;
    working_ = options.workers;
    std::vector<std::thread> workers;
    for (int i = 0; i < options.workers; ++i) {
      workers.emplace_back([this] { Work(); });
    }
    while (working_ > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      const auto now = Clock::now();
      const std::chrono::duration<double> spent = now - start;
      const auto here = static_cast<double>(num_done_ - num_before);
      options.progress({.done = num_done_, .all = all_, .per_s = here / spent.count()});
      if (now - saved < kBetweenSaves || fault_) continue;
      TrySave(save);
      saved = now;
    }
    for (std::thread& worker : workers) worker.join();
    if (InterruptRequested() && !fault_) TrySave(save);
    if (fault_) std::rethrow_exception(fault_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kBetweenSaves = std::chrono::seconds(1);
  static constexpr auto kBetweenHandovers = std::chrono::milliseconds(250);

  Seen Nothing() const { return Seen(plan_.design().unknowns.size()); }

  // -1: none is left.
  std::int64_t NextBlock() {
    std::int64_t block = next_++;
    while (before_.Has(block)) block = next_++;
    const bool is_to_do =
        block * kBlock < all_ && !InterruptRequested() && !is_stopped_;
    return is_to_do ? block : -1;
  }

  void Work() {
    Seen own = Nothing();
    std::vector<std::int64_t> blocks;
    auto handed = Clock::now();
    for (std::int64_t block = NextBlock(); block >= 0; block = NextBlock()) {
      const std::int64_t last = std::min((block + 1) * kBlock, all_);
      Draw(plan_, shard_, block * kBlock, last, &own);
      blocks.push_back(block);
      num_done_ += last - block * kBlock;
      if (Clock::now() - handed < kBetweenHandovers) continue;
      HandOver(blocks, own);
      blocks.clear();
      own = Nothing();
      handed = Clock::now();
    }
    HandOver(blocks, own);
    --working_;
  }

  void HandOver(const std::vector<std::int64_t>& blocks, const Seen& own) {
    std::int64_t trials = 0;
    for (const std::int64_t block : blocks) {
      trials += std::min((block + 1) * kBlock, all_) - block * kBlock;
    }
    const std::scoped_lock lock(mutex_);
    half_.aggregates.front().Add(AggregateOf(plan_, trials, own));
    for (const std::int64_t block : blocks) half_.done.Add(block);
  }

  void TrySave(const std::function<void(const HalfDone&)>& save) {
    const std::scoped_lock lock(mutex_);
    try {
      save(half_);
    } catch (const std::exception&) {
      fault_ = std::current_exception();
      is_stopped_ = true;
    }
  }

  const PlanStudy& plan_;
  Shard shard_;
  std::int64_t all_;
  const DoneIndices before_;
  HalfDone& half_;
  std::mutex mutex_{};  // Of half_, while workers run.
  std::atomic<std::int64_t> next_ = 0, num_done_ = 0;
  std::atomic<int> working_ = 0;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr fault_{};
};

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

void RunLinear(const Study& study,
               const StudyOptions& options,
               const std::function<void(const HalfDone&)>& save,
               HalfDone* half) {
  LinearRun(study, options.shard, half).Run(options, save);
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
