#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "scenarios/kind_scenario.h"
#include "tools/commands/api/bench_settings.h"
#include "tools/commands/api/bench_store.h"
#include "tools/commands/api/client_operator.h"
#include "tools/commands/api/seat.h"
#include "tools/commands/desk.h"
#include "tools/server/events.h"
#include "tools/server/routes.h"

namespace caltwin {

/// A machine on its bench, led through procedures by a client: `/api/bench/...`.
///
/// A procedure runs in a thread of its own, asks the client (ClientOperator) and tells
/// what it does as events. What the client entered, every reading and result, the
/// settings applied and those from before the first trial are kept in a file, and the
/// job at work beside it (BenchStore): a page that is loaded again, or a server that
/// was killed, goes on from there; a job that was at work then is a result that says
/// so.
class BenchApi {
 public:
  struct Options {
    std::filesystem::path store{};  ///< Empty: nothing is kept.
    bool is_twin = true;
  };

  /// `seat` and `events` are borrowed.
  BenchApi(std::unique_ptr<Desk> desk,
           const Options& options,
           OperatorSeat* seat,
           EventTopic* events);
  BenchApi(const BenchApi&) = delete;
  BenchApi& operator=(const BenchApi&) = delete;
  /// Aborts what is at work.
  ~BenchApi();

  void AddTo(Routes* routes);
  const std::string& note() const { return note_; }

 private:
  using Json = nlohmann::ordered_json;

  HttpResponse Status() const;
  HttpResponse SetSession(const HttpRequest& request);
  HttpResponse Begin(const HttpRequest& request);
  HttpResponse Answer(const HttpRequest& request);
  HttpResponse Abort();
  /// M112 past whatever waits, where the wire can; then as Abort.
  HttpResponse EmergencyStop();
  HttpResponse Restore(const HttpRequest& request);
  /// Writes what a person worked out by hand.
  HttpResponse SetSettings(const HttpRequest& request);
  HttpResponse UserVars() const;

  /// Runs `work` as the one job there is; throws Problem 409 where one is at work.
  HttpResponse StartJob(const HttpRequest& request,
                        const std::string& name,
                        const Json& asked,
                        PreparedProcedure work);
  void Work(const PreparedProcedure& work, OperatorSeat::Held seat);
  CalibrationStep StepOf(const std::string& name, const Json& options) const;
  /// When a question is put or answered, in the procedure's thread.
  void Asked();
  /// After each line of a procedure, likewise.
  void Sent(std::string_view line);
  void TellReadings();
  void TellSent(bool at_once);
  /// What is in force; nullopt where that cannot be read.
  std::optional<Settings> SettingsNow();
  /// After a line that writes a setting.
  void KeepApplied();
  void ReadSettings();
  /// Puts back what the firmware believed when the last server ended.
  void ResumeSettings();
  Json Tree() const;
  /// Tells all listeners what stands now: of two threads the later one tells the newer
  /// state. Returns what was told.
  Json Tell();
  void ReadStore();
  /// A job during which the last server ended becomes a result.
  void TakeUpInterrupted(const std::optional<Settings>& kept);
  int last_ended_job() const;
  void KeepStore();
  /// The job at work as it stands.
  void KeepJob();

  std::unique_ptr<Desk> desk_;
  Options options_;
  OperatorSeat* seat_;
  EventTopic* events_;
  BenchStore store_;
  std::unique_ptr<KindScenario> kind_;
  std::unique_ptr<ClientOperator> person_;
  std::unique_ptr<AbortableLink> link_;
  std::string note_{};
  std::thread thread_{};
  std::jthread stopping_{};
  std::size_t told_ = 0;  ///< Readings, in the job's thread, as what follows.
  SettingsWatch watch_{};
  std::deque<std::string> sent_{};  ///< The newest lines.
  std::chrono::steady_clock::time_point sent_told_{};
  std::chrono::steady_clock::time_point job_kept_{};
  std::atomic<bool> is_halted_ = false;   ///< By M112: it answers nothing more.
  std::atomic<bool> is_stopped_ = false;  ///< In an emergency, and not homed since.

  std::mutex writing_{};
  std::mutex telling_{};
  mutable std::mutex mutex_{};  ///< Of what follows.
  std::string state_ = "idle";  ///< idle, working, asking
  Json job_ = nullptr;
  Json applied_ = Json::array();  ///< By the job, as steps.
  BenchKept kept_{};
  std::optional<Settings> settings_{};  ///< In force now.
};

}  // namespace caltwin
