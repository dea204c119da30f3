#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "scenarios/study/half_done.h"
#include "scenarios/study/run.h"

namespace caltwin {

/// Runs the trials of the shard, of whatever fidelity, and keeps none. The same for any
/// number of workers. Where there is a store it goes on with what that holds, and every
/// run (of a linear study every second's) is kept there until all is done: stopped at
/// any moment, the rest is the same.
Aggregates RunUnkept(const Study& study,
                     const StudyOptions& options,
                     StudyStore* store = nullptr);

/// `summary.json` of them: of parts put together the same as of the whole.
StudySummary SummaryOf(const Study& study, const Aggregates& aggregates);

/// Writes `aggregates.json`, by which a part is put together with others.
void WritePart(const Study& study,
               const Shard& shard,
               const Aggregates& aggregates,
               const std::filesystem::path& folder);

/// A part of a study as it lies in a folder.
struct StudyPart {
  Shard shard{};
  Aggregates aggregates{};
};
/// nullopt where there is none. Throws InputError where it is of another study, or of
/// this one before its files or the program changed, or no such file.
std::optional<StudyPart> ReadPart(const Study& study,
                                  const std::filesystem::path& folder);

/// Parts I/N of all I, in any order; one that is named twice counts once. Throws
/// InputError where a folder holds no part, parts are of unlike N, or some are missing.
Aggregates MergeUnkept(const Study& study,
                       const std::vector<std::filesystem::path>& folders);

}  // namespace caltwin
