#include "tools/commands/api/bench_api.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/loop/controller.h"
#include "calibration/loop/user_vars.h"
#include "scenarios/kinds/kinds.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine_kind.h"
#include "tools/commands/api/bench_json.h"
#include "tools/commands/api/put_aside.h"
#include "tools/commands/api/utc.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEntries_bytes = 64'000;
constexpr std::size_t kMostResults = 60;
constexpr std::size_t kMostReadings = 2000;  // That a job shows.
constexpr std::size_t kMostWithReadings = 12;

Json SettingsTree(const std::optional<Settings>& settings) {
  return settings ? ToJson(*settings) : Json();
}

// Whether the firmware's settings are those that this engine reads and writes by axis.
bool HasAxisSettings(const Bench& bench) {
  return bench.record != nullptr && bench.machine.kind->axes_are_drives();
}

Expected<void> WriteSettings(Bench* bench, const Settings& wanted) {
  Controller controller(bench->link, bench->machine);
  if (const auto read = controller.ReadSettings(); !read) return read;
  const Settings now = controller.settings();
  for (const Axis axis : kAxes) {
    const std::size_t i = Index(axis);
    Expected<void> done;
    if (now.steps_per_mm[i] != wanted.steps_per_mm[i]) {
      done = controller.WriteStepsPerMm(axis, wanted.steps_per_mm[i]);
    }
    if (done && now.backlash_mm[i] != wanted.backlash_mm[i]) {
      done = controller.WriteBacklash(axis, wanted.backlash_mm[i]);
    }
    if (done && now.probe_deflection_mm[i] != wanted.probe_deflection_mm[i]) {
      done = controller.WriteDeflection(axis, wanted.probe_deflection_mm[i]);
    }
    if (!done) return done;
  }
  return {};
}

// What a job answers that failed before its procedure could.
ProcedureResult ResultOf(const Expected<void>& done) {
  ProcedureResult result;
  if (done) return result;
  result.ending = EndingOfFault(done.error());
  result.fault = done.error().reply;
  result.messages.push_back(MachineSaid(done.error().reply));
  return result;
}

}  // namespace

BenchApi::BenchApi(std::unique_ptr<Desk> desk,
                   const Options& options,
                   OperatorSeat* seat,
                   EventTopic* events)
    : desk_(std::move(desk)), options_(options), seat_(seat), events_(events) {
  Bench* const bench = desk_->bench();
  kind_ = KindFor(bench->machine);
  ClientOperator::Helpers helpers;
  if (options_.is_twin) helpers = {.hands = desk_->hands(), .gauge = bench->gauge};
  person_ = std::make_unique<ClientOperator>(helpers, [this] {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      state_ = person_->question() ? "asking" : "working";
    }
    Tell();
  });
  link_ = std::make_unique<AbortableLink>(
      desk_->wire(), seat_, [this](std::string_view line) { Sent(line); });
  desk_->Connect(link_.get());
  bench->person = person_.get();
  bench->gauge = person_.get();
  ReadStore();
  if (HasAxisSettings(*bench)) ResumeSettings();
}

BenchApi::~BenchApi() {
  person_->Abort();
  if (thread_.joinable()) thread_.join();
}

void BenchApi::AddTo(Routes* routes) {
  using enum Route::Pace;
  const auto add =
      [&](const char* method, const char* path, Route::Pace pace, Handler go) {
        routes->Add({.method = method,
                     .pattern = std::string("/api/bench") + path,
                     .handler = std::move(go),
                     .pace = pace});
      };
  add("GET", "", kQuick, [this](const HttpRequest&) { return Status(); });
  add("PATCH", "/session", kSlow, [this](const HttpRequest& r) {
    return SetSession(r);
  });
  add("POST", "/procedures", kSlow, [this](const HttpRequest& r) { return Begin(r); });
  add("POST", "/answer", kQuick, [this](const HttpRequest& r) { return Answer(r); });
  add("POST", "/abort", kQuick, [this](const HttpRequest&) { return Abort(); });
  add("POST", "/emergency-stop", kQuick, [this](const HttpRequest&) {
    return EmergencyStop();
  });
  add("POST", "/restore", kSlow, [this](const HttpRequest& r) { return Restore(r); });
  add("GET", "/results", kSlow, [this](const HttpRequest&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return JsonResponse({{"results", readings_}});
  });
  add("PATCH", "/settings", kSlow, [this](const HttpRequest& r) {
    return SetSettings(r);
  });
  add("GET", "/user-vars", kQuick, [this](const HttpRequest&) { return UserVars(); });
}

Json BenchApi::Tree() const {
  const Bench& bench = *desk_->bench();
  const auto question = person_->question();
  const auto sitter = seat_->sitter();
  Json procedures = Json::array();
  for (const Procedure* const one : kind_->KnownProcedures()) {
    procedures.push_back(std::string(one->name));
  }
  Json artefacts = Json::array();
  for (const Artefact& artefact : bench.artefacts) {
    artefacts.push_back({{"id", artefact.id}, {"type", ToString(artefact.type)}});
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  Json tree{{"machine", bench.machine.name},
            {"kinematics", std::string(bench.machine.kind->name())},
            {"is_twin", options_.is_twin},
            {"state", state_},
            {"held_by", sitter ? Json(sitter->name) : Json()},
            {"job", job_},
            {"settings", SettingsTree(settings_)},
            {"settings_before", SettingsTree(settings_before_)},
            {"calibrated_at", calibrated_at_.empty() ? Json() : Json(calibrated_at_)},
            {"procedures", std::move(procedures)},
            {"artefacts", std::move(artefacts)},
            {"session", {{"version", version_}, {"entries", entries_}}},
            {"results", results_}};
  if (tree["job"].is_object()) {
    tree["job"]["question"] = question ? ToJson(*question) : Json();
  }
  return tree;
}

Json BenchApi::Tell() {
  const std::lock_guard<std::mutex> lock(telling_);
  Json tree = Tree();
  events_->Publish("bench", JsonLine(tree));
  return tree;
}

HttpResponse BenchApi::Status() const {
  return JsonResponse(Tree());
}

HttpResponse BenchApi::SetSession(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr int kMost = 1'000'000'000;
  const int version = keys.Integer("version", 0, kMost, -1);
  const Json entries = keys.Object("entries", kMostEntries_bytes, /*is_required=*/true);
  keys.Done();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (version >= 0 && version != version_) {
      throw Problem(409,
                    "somebody else has changed the entries meanwhile",
                    {{.detail = fmt::format("they are at version {}", version_),
                      .hint = "GET /api/bench, put your changes on top, and send again",
                      .pointer = "/version"}},
                    {{"version", version_}, {"entries", entries_}});
    }
    ++version_;
    entries_ = entries;
  }
  KeepStore();
  return JsonResponse(Tell()["session"]);
}

CalibrationStep BenchApi::StepOf(const std::string& name, const Json& options) const {
  const std::vector<std::string> known = kind_->StepNames();
  const bool is_procedure = FindProcedure(name, kind_->KnownProcedures()) != nullptr;
  if (!is_procedure) {
    throw Problem(422,
                  fmt::format("there is no procedure '{}'", Printable(name)),
                  {{.detail = "no such procedure of this machine",
                    .hint = fmt::format("it knows: {}", fmt::join(known, ", ")),
                    .pointer = "/procedure"}});
  }
  // JSON is YAML: one reader for both.
  Faults faults;
  YamlMap map = ReadYamlText(
      fmt::format("calibrate: [{{{}: {}}}]", name, options.dump()), "options", &faults);
  auto steps = ReadCalibrationSteps(
      *map.Required("calibrate"), *kind_, desk_->bench()->machine, "x");
  faults.ThrowIfAny();
  return std::move(steps.front());
}

HttpResponse BenchApi::Begin(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  const std::string name = keys.Text("procedure", "");
  const Json options = keys.Object("options", kMostEntries_bytes);
  keys.Done();
  if (name == "home") {
    return StartJob(request, name, options, [](Bench* bench) {
      return ResultOf(Controller(bench->link, bench->machine).Home());
    });
  }
  if (name == "reset") {
    return StartJob(request, name, options, [](Bench* bench) {
      return ResultOf(Controller(bench->link, bench->machine).Restart());
    });
  }
  CalibrationStep step = StepOf(name, options);
  return StartJob(request, name, options, std::move(step.procedure));
}

HttpResponse BenchApi::Restore(const HttpRequest& request) {
  std::optional<Settings> before;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    before = settings_before_;
  }
  if (!before)
    throw Problem(409, "nothing was changed yet: there is nothing to restore");
  return StartJob(request, "restore", Json::object(), [wanted = *before](Bench* bench) {
    return ResultOf(WriteSettings(bench, wanted));
  });
}

// Steps/mm at most a factor of two from what they are, gaps and deflections below 5 mm:
// beyond, a number was mistyped.
HttpResponse BenchApi::SetSettings(const HttpRequest& request) {
  std::optional<Settings> now;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    now = settings_;
  }
  if (!now) throw Problem(409, "the settings of this machine cannot be set here");
  Settings wanted = *now;
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr double kMost_mm = 5;
  for (const auto& [key, member] :
       {std::pair{"steps_per_mm", &Settings::steps_per_mm},
        std::pair{"backlash_mm", &Settings::backlash_mm},
        std::pair{"probe_deflection_mm", &Settings::probe_deflection_mm}}) {
    const Json by_axis = keys.Object(key, kMostEntries_bytes);
    JsonKeys axes(by_axis);
    for (const Axis axis : kAxes) {
      double& value = (wanted.*member)[Index(axis)];
      const bool is_steps = member == &Settings::steps_per_mm;
      const NumberRange range = is_steps ? NumberRange{value / 2, value * 2, "steps/mm"}
                                         : NumberRange{0, kMost_mm, "mm"};
      value = axes.Number(Name(axis), range, value);
    }
    axes.Done();
  }
  keys.Done();
  return StartJob(request, "set", body, [wanted](Bench* bench) {
    return ResultOf(WriteSettings(bench, wanted));
  });
}

HttpResponse BenchApi::StartJob(const HttpRequest& request,
                                const std::string& name,
                                const Json& asked,
                                PreparedProcedure work) {
  auto seat = seat_->Take(request, "running " + name);
  if (thread_.joinable()) thread_.join();
  person_->Begin();
  Json job;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = "working";
    job_ = {{"id", ++last_job_},
            {"procedure", name},
            {"options", asked},
            {"begun_at", UtcNow()},
            {"said", Json::array()},
            {"readings", Json::array()},
            {"result", nullptr}};
    job = job_;
    if (!settings_before_) settings_before_ = settings_;
  }
  KeepStore();
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
  ProcedureResult result;
  try {
    result = work(bench);
  } catch (const std::exception& fault) {
    result.ending = Ending::kRefused;
    result.messages.emplace_back(fault.what());
  }
  TellReadings();
  const bool was_aborted = seat_->is_aborted();
  if (HasAxisSettings(*bench)) ReadSettings();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Json tree = ToJson(result);
    if (was_aborted) tree["ending"] = "aborted";
    job_["result"] = tree;
    job_["ended_at"] = UtcNow();
    results_.push_back(job_);
    readings_.push_back(job_);
    results_.back().erase("readings");
    results_.back().erase("said");
    if (readings_.size() > kMostWithReadings) readings_.erase(readings_.begin());
    if (results_.size() > kMostResults) results_.erase(results_.begin());
    const bool is_changed = std::ranges::any_of(result.steps, [](const Step& step) {
      return step.verdict == Verdict::kApplied;
    });
    if (is_changed) calibrated_at_ = UtcNow();
    // What stood before the first change: when that was found, nobody here knows.
    const bool is_restored =
        job_["procedure"] == "restore" && result.ending == Ending::kDone;
    if (is_restored) calibrated_at_.clear();
  }
  KeepStore();
  { const OperatorSeat::Held rises = std::move(seat); }
  // Who reads "idle" may begin the next job at once.
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = "idle";
  }
  Tell();
}

void BenchApi::Sent(std::string_view line) {
  TellReadings();
  // "M92 X800", "set global.nxtProbeDeflection = ...": the settings are others now.
  const bool writes = (line.starts_with("M92 ") || line.starts_with("M425 ") ||
                       line.starts_with("set global.nxtProbeDeflection"));
  if (!writes || is_reading_ || !HasAxisSettings(*desk_->bench())) return;
  is_reading_ = true;
  ReadSettings();
  is_reading_ = false;
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
}

void BenchApi::ReadSettings() {
  Bench* const bench = desk_->bench();
  Controller controller(bench->link, bench->machine);
  if (!controller.ReadSettings()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  settings_ = controller.settings();
  // In a procedure compensation may be off for a while: nothing to go on from.
  if (!is_reading_) kept_settings_ = settings_;
}

void BenchApi::ResumeSettings() {
  if (options_.is_twin && settings_) {
    if (const auto written = WriteSettings(desk_->bench(), *settings_); !written) {
      note_ = "the settings of the last session were refused: " + written.error().reply;
    }
  }
  ReadSettings();
}

HttpResponse BenchApi::Answer(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr int kMost = 1'000'000'000;
  const int id = keys.Integer("id", 1, kMost, 0);
  const bool is_yes = keys.Bool("yes", true);
  std::optional<double> value_mm;
  if (keys.Has("value_mm")) {
    constexpr double kFar_mm = 1e5;
    value_mm = keys.Number("value_mm", {-kFar_mm, kFar_mm, "mm"}, 0);
  }
  keys.Done();
  if (!person_->Answer(id, is_yes, value_mm)) {
    const auto waiting = person_->question();
    throw Problem(409,
                  "that question waits for no answer",
                  {{.detail = waiting ? fmt::format("question {} waits", waiting->id)
                                      : std::string("nothing is asked"),
                    .pointer = "/id"}});
  }
  return JsonResponse({{"id", id}, {"taken", true}});
}

HttpResponse BenchApi::Abort() {
  const bool is_at_work = seat_->Abort();
  person_->Abort();
  return JsonResponse({{"aborted", is_at_work}}, 202);
}

// The line is said in a thread of its own: a wire that takes nothing holds nobody up.
HttpResponse BenchApi::EmergencyStop() {
  const bool is_at_work = seat_->Abort();
  person_->Abort();
  if (!options_.is_twin) {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = std::jthread([this] { link_->Interject("M112"); });
  }
  return JsonResponse({{"aborted", is_at_work}, {"sent_m112", !options_.is_twin}}, 202);
}

HttpResponse BenchApi::UserVars() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!settings_) throw Problem(404, "this machine keeps no such file");
  const std::string date =
      calibrated_at_.substr(0, std::min<std::size_t>(10, calibrated_at_.size()));
  return {
      .content_type = "text/plain; charset=utf-8",
      .body = fmt::format("{}\n", fmt::join(UserVarsLines(*settings_, date), "\n"))};
}

void BenchApi::ReadStore() {
  std::error_code error;
  if (options_.store.empty() || !std::filesystem::exists(options_.store, error)) return;
  try {
    const Json tree = Json::parse(ReadTextFile(options_.store, kLargestData_bytes));
    version_ = tree.at("version").get<int>();
    entries_ = tree.at("entries");
    results_ = tree.at("results");
    readings_ = tree.at("readings");
    last_job_ = tree.at("last_job").get<int>();
    calibrated_at_ = tree.at("calibrated_at").get<std::string>();
    if (!tree.at("settings").is_null()) settings_ = SettingsOf(tree.at("settings"));
    if (!tree.at("settings_before").is_null()) {
      settings_before_ = SettingsOf(tree.at("settings_before"));
    }
    return;
  } catch (const std::exception&) {
    note_ = PutAside(options_.store);
  }
}

void BenchApi::KeepStore() {
  if (options_.store.empty()) return;
  const std::lock_guard<std::mutex> writing(writing_);
  std::string text;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    text = Json{{"format", 1},
                {"version", version_},
                {"entries", entries_},
                {"results", results_},
                {"readings", readings_},
                {"last_job", last_job_},
                {"calibrated_at", calibrated_at_},
                {"settings", SettingsTree(kept_settings_)},
                {"settings_before", SettingsTree(settings_before_)}}
               .dump(1,
                     ' ',
                     /*ensure_ascii=*/false,
                     Json::error_handler_t::replace);
  }
  try {
    WriteDurably(options_.store, text + "\n");
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());  // The machine goes on.
  }
}

}  // namespace caltwin
