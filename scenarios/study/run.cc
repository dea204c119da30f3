#include "scenarios/study/run.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <malloc.h>

#include "scenarios/interrupt.h"

namespace caltwin {
namespace {

// Work is handed out in the order of RunIndex.
class Todo {
 public:
  Todo(const Study& study, const Shard& shard, const DoneIndices& done)
      : num_cases_(static_cast<std::int64_t>(study.cases.size())),
        all_(shard.NumOf(study.trials) * num_cases_),
        shard_(shard),
        done_(done) {}

  std::optional<std::pair<std::int64_t, std::size_t>> Next() {
    const std::scoped_lock lock(mutex_);
    while (next_ < all_ && done_.Has(next_)) ++next_;
    if (next_ >= all_) return std::nullopt;
    const std::int64_t index = next_++;
    return std::pair{shard_.index + (index / num_cases_) * shard_.count,
                     static_cast<std::size_t>(index % num_cases_)};
  }

  std::int64_t all() const { return all_; }
  std::int64_t done_before() const { return done_.count(); }

 private:
  std::int64_t num_cases_, all_;
  Shard shard_;
  DoneIndices done_;
  std::int64_t next_ = 0;
  std::mutex mutex_{};
};

TrialResult Perform(const Study& study, std::int64_t trial, std::size_t of_case) {
  try {
    return KeptOf(RunTrial(study, of_case, trial), of_case, trial);
  } catch (const std::exception& error) {
    return {.trial = trial,
            .of_case = of_case,
            .status = TrialResult::kFailed,
            .message = error.what()};
  }
}

// What one trial frees the next one needs: handing it back to the system in between
// and asking for it again is an eighth of the time.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kMost_bytes = 64 << 20;
  mallopt(M_TRIM_THRESHOLD, kMost_bytes);
  mallopt(M_MMAP_THRESHOLD, kMost_bytes);
#endif
}

class Pool {
 public:
  Pool(const Study& study,
       const Shard& shard,
       const DoneIndices& done,
       const std::function<void(const TrialResult&)>& keep)
      : study_(study), keep_(keep), todo_(study, shard, done) {}

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
    const std::scoped_lock lock(keep_mutex_);
    if (is_stopped_) return;
    try {
      keep_(result);
      ++performed_;
    } catch (const std::exception&) {
      fault_ = std::current_exception();
      is_stopped_ = true;
    }
  }

  const Study& study_;
  const std::function<void(const TrialResult&)>& keep_;
  Todo todo_;
  std::mutex mutex_{}, keep_mutex_{};
  std::condition_variable ended_{};
  int working_ = 0;
  std::atomic<std::int64_t> performed_ = 0;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr fault_{};
};

}  // namespace

std::int64_t RunIndex(const Study& study,
                      const Shard& shard,
                      std::int64_t trial,
                      std::size_t of_case) {
  const std::int64_t own = (trial - shard.index) / shard.count;
  return own * static_cast<std::int64_t>(study.cases.size()) +
         static_cast<std::int64_t>(of_case);
}

StudyProgress RunTrials(const Study& study,
                        const StudyOptions& options,
                        const DoneIndices& done,
                        const std::function<void(const TrialResult&)>& keep) {
  KeepFreedMemory();
  return Pool(study, options.shard, done, keep).Run(options);
}

StudyProgress RunStudy(const Study& study,
                       const StudyOptions& options,
                       StudyStore* store) {
  DoneIndices done;
  for (const auto& [trial, of_case] : store->Done()) {
    done.Add(RunIndex(study, options.shard, trial, of_case));
  }
  return RunTrials(
      study, options, done, [store](const TrialResult& result) { store->Add(result); });
}

}  // namespace caltwin
