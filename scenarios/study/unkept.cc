#include "scenarios/study/unkept.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/study/linear.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPartFile = "aggregates.json";
constexpr int kPartFormat = 1;
constexpr std::size_t kLargestPart_bytes = 1'000'000'000;

// Throws what nlohmann does, or std::invalid_argument, where it is no part.
StudyPart PartOfJson(const nlohmann::json& json, std::size_t num_cases) {
  if (json.at("format") != kPartFormat || json.at("cases").size() != num_cases) {
    throw std::invalid_argument("another format");
  }
  StudyPart part{.shard = ReadShard(json.at("shard").get<std::string>())};
  for (const nlohmann::json& one : json.at("cases")) {
    part.aggregates.push_back(Aggregate::OfJson(one));
  }
  return part;
}

void Count(const Study& study,
           const Shard& shard,
           const TrialResult& result,
           HalfDone* half) {
  half->aggregates.at(result.of_case).Add(result);
  half->done.Add(RunIndex(study, shard, result.trial, result.of_case));
}

HalfDone ReadHalfDone(const std::string& text, const Study& study) {
  try {
    return HalfDone::OfText(text);
  } catch (const nlohmann::json::exception&) {
  } catch (const std::invalid_argument&) {
  }
  throw InputError({.file = study.file.string()},
                   "was left unfinished in a way that cannot be gone on with",
                   "begin it in another folder with --out");
}

// What was folded, and the runs since.
HalfDone BegunIn(const Study& study, const Shard& shard, const StudyStore* store) {
  HalfDone half;
  const auto folded = store == nullptr ? std::nullopt : store->Folded();
  if (folded) {
    half = ReadHalfDone(*folded, study);
  } else if (!study.is_linear) {
    half.aggregates.assign(study.cases.size(), Aggregate(study.plan != nullptr));
  }
  if (store == nullptr) return half;
  store->ForEach(
      [&](const TrialResult& result) { Count(study, shard, result, &half); });
  return half;
}

// What a linear design knows of every trial alike.
void AddPlan(const PlanStudy& plan, CaseSummary* summary) {
  StreamedQuantiles time_s, rows;
  time_s.Add(plan.duration_s());
  rows.Add(static_cast<double>(plan.num_rows()));
  summary->machine_time_s = time_s.Summary();
  summary->touches = rows.Summary();
}

}  // namespace

Aggregates RunUnkept(const Study& study,
                     const StudyOptions& options,
                     StudyStore* store) {
  HalfDone half = BegunIn(study, options.shard, store);
  if (study.is_linear) {
    const auto save = [&](const HalfDone& now) {
      if (store != nullptr) store->Fold(now.Text());
    };
    RunLinear(study, options, save, &half);
    return half.aggregates;
  }
  std::int64_t unfolded = 0;
  RunTrials(study, options, half.done, [&](const TrialResult& result) {
    if (store != nullptr) store->Add(result);
    Count(study, options.shard, result, &half);
    if (store == nullptr || ++unfolded < StudyStore::kMostUnfolded) return;
    store->Fold(half.Text());
    unfolded = 0;
  });
  return half.aggregates;
}

StudySummary SummaryOf(const Study& study, const Aggregates& aggregates) {
  StudySummary summary;
  for (std::size_t i = 0; i < aggregates.size(); ++i) {
    const std::int64_t trials = aggregates[i].trials();
    summary.trials = i == 0 ? trials : std::min(summary.trials, trials);
    summary.cases.push_back(aggregates[i].Summary(study.cases.at(i)));
    if (study.is_linear) AddPlan(*study.plan, &summary.cases.back());
  }
  return summary;
}

void WritePart(const Study& study,
               const Shard& shard,
               const Aggregates& aggregates,
               const fs::path& folder) {
  nlohmann::json cases = nlohmann::json::array();
  for (const Aggregate& one : aggregates) cases.push_back(one.ToJson());
  const nlohmann::json part{{"format", kPartFormat},
                            {"fingerprint", study.Fingerprint()},
                            {"shard", shard.Text()},
                            {"cases", cases}};
  WriteTextFile(folder / kPartFile, part.dump() + "\n");
}

std::optional<StudyPart> ReadPart(const Study& study, const fs::path& folder) {
  const fs::path file = folder / kPartFile;
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const auto json = nlohmann::json::parse(ReadTextFile(file, kLargestPart_bytes),
                                          nullptr,
                                          /*allow_exceptions=*/false);
  try {
    if (json.at("fingerprint") == study.Fingerprint()) {
      return PartOfJson(json, study.cases.size());
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError({.file = file.string()},
                     "is no part of a study, or not all of it",
                     "run the part again, with another --out");
  } catch (const std::invalid_argument&) {
    throw InputError({.file = file.string()},
                     "is no part of a study as this program writes them",
                     "run the part again, with another --out");
  }
  throw InputError(
      {.file = file.string()},
      "is of another study, or of this one before its files or the program changed",
      "choose another folder with --out");
}

Aggregates MergeUnkept(const Study& study, const std::vector<fs::path>& folders) {
  Aggregates whole(study.cases.size());
  std::set<std::int64_t> added;
  std::optional<std::int64_t> count;
  for (const fs::path& folder : folders) {
    const auto part = ReadPart(study, folder);
    if (!part) {
      throw InputError({.file = (folder / kPartFile).string()},
                       "is not there",
                       "name the --out folders of the study's parts");
    }
    if (count.value_or(part->shard.count) != part->shard.count) {
      throw InputError(
          {.file = folder.string()},
          fmt::format(
              "holds part {}, another folder one of {}", part->shard.Text(), *count),
          "a study that keeps no trials is put together of parts I/N with "
          "the same N");
    }
    count = part->shard.count;
    if (!added.insert(part->shard.index).second) continue;
    for (std::size_t i = 0; i < whole.size(); ++i) whole[i].Add(part->aggregates[i]);
  }
  for (Shard shard{.count = count.value_or(1)}; shard.index < shard.count;
       ++shard.index) {
    if (added.contains(shard.index)) continue;
    throw InputError({.file = study.file.string()},
                     fmt::format("part {} is in none of these folders", shard.Text()),
                     "name the folder of every part, each run to its end");
  }
  return whole;
}

}  // namespace caltwin
