#include "tools/commands/api/runs_api.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "sim/machine/machine.h"
#include "tools/commands/api/catalog_api.h"
#include "tools/commands/api/own_program.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostKept = 16;
constexpr int kMostAtWork = 2;
constexpr std::chrono::minutes kPatience{15};

std::vector<std::string> WordsOf(const Json& body, std::string* scenario) {
  JsonKeys keys(body);
  *scenario = keys.Text("scenario", "");
  const std::string fidelity = keys.Text("fidelity", "");
  constexpr int kMostSeed = 1'000'000'000;
  const int seed = keys.Integer("seed", 0, kMostSeed, -1);
  const std::vector<std::string> known = ScenarioNames();
  if (std::ranges::find(known, *scenario) == known.end()) {
    keys.Add("/scenario",
             fmt::format("there is no scenario '{}'", Printable(*scenario)),
             "GET /api/scenarios lists them");
  }
  if (!fidelity.empty() && fidelity != "physics" && fidelity != "fast") {
    keys.Add("/fidelity", "is neither physics nor fast", "");
  }
  keys.Done();
  const fs::path file = ShareFolder() / "scenarios" / (*scenario + ".yaml");
  std::vector<std::string> words = {"run",
                                    file.string(),
                                    "--json",
                                    "result.json",
                                    "--report",
                                    "report",
                                    "--transcript",
                                    "transcript.txt"};
  if (!fidelity.empty()) words.insert(words.end(), {"--fidelity", fidelity});
  if (seed >= 0) words.insert(words.end(), {"--seed", fmt::format("{}", seed)});
  return words;
}

}  // namespace

RunsApi::~RunsApi() {
  for (const auto& run : runs_) run->stop = true;
  for (const auto& run : runs_) {
    if (run->thread.joinable()) run->thread.join();
  }
}

void RunsApi::AddTo(Routes* routes) {
  const auto add = [&](const char* method, const char* path, Handler go) {
    routes->Add({.method = method,
                 .pattern = path,
                 .handler = std::move(go),
                 .pace = Route::Pace::kSlow});
  };
  add("POST", "/api/runs", [this](const HttpRequest& r) { return Begin(r); });
  add("GET", "/api/runs", [this](const HttpRequest&) { return List(); });
  add("GET", "/api/runs/{}", [this](const HttpRequest& r) { return Read(r); });
  add("DELETE", "/api/runs/{}", [this](const HttpRequest& r) { return Delete(r); });
  add("POST", "/api/runs/{}/stop", [this](const HttpRequest& r) { return Stop(r); });
  add("GET", "/api/runs/{}/report", [this](const HttpRequest& r) { return Report(r); });
  add("GET", "/api/runs/{}/transcript", [this](const HttpRequest& r) {
    return Transcript(r);
  });
}

std::shared_ptr<RunsApi::Run> RunsApi::Find(const std::string& id) const {
  const auto found =
      std::ranges::find(runs_, id, [](const auto& run) { return run->id; });
  if (found == runs_.end()) {
    throw Problem(
        404,
        fmt::format("there is no run {}", Printable(id)),
        {{.detail = "the last 16 are kept", .hint = "GET /api/runs lists them"}});
  }
  return *found;
}

HttpResponse RunsApi::Begin(const HttpRequest& request) {
  const Json body = JsonBody(request);
  const auto run = std::make_shared<Run>();
  const std::vector<std::string> words = WordsOf(body, &run->scenario);
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto at_work =
      std::ranges::count(runs_, "running", [](const auto& one) -> const std::string& {
        return one->state;
      });
  if (at_work >= kMostAtWork) {
    HttpResponse busy =
        Problem(429, "two runs are at work: wait for one to end").Response();
    busy.headers.emplace_back("Retry-After", "5");
    return busy;
  }
  if (runs_.size() >= kMostKept) {
    const auto oldest = std::ranges::find_if(
        runs_, [](const auto& one) { return one->state != "running"; });
    if ((*oldest)->thread.joinable()) (*oldest)->thread.join();
    std::error_code ignored;
    fs::remove_all(folder_.path() / (*oldest)->id, ignored);
    runs_.erase(oldest);
  }
  run->id = fmt::format("{}", ++last_);
  fs::create_directories(folder_.path() / run->id);
  runs_.push_back(run);
  run->thread = std::thread([this, raw = run.get(), words] { Work(raw, words); });
  HttpResponse response = JsonResponse(
      {{"id", run->id}, {"scenario", run->scenario}, {"state", "running"}}, 202);
  response.headers.emplace_back("Location", "/api/runs/" + run->id);
  return response;
}

void RunsApi::Work(Run* run, const std::vector<std::string>& words) {
  const fs::path folder = folder_.path() / run->id;
  std::string state = "done";
  std::string detail;
  std::string text;
  std::string result;
  events_->Publish("run", JsonLine(Json{{"id", run->id}, {"state", "running"}}));
  try {
    text = RunOwnProgram({.words = words,
                          .folder = folder,
                          .patience = kPatience,
                          .stop = &run->stop,
                          .is_confined = false});
    result = ReadTextFile(folder / "result.json", kLargestData_bytes);
  } catch (const std::exception& fault) {
    state = run->stop ? "stopped" : "failed";
    detail = fault.what();
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    run->state = state;
    run->detail = detail;
    run->text = text;
    run->result = result;
  }
  events_->Publish("run", JsonLine(Json{{"id", run->id}, {"state", state}}));
}

HttpResponse RunsApi::List() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Json list = Json::array();
  for (const auto& run : runs_) {
    list.push_back(
        {{"id", run->id}, {"scenario", run->scenario}, {"state", run->state}});
  }
  return JsonResponse({{"runs", std::move(list)}});
}

HttpResponse RunsApi::Read(const HttpRequest& request) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto run = Find(request.places[0]);
  Json tree{{"id", run->id}, {"scenario", run->scenario}, {"state", run->state}};
  if (!run->detail.empty()) tree["detail"] = run->detail;
  if (!run->text.empty()) tree["text"] = run->text;
  tree["result"] = run->result.empty() ? Json() : Json::parse(run->result);
  return JsonResponse(tree);
}

HttpResponse RunsApi::Stop(const HttpRequest& request) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto run = Find(request.places[0]);
  run->stop = true;
  return JsonResponse({{"id", run->id}, {"state", run->state}}, 202);
}

HttpResponse RunsApi::Delete(const HttpRequest& request) {
  std::shared_ptr<Run> run;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    run = Find(request.places[0]);
    std::erase(runs_, run);
  }
  run->stop = true;
  if (run->thread.joinable()) run->thread.join();
  std::error_code ignored;
  fs::remove_all(folder_.path() / run->id, ignored);
  return {.status = 204};
}

fs::path RunsApi::FileOf(const HttpRequest& request, const fs::path& name) const {
  fs::path file;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    file = folder_.path() / Find(request.places[0])->id / name;
  }
  if (!fs::exists(file)) throw Problem(409, "this run has none yet");
  return file;
}

HttpResponse RunsApi::Transcript(const HttpRequest& request) const {
  return {.content_type = "text/plain; charset=utf-8",
          .body = ReadTextFile(FileOf(request, "transcript.txt"), kLargestData_bytes)};
}

HttpResponse RunsApi::Report(const HttpRequest& request) const {
  const fs::path file = FileOf(request, fs::path("report") / "index.html");
  return PageResponse(ReadTextFile(file, kLargestData_bytes));
}

}  // namespace caltwin
