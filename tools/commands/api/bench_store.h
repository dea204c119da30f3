#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "sim/machine/machine.h"

namespace caltwin {

/// What a bench knows from one server to the next.
struct BenchKept {
  int last_job = 0;
  int version = 0;  ///< Of the entries.
  nlohmann::ordered_json entries = nlohmann::ordered_json::object();
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  /// The last results with what was said and read.
  nlohmann::ordered_json readings = nlohmann::ordered_json::array();
  /// Applied and in force; what a procedure sets for the time of a measurement is not
  /// among them.
  std::optional<Settings> settings{};
  std::optional<Settings> settings_before{};  ///< Before the first trial.
  std::string calibrated_at{};

  /// A job that ended is the last of the results.
  void AddResult(const nlohmann::ordered_json& job);
};

/// A job at work as it is kept, so that a server that ends during it loses nothing.
struct RunningJob {
  nlohmann::ordered_json job = nullptr;       ///< With what was said and read so far.
  nlohmann::ordered_json question = nullptr;  ///< That it stands at.
  nlohmann::ordered_json applied = nlohmann::ordered_json::array();  ///< Steps.
  std::string kept_at{};
};

/// Two files: what is kept, and beside it the job at work (FILE.job.json), which is
/// written often. Each is written beside and renamed, and on the disk when a call
/// returns. What cannot be written is said on stderr: the machine goes on.
class BenchStore {
 public:
  /// @param file  empty: nothing is kept
  explicit BenchStore(std::filesystem::path file);

  /// What the last server kept; a file that holds nothing readable is put aside, which
  /// `note` then says.
  BenchKept Read(std::string* note) const;
  void Write(const BenchKept& kept) const;

  /// nullopt: none was at work when the last server ended.
  std::optional<RunningJob> ReadJob(std::string* note) const;
  void WriteJob(const RunningJob& running) const;
  void DropJob() const;

 private:
  std::filesystem::path file_, job_file_;
};

/// The job as a result: ending "interrupted", what it had applied as its steps, the
/// question it stood at, and what the settings are now.
/// @param kept  the settings that were in force when the last server ended
nlohmann::ordered_json InterruptedJob(const RunningJob& running,
                                      const std::optional<Settings>& kept,
                                      const std::optional<Settings>& now);

/// What differs, as steps that were applied: `steps_per_mm.x` from `before` to `after`.
nlohmann::ordered_json ChangesOf(const Settings& before, const Settings& after);

}  // namespace caltwin
