// The job at work on a bench, in its own thread, and what is kept of it.
#include <algorithm>
#include <exception>
#include <utility>

#include "calibration/loop/controller.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine_kind.h"
#include "tools/commands/api/bench_api.h"
#include "tools/commands/api/bench_json.h"
#include "tools/commands/api/bench_settings.h"
#include "tools/commands/api/bench_store.h"
#include "tools/commands/api/utc.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostReadings = 2000;    // That a job shows.
constexpr std::chrono::seconds kKeepEvery{1};  // While a job reads.

}  // namespace

HttpResponse BenchApi::StartJob(const HttpRequest& request,
                                const std::string& name,
                                const Json& asked,
                                PreparedProcedure work) {
  auto seat = seat_->Take(request, "running " + name);
  // No client goes on by itself: a person homes first. A stop from here on ends the
  // job.
  if (is_stopped_ && name != "home" && name != "reset") {
    throw Problem(409,
                  "the machine was stopped in an emergency",
                  {{.detail = "nothing moves until it has been homed",
                    .hint = "POST /api/bench/procedures {\"procedure\": \"home\"}; a "
                            "controller that was halted is reset before"}});
  }
  if (thread_.joinable()) thread_.join();
  person_->Begin();
  Json job;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = "working";
    job_ = {{"id", ++kept_.last_job},
            {"procedure", name},
            {"options", asked},
            {"begun_at", UtcNow()},
            {"said", Json::array()},
            {"readings", Json::array()},
            {"result", nullptr}};
    job = job_;
    applied_ = Json::array();
    if (!kept_.settings_before) kept_.settings_before = settings_;
  }
  is_halted_ = false;
  watch_.Begin(/*measures=*/name != "set" && name != "restore");
  KeepStore();
  KeepJob();
  Tell();
  thread_ =
      std::thread([this, work = std::move(work), seat = std::move(seat)]() mutable {
        Work(work, std::move(seat));
      });
  return JsonResponse(job, 202);
}

void BenchApi::Work(const PreparedProcedure& work, OperatorSeat::Held seat) {
  Bench* const bench = desk_->bench();
  told_ = bench->record == nullptr ? 0 : bench->record->rows.size();
  bench->say = [this](const std::string& text) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      job_["said"].push_back(text);
    }
    events_->Publish("said", JsonLine(Json{{"text", text}}));
  };
  sent_.clear();
  ProcedureResult result;
  try {
    result = work(bench);
  } catch (const std::exception& fault) {
    result.ending = Ending::kRefused;
    result.messages.emplace_back(fault.what());
  }
  TellReadings();
  TellSent(/*at_once=*/true);
  const bool was_aborted = seat_->is_aborted();
  // Who stopped a machine does not wait for its answer: Sent has seen what was written.
  if (!was_aborted || options_.is_twin) ReadSettings();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Json tree = ToJson(result);
    if (was_aborted) tree["ending"] = "aborted";
    job_["result"] = tree;
    job_["ended_at"] = UtcNow();
    kept_.AddResult(job_);
    const bool is_changed = std::ranges::any_of(result.steps, [](const Step& step) {
      return step.verdict == Verdict::kApplied;
    });
    if (is_changed) kept_.calibrated_at = UtcNow();
    const bool is_homed = job_["procedure"] == "home" &&
                          result.ending == Ending::kDone && !seat_->is_aborted();
    if (is_homed) is_stopped_ = false;
    // What stood before the first change: when that was found, nobody here knows.
    const bool is_restored =
        job_["procedure"] == "restore" && result.ending == Ending::kDone;
    if (is_restored) kept_.calibrated_at.clear();
  }
  KeepStore();
  store_.DropJob();
  { const OperatorSeat::Held rises = std::move(seat); }
  // Who reads "idle" may begin the next job at once.
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = "idle";
  }
  Tell();
}

// In the store before anybody can see the question: who ends the server at it loses
// nothing.
void BenchApi::Asked() {
  TellReadings();
  TellSent(/*at_once=*/true);
  const bool is_asked = person_->question().has_value();
  if (is_asked) KeepJob();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = is_asked ? "asking" : "working";
  }
  Tell();
}

// The newest lines of G-code, ten times a second at most; `at_once` where none may
// follow for long.
void BenchApi::TellSent(bool at_once) {
  constexpr std::chrono::milliseconds kEvery{100};
  const auto now = std::chrono::steady_clock::now();
  if (sent_.empty() || (!at_once && now - sent_told_ < kEvery)) return;
  sent_told_ = now;
  events_->Publish("sent", JsonLine(Json{{"lines", sent_}}));
}

void BenchApi::Sent(std::string_view line) {
  constexpr std::size_t kMostSent = 12;
  sent_.push_back(Printable(line));
  if (sent_.size() > kMostSent) sent_.pop_front();
  TellSent(/*at_once=*/false);
  TellReadings();
  if (!watch_.Sees(line)) return;
  KeepApplied();
  Tell();
}

void BenchApi::TellReadings() {
  const Bench& bench = *desk_->bench();
  if (bench.record == nullptr) return;
  const std::vector<Row>& rows = bench.record->rows;
  for (; told_ < rows.size(); ++told_) {
    const Json reading = ToJson(rows[told_]);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!job_.is_object()) return;
      if (job_["readings"].size() < kMostReadings) job_["readings"].push_back(reading);
    }
    events_->Publish("reading", JsonLine(reading));
  }
  if (std::chrono::steady_clock::now() - job_kept_ >= kKeepEvery) KeepJob();
}

// Past the link that an abort closes: what is in force is known after one too.
std::optional<Settings> BenchApi::SettingsNow() {
  const Bench& bench = *desk_->bench();
  if (is_halted_ || !HasAxisSettings(bench)) return std::nullopt;
  Controller controller(desk_->wire(), bench.machine);
  if (!controller.ReadSettings()) return std::nullopt;
  return controller.settings();
}

// In the store before anybody is told.
void BenchApi::KeepApplied() {
  const std::optional<Settings> now = SettingsNow();
  if (!now) return;
  bool is_changed = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Settings before = kept_.settings.value_or(*now);
    kept_.settings = watch_.Lasting(*now, before);
    for (const Json& change : ChangesOf(before, *kept_.settings)) {
      applied_.push_back(change);
      is_changed = true;
    }
  }
  if (is_changed) {
    KeepStore();
    KeepJob();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  settings_ = now;
}

void BenchApi::ReadSettings() {
  const std::optional<Settings> now = SettingsNow();
  if (!now) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  settings_ = now;
  kept_.settings = now;
}

void BenchApi::ResumeSettings() {
  const std::optional<Settings> kept = kept_.settings;
  if (options_.is_twin && kept && HasAxisSettings(*desk_->bench())) {
    if (const auto written =
            WriteSettings(desk_->wire(), desk_->bench()->machine, *kept);
        !written) {
      note_ = "the settings of the last session were refused: " + written.error().reply;
    }
  }
  ReadSettings();
  TakeUpInterrupted(kept);
}

void BenchApi::ReadStore() {
  kept_ = store_.Read(&note_);
  settings_ = kept_.settings;
}

// After the settings were read: what they are now belongs to the result.
void BenchApi::TakeUpInterrupted(const std::optional<Settings>& kept) {
  const std::optional<RunningJob> running = store_.ReadJob(&note_);
  if (!running) return;
  // Where the server ended after the result was written it is among them already.
  if (running->job["id"] > last_ended_job()) {
    kept_.AddResult(InterruptedJob(*running, kept, settings_));
    if (!running->applied.empty()) kept_.calibrated_at = running->kept_at;
    kept_.last_job = std::max(kept_.last_job, running->job["id"].get<int>());
  }
  KeepStore();
  store_.DropJob();
}

int BenchApi::last_ended_job() const {
  return kept_.results.empty() ? 0 : kept_.results.back().value("id", 0);
}

void BenchApi::KeepStore() {
  const std::lock_guard<std::mutex> writing(writing_);
  BenchKept kept;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    kept = kept_;
  }
  store_.Write(kept);
}

void BenchApi::KeepJob() {
  job_kept_ = std::chrono::steady_clock::now();
  const auto question = person_->question();
  RunningJob running{.question = question ? ToJson(*question) : Json(),
                     .kept_at = UtcNow()};
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool is_at_work = job_.is_object() && job_["result"].is_null();
    if (!is_at_work) return;
    running.job = job_;
    running.applied = applied_;
  }
  store_.WriteJob(running);
}

}  // namespace caltwin
