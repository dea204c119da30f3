#include "tools/commands/api/bench_api.h"

#include <algorithm>
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
#include "tools/commands/api/bench_settings.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEntries_bytes = 64'000;

Json SettingsTree(const std::optional<Settings>& settings) {
  return settings ? ToJson(*settings) : Json();
}

}  // namespace

BenchApi::BenchApi(std::unique_ptr<Desk> desk,
                   const Options& options,
                   OperatorSeat* seat,
                   EventTopic* events)
    : desk_(std::move(desk)),
      options_(options),
      seat_(seat),
      events_(events),
      store_(options.store) {
  Bench* const bench = desk_->bench();
  kind_ = KindFor(bench->machine);
  ClientOperator::Helpers helpers;
  if (options_.is_twin) helpers = {.hands = desk_->hands(), .gauge = bench->gauge};
  person_ = std::make_unique<ClientOperator>(helpers, [this] { Asked(); });
  link_ = std::make_unique<AbortableLink>(
      desk_->wire(), seat_, [this](std::string_view line) { Sent(line); });
  desk_->Connect(link_.get());
  bench->person = person_.get();
  bench->gauge = person_.get();
  ReadStore();
  ResumeSettings();
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
    return JsonResponse({{"results", kept_.readings}});
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
    artefacts.push_back(ToJson(artefact, options_.is_twin));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  Json tree{{"machine", bench.machine.name},
            {"kinematics", std::string(bench.machine.kind->name())},
            {"is_twin", options_.is_twin},
            {"state", state_},
            {"is_stopped", is_stopped_.load()},
            {"held_by", sitter ? Json(sitter->name) : Json()},
            {"job", job_},
            {"settings", SettingsTree(settings_)},
            {"settings_before", SettingsTree(kept_.settings_before)},
            {"calibrated_at",
             kept_.calibrated_at.empty() ? Json() : Json(kept_.calibrated_at)},
            {"procedures", std::move(procedures)},
            {"artefacts", std::move(artefacts)},
            {"session", {{"version", kept_.version}, {"entries", kept_.entries}}},
            {"results", kept_.results}};
  if (tree["job"].is_object()) {
    const bool is_kept = state_ == "asking";  // See Asked.
    tree["job"]["question"] = question && is_kept ? ToJson(*question) : Json();
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
    if (version >= 0 && version != kept_.version) {
      throw Problem(409,
                    "somebody else has changed the entries meanwhile",
                    {{.detail = fmt::format("they are at version {}", kept_.version),
                      .hint = "GET /api/bench, put your changes on top, and send again",
                      .pointer = "/version"}},
                    {{"version", kept_.version}, {"entries", kept_.entries}});
    }
    ++kept_.version;
    kept_.entries = entries;
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
    before = kept_.settings_before;
  }
  if (!before)
    throw Problem(409, "nothing was changed yet: there is nothing to restore");
  return StartJob(request, "restore", Json::object(), [wanted = *before](Bench* bench) {
    return ResultOf(WriteSettings(bench->link, bench->machine, wanted));
  });
}

HttpResponse BenchApi::SetSettings(const HttpRequest& request) {
  std::optional<Settings> now;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    now = settings_;
  }
  if (!now) throw Problem(409, "the settings of this machine cannot be set here");
  const Settings wanted = SettingsAsked(request, *now);
  return StartJob(request, "set", JsonBody(request), [wanted](Bench* bench) {
    return ResultOf(WriteSettings(bench->link, bench->machine, wanted));
  });
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
  is_stopped_ = true;
  const bool is_at_work = seat_->Abort();
  is_stopped_ =
      true;  // Homing may just have ended: what follows its end is stopped too.
  person_->Abort();
  if (!options_.is_twin) {
    is_halted_ = true;
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = std::jthread([this] { link_->Interject("M112"); });
  }
  return JsonResponse({{"aborted", is_at_work}, {"sent_m112", !options_.is_twin}}, 202);
}

HttpResponse BenchApi::UserVars() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!settings_) throw Problem(404, "this machine keeps no such file");
  const std::string date = kept_.calibrated_at.substr(
      0, std::min<std::size_t>(10, kept_.calibrated_at.size()));
  return {
      .content_type = "text/plain; charset=utf-8",
      .body = fmt::format("{}\n", fmt::join(UserVarsLines(*settings_, date), "\n"))};
}

}  // namespace caltwin
