#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/study/folder_lock.h"
#include "scenarios/study/study.h"

namespace caltwin {

/// `study.sqlite` of a study: every trial is written at once, in a transaction of its
/// own, so that a program that is killed loses only the trials on their way. Tables
/// (docs/studies.md): study, cases, parameters, trials, results. Of a study that keeps
/// no trials `unfinished.sqlite`, the same until it is done: what stands for trials
/// that were folded away, and those since.
class StudyStore {
 public:
  /// Opens or begins it in `folder`, which is made; nobody else may meanwhile. Where
  /// the folder is read-only what is there can be read. Throws InputError where the
  /// folder cannot be written, its disk has no room for all trials, the file is no
  /// study, it is another one than `study` or another part of it, or it holds trials
  /// and `may_resume` is false.
  StudyStore(const std::filesystem::path& folder,
             const Study& study,
             bool may_resume,
             const Shard& shard = {});
  ~StudyStore();
  /// Takes away what the constructor made, where no trial was kept since.
  void DiscardIfEmpty();
  /// Takes away the file, whatever it holds; nothing else can be done afterwards.
  void Discard();
  /// What is there, whichever part of `study` it is; throws InputError where it is
  /// none.
  static std::unique_ptr<StudyStore> OpenPart(const std::filesystem::path& folder,
                                              const Study& study);
  /// Which part it is, "2/5"; of a whole "1/1".
  std::string ShardText() const;
  StudyStore(const StudyStore&) = delete;
  StudyStore& operator=(const StudyStore&) = delete;

  /// Throws InputError where the disk is full: what was done stays.
  void Add(const TrialResult& result);

  /// @name For a study that keeps no trials
  /// Takes `state` in place of all trials that it holds, at once or not at all. Throws
  /// InputError where the disk is full: then nothing has changed.
  void Fold(const std::string& state);
  /// What Fold took last.
  std::optional<std::string> Folded() const;
  /// Trials after which they are to be folded.
  static constexpr std::int64_t kMostUnfolded = 1000;
  static constexpr const char* kUnfinished = "unfinished.sqlite";

  /// @name Throw InputError where the file cannot be read
  /// (trial, case) of all that it holds.
  std::set<std::pair<std::int64_t, std::size_t>> Done() const;
  /// Every result by trial, then by case; of the trials from `first` to before `last`.
  void ForEach(const std::function<void(const TrialResult&)>& look,
               std::int64_t first = 0,
               std::int64_t last = std::numeric_limits<std::int64_t>::max()) const;

 private:
  struct Parts;
  explicit StudyStore(std::filesystem::path file);
  void RequireSameStudy(const Study& study) const;

  std::filesystem::path file_;
  bool is_new_ = false, has_made_folder_ = false;
  FolderLock lock_{};
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
