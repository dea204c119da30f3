#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "scenarios/study/aggregate.h"
#include "scenarios/study/run.h"

namespace caltwin {

/// What a study that keeps no trials knows of its contenders, in their order.
using Aggregates = std::vector<Aggregate>;

/// Runs the trials of the shard, of whatever fidelity, and keeps none. The same for any
/// number of workers.
Aggregates RunUnkept(const Study& study, const StudyOptions& options);

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
