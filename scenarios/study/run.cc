#include "scenarios/study/run.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "scenarios/interrupt.h"

namespace caltwin {
namespace {

// Work is handed out in the order of trials, a trial's cases one after the other.
class Todo {
 public:
  Todo(const Study& study, const StudyStore& store)
      : num_cases_(study.cases.size()),
        all_(study.trials * static_cast<std::int64_t>(study.cases.size())),
        done_(store.Done()) {}

  std::optional<std::pair<std::int64_t, std::size_t>> Next() {
    const std::scoped_lock lock(mutex_);
    while (next_ < all_) {
      const auto cases = static_cast<std::int64_t>(num_cases_);
      const std::pair<std::int64_t, std::size_t> task{
          next_ / cases, static_cast<std::size_t>(next_ % cases)};
      ++next_;
      if (!done_.contains(task)) return task;
    }
    return std::nullopt;
  }

  std::int64_t all() const { return all_; }
  std::int64_t done_before() const { return static_cast<std::int64_t>(done_.size()); }

 private:
  std::size_t num_cases_;
  std::int64_t all_;
  std::set<std::pair<std::int64_t, std::size_t>> done_;
  std::int64_t next_ = 0;
  std::mutex mutex_{};
};

TrialResult Perform(const Study& study, std::int64_t trial, std::size_t of_case) {
  try {
    return KeptOf(RunTrial(study, of_case, trial), of_case, trial);
  } catch (const std::exception& error) {
    return {.trial = trial,
            .of_case = of_case,
            .status = "failed",
            .message = error.what()};
  }
}

class Pool {
 public:
  Pool(const Study& study, StudyStore* store)
      : study_(study), store_(store), todo_(study, *store) {}

  StudyProgress Run(const StudyOptions& options) {
    using Clock = std::chrono::steady_clock;
    constexpr auto kBetween = std::chrono::milliseconds(200);
    const auto start = Clock::now();
    const auto progress = [&] {
      const std::chrono::duration<double> spent = Clock::now() - start;
      const std::int64_t here = performed_;
      return StudyProgress{
          .done = todo_.done_before() + here,
          .all = todo_.all(),
          .per_s = spent.count() > 0 ? static_cast<double>(here) / spent.count() : 0};
    };
    working_ = options.workers;
    std::vector<std::thread> workers;
    for (int i = 0; i < options.workers; ++i) {
      workers.emplace_back([this] { Work(); });
    }
    {
      std::unique_lock lock(mutex_);
      while (!ended_.wait_for(lock, kBetween, [this] { return working_ == 0; })) {
        options.progress(progress());
      }
    }
    for (std::thread& worker : workers) worker.join();
    if (fault_) std::rethrow_exception(fault_);
    options.progress(progress());
    return progress();
  }

 private:
  void Work() {
    while (!InterruptRequested() && !is_stopped_) {
      const auto task = todo_.Next();
      if (!task) break;
      const TrialResult result = Perform(study_, task->first, task->second);
      // A run that was cut short is no result.
      if (InterruptRequested()) break;
      Keep(result);
    }
    const std::scoped_lock lock(mutex_);
    --working_;
    ended_.notify_all();
  }

  void Keep(const TrialResult& result) {
    const std::scoped_lock lock(store_mutex_);
    if (is_stopped_) return;
    try {
      store_->Add(result);
      ++performed_;
    } catch (const std::exception&) {
      fault_ = std::current_exception();
      is_stopped_ = true;
    }
  }

  const Study& study_;
  StudyStore* store_;
  Todo todo_;
  std::mutex mutex_{}, store_mutex_{};
  std::condition_variable ended_{};
  int working_ = 0;
  std::atomic<std::int64_t> performed_ = 0;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr fault_{};
};

}  // namespace

StudyProgress RunStudy(const Study& study,
                       const StudyOptions& options,
                       StudyStore* store) {
  return Pool(study, store).Run(options);
}

}  // namespace caltwin
