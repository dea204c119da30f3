#include "scenarios/study/merge.h"

#include <memory>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

using Done = std::set<std::pair<std::int64_t, std::size_t>>;

// The first run that nobody has done.
void RequireAll(const Study& study,
                const Done& done,
                const std::vector<std::string>& shards) {
  for (std::int64_t trial = 0; trial < study.trials; ++trial) {
    for (std::size_t i = 0; i < study.cases.size(); ++i) {
      if (done.contains({trial, i})) continue;
      throw InputError(
          {.file = study.file.string()},
          fmt::format("trial {} is in none of these folders, which hold {}",
                      trial,
                      fmt::join(shards, ", ")),
          "name the folder of every part, each run to its end");
    }
  }
}

}  // namespace

void MergeParts(const Study& study,
                const std::vector<fs::path>& folders,
                StudyStore* whole) {
  std::vector<std::unique_ptr<StudyStore>> parts;
  std::vector<std::string> shards;
  Done done = whole->Done();
  for (const fs::path& folder : folders) {
    parts.push_back(StudyStore::OpenPart(folder, study));
    shards.push_back("part " + parts.back()->ShardText());
    done.merge(parts.back()->Done());
  }
  RequireAll(study, done, shards);
  Done copied = whole->Done();
  for (const auto& part : parts) {
    part->ForEach([&](const TrialResult& result) {
      if (copied.emplace(result.trial, result.of_case).second) whole->Add(result);
    });
  }
}

}  // namespace caltwin
