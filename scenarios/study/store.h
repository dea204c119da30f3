#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/study/study.h"

namespace caltwin {

/// `study.sqlite` of a study: every trial is written at once, in a transaction of its
/// own, so that a program that is killed loses only the trials on their way. Tables
/// (docs/studies.md): study, cases, parameters, trials, results.
class StudyStore {
 public:
  /// Opens or begins it in `folder`, which is made. Throws InputError where the folder
  /// cannot be written, its disk is full, the file is no study, it is another one than
  /// `study`, or it holds trials and `may_resume` is false.
  StudyStore(const std::filesystem::path& folder, const Study& study, bool may_resume);
  ~StudyStore();
  StudyStore(const StudyStore&) = delete;
  StudyStore& operator=(const StudyStore&) = delete;

  /// Throws InputError where the disk is full: what was done stays.
  void Add(const TrialResult& result);

  /// (trial, case) of all that it holds.
  std::set<std::pair<std::int64_t, std::size_t>> Done() const;
  /// Every result by trial, then by case.
  void ForEach(const std::function<void(const TrialResult&)>& look) const;

 private:
  struct Parts;
  std::filesystem::path file_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
