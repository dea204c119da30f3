#pragma once

#include <cstdint>
#include <functional>

#include "scenarios/study/half_done.h"
#include "scenarios/study/store.h"

namespace caltwin {

/// How far a study is.
struct StudyProgress {
  std::int64_t done = 0, all = 0;  ///< Trials times cases; those of before counted.
  double per_s = 0;                ///< Of this run.
};

struct StudyOptions {
  int workers = 1;
  Shard shard{};  ///< The trials to run.
  /// Called a few times a second, from the thread that called RunStudy.
  std::function<void(const StudyProgress&)> progress = [](const StudyProgress&) {
  };
};

/// Runs of a shard, counted from 0: trial by trial, a trial's cases one after another.
std::int64_t RunIndex(const Study& study,
                      const Shard& shard,
                      std::int64_t trial,
                      std::size_t of_case);

/// Runs every run of the shard that is not in `done`, by RunIndex, calling `keep` with
/// each, one at a time, in whatever order they end. What `keep` throws ends it.
StudyProgress RunTrials(const Study& study,
                        const StudyOptions& options,
                        const DoneIndices& done,
                        const std::function<void(const TrialResult&)>& keep);

/// Runs every trial that `store` does not hold yet, each worker one at a time, each
/// with a machine of its own: results depend on the trial's number alone. A trial that
/// throws is kept with status "failed" and its message. Ends early, with what was done
/// kept, when the person interrupts. Throws InputError where results cannot be kept.
StudyProgress RunStudy(const Study& study,
                       const StudyOptions& options,
                       StudyStore* store);

}  // namespace caltwin
