#include "tools/commands/api/bench_store.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "sim/base/text_file.h"
#include "tools/commands/api/bench_json.h"
#include "tools/commands/api/put_aside.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostResults = 60;
constexpr std::size_t kMostWithReadings = 12;

Json SettingsTree(const std::optional<Settings>& settings) {
  return settings ? ToJson(*settings) : Json();
}

std::optional<Settings> SettingsIn(const Json& tree) {
  return tree.is_null() ? std::nullopt : std::optional(SettingsOf(tree));
}

void WriteTree(const fs::path& file, const Json& tree) {
  try {
    const std::string text =
        tree.dump(1, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
    WriteDurably(file, text + "\n");
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
}

// The tree in a file, by `read`; a default where there is none.
template <typename Value, typename ReadValue>
Value ReadTree(const fs::path& file, std::string* note, const ReadValue& read) {
  std::error_code error;
  if (file.empty() || !fs::exists(file, error)) return {};
  try {
    return read(Json::parse(ReadTextFile(file, kLargestData_bytes)));
  } catch (const std::exception&) {
    *note = PutAside(file);
    return {};
  }
}

fs::path BesideFor(const fs::path& file) {
  return file.empty() ? fs::path() : fs::path(file).replace_extension(".job.json");
}

}  // namespace

void BenchKept::AddResult(const Json& job) {
  results.push_back(job);
  readings.push_back(job);
  results.back().erase("readings");
  results.back().erase("said");
  if (readings.size() > kMostWithReadings) readings.erase(readings.begin());
  if (results.size() > kMostResults) results.erase(results.begin());
}

BenchStore::BenchStore(fs::path file)
    : file_(std::move(file)), job_file_(BesideFor(file_)) {}

BenchKept BenchStore::Read(std::string* note) const {
  return ReadTree<BenchKept>(file_, note, [](const Json& tree) {
    return BenchKept{.last_job = tree.at("last_job").get<int>(),
                     .version = tree.at("version").get<int>(),
                     .entries = tree.at("entries"),
                     .results = tree.at("results"),
                     .readings = tree.at("readings"),
                     .settings = SettingsIn(tree.at("settings")),
                     .settings_before = SettingsIn(tree.at("settings_before")),
                     .calibrated_at = tree.at("calibrated_at").get<std::string>()};
  });
}

void BenchStore::Write(const BenchKept& kept) const {
  if (file_.empty()) return;
  WriteTree(file_,
            {{"format", 1},
             {"version", kept.version},
             {"entries", kept.entries},
             {"results", kept.results},
             {"readings", kept.readings},
             {"last_job", kept.last_job},
             {"calibrated_at", kept.calibrated_at},
             {"settings", SettingsTree(kept.settings)},
             {"settings_before", SettingsTree(kept.settings_before)}});
}

std::optional<RunningJob> BenchStore::ReadJob(std::string* note) const {
  return ReadTree<std::optional<RunningJob>>(job_file_, note, [](const Json& tree) {
    RunningJob running{.job = tree.at("job"),
                       .question = tree.at("question"),
                       .applied = tree.at("applied"),
                       .kept_at = tree.at("kept_at").get<std::string>()};
    // What InterruptedJob builds on.
    std::ignore = running.job.at("id").get<int>();
    std::ignore = running.job.at("readings").get_ref<const Json::array_t&>();
    std::ignore = running.applied.get_ref<const Json::array_t&>();
    if (!running.question.is_null()) {
      std::ignore = running.question.at("text").get_ref<const std::string&>();
    }
    return running;
  });
}

void BenchStore::WriteJob(const RunningJob& running) const {
  if (job_file_.empty()) return;
  WriteTree(job_file_,
            {{"format", 1},
             {"job", running.job},
             {"question", running.question},
             {"applied", running.applied},
             {"kept_at", running.kept_at}});
}

void BenchStore::DropJob() const {
  std::error_code ignored;
  if (!job_file_.empty()) fs::remove(job_file_, ignored);
}

Json ChangesOf(const Settings& before, const Settings& after) {
  Json changes = Json::array();
  for (const auto& [key, unit, member] :
       {std::tuple{"steps_per_mm", "1/mm", &Settings::steps_per_mm},
        std::tuple{"backlash_mm", "mm", &Settings::backlash_mm},
        std::tuple{"probe_deflection_mm", "mm", &Settings::probe_deflection_mm}}) {
    for (const Axis axis : kAxes) {
      const double from = (before.*member)[Index(axis)];
      const double to = (after.*member)[Index(axis)];
      if (from == to) continue;
      changes.push_back({{"name", fmt::format("{}.{}", key, Name(axis))},
                         {"unit", unit},
                         {"iteration", 1},
                         {"before", from},
                         {"after", to},
                         {"verdict", "applied"},
                         {"message", ""}});
    }
  }
  return changes;
}

Json InterruptedJob(const RunningJob& running,
                    const std::optional<Settings>& kept,
                    const std::optional<Settings>& now) {
  Json messages = {
      "the server ended during it: what was read and applied until then is here; begin "
      "it anew"};
  if (!running.question.is_null()) {
    messages.push_back("it stood at the question: " +
                       running.question["text"].get<std::string>());
  }
  if (kept && now) {
    // A machine goes on without the server: what was off for a measurement stays off.
    for (const Json& one : ChangesOf(*kept, *now)) {
      messages.push_back(fmt::format("{} was {:.6g} and is now {:.6g}",
                                     one["name"].get<std::string>(),
                                     one["before"].get<double>(),
                                     one["after"].get<double>()));
    }
  }
  Json job = running.job;
  job["result"] = {{"ending", "interrupted"},
                   {"estimates", Json::array()},
                   {"steps", running.applied},
                   {"messages", std::move(messages)},
                   {"touches", job["readings"].size()}};
  job["ended_at"] = running.kept_at;
  job["question"] = running.question;
  job["settings_now"] = SettingsTree(now);
  return job;
}

}  // namespace caltwin
