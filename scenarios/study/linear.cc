#include "scenarios/study/linear.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

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

// Errors of an unknown over the checked machines: by the closed forms, by the design
// with noise of its own, by the design from the readings of the first, and first minus
// last.
struct BothWays {
  StreamedQuantiles fast{}, linear{}, same_readings{}, difference{};
};

// Whether `fast` and `linear` are the same within what may differ, given the standard
// deviations of chance of the difference of their means and of the ratio of their sd.
bool Agree(const Quantiles& fast,
           const Quantiles& linear,
           double chance_mean,
           double chance_ratio) {
  return fast.count == linear.count &&
         std::abs(fast.mean - linear.mean) <=
             kMayDiffer * linear.sd + kChanceSigmas * chance_mean &&
         std::abs(fast.sd / linear.sd - 1) <= kMayDiffer + kChanceSigmas * chance_ratio;
}

// Of the noise of readings, by how much each of them moves one unknown (`gain`): its sd
// over what it would be if each had a variance of 1, and what chance leaves of that.
struct NoiseRatio {
  double value = 1, chance = 0;
  double told_variance = 0;  // Of the unknown's error by noise, as the design has it.

  // Whether the sd of an error, of that variance in all, is off by too much for it,
  // beyond chance.
  bool Matters(double variance) const {
    const double most =
        value + std::copysign(kChanceSigmas * chance * value, 1 - value);
    const double off = (most - 1) * (value - 1) > 0 ? most * most - 1 : 0;
    return std::abs(std::sqrt(1 + off * told_variance / variance) - 1) > kMayDiffer;
  }
};
NoiseRatio RatioOf(const Eigen::ArrayXd& gain,
                   const Eigen::ArrayXd& variance,
                   double machines) {
  const Eigen::ArrayXd part = gain.square() * variance;
  return {.value = std::sqrt(part.sum() / gain.square().sum()),
          .chance = std::sqrt(part.square().sum() / (2 * machines)) / part.sum(),
          .told_variance = gain.square().sum()};
}

LinearCheck::Unknown Compared(const LinearDesign::Unknown& unknown,
                              const BothWays& both,
                              const NoiseRatio& noise) {
  const Quantiles fast = both.fast.Summary(), linear = both.linear.Summary();
  const Quantiles same = both.same_readings.Summary();
  const Quantiles difference = both.difference.Summary();
  const double root = std::sqrt(static_cast<double>(fast.count));
  // What two jointly normal series leave of chance in the ratio of their sd.
  const double correlation =
      (fast.sd * fast.sd + same.sd * same.sd - difference.sd * difference.sd) /
      (2 * fast.sd * same.sd);
  const double apart = std::sqrt(std::max(0.0, 1 - correlation * correlation));
  return {.name = unknown.name,
          .unit = unknown.unit,
          .fast_mean = fast.mean,
          .fast_sd = fast.sd,
          .linear_mean = linear.mean,
          .linear_sd = linear.sd,
          .difference_mean = difference.mean,
          .difference_sd = difference.sd,
          .noise_ratio = noise.value,
          .agrees = !noise.Matters(linear.sd * linear.sd) &&
                    Agree(fast, linear, std::sqrt(2.0) * linear.sd / root, 1 / root) &&
                    Agree(fast, same, difference.sd / root, apart / root)};
}

}  // namespace

LinearCheck CheckLinear(const Study& study, const StudyOptions& options) {
  const PlanStudy& plan = *study.plan;
  Study sample = study;
  sample.trials = kCheckedTrials;
  sample.is_linear = false;
  const auto& unknowns = plan.design().unknowns;
  std::vector<BothWays> both(unknowns.size());
  StudyOptions whole = options;
  whole.shard = {};
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(plan.design().gain.cols());
  RunTrials(sample, whole, {}, [&](const TrialResult& result) {
    std::vector<double> own(unknowns.size());
    Eigen::VectorXd about_middle(plan.design().bias.cols());
    plan.LinearErrors(result.trial, about_middle.data(), own.data());
    const Eigen::VectorXd noise = plan.NoiseOf(result.trial);
    const Eigen::VectorXd same =
        plan.design().bias * about_middle + plan.design().gain * noise;
    squares += noise.cwiseAbs2();
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      if (unknowns[i].identifiable) both[i].linear.Add(own[i]);
      if (!result.parameters[i].error) continue;
      both[i].fast.Add(*result.parameters[i].error);
      both[i].same_readings.Add(same[static_cast<Eigen::Index>(i)]);
      both[i].difference.Add(*result.parameters[i].error -
                             same[static_cast<Eigen::Index>(i)]);
    }
  });
  LinearCheck check{.trials = sample.trials};
  const auto machines = static_cast<double>(sample.trials);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (!unknowns[i].identifiable && both[i].fast.Summary().count == 0) continue;
    const auto row = static_cast<Eigen::Index>(i);
    const NoiseRatio noise =
        RatioOf(plan.design().gain.row(row), squares / machines, machines);
    check.unknowns.push_back(Compared(unknowns[i], both[i], noise));
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
                    "linear design, of the same readings {:.2g} +- {:.2g} apart, "
                    "noise {:.2f} times what is told",
                    unknown.name,
                    check.trials,
                    unknown.fast_mean,
                    unknown.fast_sd,
                    unknown.unit,
                    unknown.linear_mean,
                    unknown.linear_sd,
                    unknown.difference_mean,
                    unknown.difference_sd,
                    unknown.noise_ratio),
        "use `fidelity: fast`");
  }
}

void RunLinear(const Study& study,
               const StudyOptions& options,
               const std::function<void(const HalfDone&)>& save,
               HalfDone* half) {
  LinearRun(study, options.shard, half).Run(options, save);
}

nlohmann::ordered_json ToJson(const LinearCheck& check) {
  nlohmann::ordered_json unknowns = nlohmann::ordered_json::array();
  for (const LinearCheck::Unknown& unknown : check.unknowns) {
    unknowns.push_back(
        {{"name", unknown.name},
         {"unit", unknown.unit},
         {"fast", {{"mean", unknown.fast_mean}, {"sd", unknown.fast_sd}}},
         {"linear", {{"mean", unknown.linear_mean}, {"sd", unknown.linear_sd}}},
         {"same_readings_apart",
          {{"mean", unknown.difference_mean}, {"sd", unknown.difference_sd}}},
         {"noise_ratio", unknown.noise_ratio},
         {"agrees", unknown.agrees}});
  }
  return {{"format", 1}, {"trials", check.trials}, {"unknowns", unknowns}};
}

std::string CheckText(const LinearCheck& check) {
  std::string text = fmt::format(
      "\nLinear against the closed forms, errors of {} machines (mean +- sd)\n",
      check.trials);
  for (const LinearCheck::Unknown& unknown : check.unknowns) {
    text += fmt::format(
        "  {:<28} {:<6} fast {:>10.3g} +- {:<9.3g} linear {:>10.3g} +- {:<9.3g} of the "
        "same readings {:>8.2g} +- {:<8.2g} apart, noise {:.2f} times what is told\n",
        unknown.name,
        unknown.unit,
        unknown.fast_mean,
        unknown.fast_sd,
        unknown.linear_mean,
        unknown.linear_sd,
        unknown.difference_mean,
        unknown.difference_sd,
        unknown.noise_ratio);
  }
  return text;
}

}  // namespace caltwin
