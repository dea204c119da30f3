#include "tools/commands/api/studies_api.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "scenarios/study/study.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine.h"
#include "tools/commands/api/catalog_api.h"
#include "tools/commands/api/own_program.h"
#include "tools/commands/api/utc.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostKept = 16;
constexpr int kMostTrials = 20'000;
constexpr std::size_t kMostVary_bytes = 64'000;
constexpr std::chrono::hours kPatience{6};
constexpr const char* kKept = "study.json";  // What is known of it, in its folder.
constexpr const char* kLast = "last";        // The number given out last.

// What is asked, as it is kept; throws Problem 422.
Json AskedBy(const HttpRequest& request) {
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr int kUsual = 200;
  constexpr int kMostSeed = 1'000'000'000;
  Json asked{{"scenario", keys.Text("scenario", "")},
             {"trials", keys.Integer("trials", 1, kMostTrials, kUsual)},
             {"seed", keys.Integer("seed", 0, kMostSeed, 1)},
             {"fidelity", keys.Text("fidelity", "fast")}};
  if (keys.Has("vary")) asked["vary"] = keys.Object("vary", kMostVary_bytes);
  const std::string scenario = asked["scenario"].get<std::string>();
  const std::vector<std::string> known = ScenarioNames();
  if (std::ranges::find(known, scenario) == known.end()) {
    keys.Add("/scenario",
             fmt::format("there is no scenario '{}'", Printable(scenario)),
             "GET /api/scenarios lists them");
  }
  if (asked["fidelity"] != "physics" && asked["fidelity"] != "fast") {
    keys.Add("/fidelity", "is neither physics nor fast", "");
  }
  keys.Done();
  return asked;
}

// The client knows no file of the server's: of all that was written only `vary` is its
// own.
[[noreturn]] void ThrowForVary(const InputError& error) {
  std::vector<ProblemFault> faults = FaultsOf(error.faults());
  for (ProblemFault& fault : faults) {
    fault = {.detail = fault.detail, .hint = fault.hint, .pointer = "/vary"};
  }
  throw Problem(422, "/vary " + faults.front().detail, faults);
}

// JSON is YAML. Read once here, so that what is wrong with it is said at once.
void WriteStudy(const fs::path& file, const Json& asked) {
  const std::string scenario = asked["scenario"].get<std::string>();
  Json study{{"about", "A study of " + scenario + "."},
             {"scenarios", {(ShareFolder() / "scenarios" / (scenario + ".yaml"))}}};
  for (const char* const key : {"vary", "fidelity", "trials", "seed"}) {
    if (asked.contains(key)) study[key] = asked[key];
  }
  WriteTextFile(file, Json{{"study", std::move(study)}}.dump() + "\n");
  try {
    ReadStudy(file);
  } catch (const InputError& error) {
    ThrowForVary(error);
  }
}

std::string Workers() {
  return fmt::format("{}", std::max(1U, std::thread::hardware_concurrency() / 2));
}

int NumberOf(const std::string& id) {
  int number = 0;
  const auto read = std::from_chars(id.data(), id.data() + id.size(), number);
  return read.ec == std::errc() && read.ptr == id.data() + id.size() ? number : 0;
}

}  // namespace

StudiesApi::StudiesApi(fs::path folder, EventTopic* events)
    : folder_(std::move(folder)), events_(events) {
  ReadKept();
}

StudiesApi::~StudiesApi() {
  for (const auto& one : studies_) one->stop = true;
  for (const auto& one : studies_) {
    if (one->thread.joinable()) one->thread.join();
  }
}

void StudiesApi::AddTo(Routes* routes) {
  const auto add = [&](const char* method, const char* path, Handler go) {
    routes->Add({.method = method,
                 .pattern = path,
                 .handler = std::move(go),
                 .pace = Route::Pace::kSlow});
  };
  add("POST", "/api/studies", [this](const HttpRequest& r) { return Begin(r); });
  add("GET", "/api/studies", [this](const HttpRequest&) { return List(); });
  add("GET", "/api/studies/{}", [this](const HttpRequest& r) { return Read(r); });
  add("DELETE", "/api/studies/{}", [this](const HttpRequest& r) { return Delete(r); });
  add("GET", "/api/studies/{}/report", [this](const HttpRequest& r) {
    return Report(r);
  });
}

std::shared_ptr<StudiesApi::One> StudiesApi::Find(const std::string& id) const {
  const auto found =
      std::ranges::find(studies_, id, [](const auto& one) { return one->id; });
  if (found != studies_.end()) return *found;
  throw Problem(
      404,
      fmt::format("there is no study {}", Printable(id)),
      {{.detail = "the last 16 are kept", .hint = "GET /api/studies lists them"}});
}

void StudiesApi::MakeRoom() {
  while (studies_.size() >= kMostKept) {
    const auto& oldest = studies_.front();
    if (oldest->thread.joinable()) oldest->thread.join();
    std::error_code ignored;
    fs::remove_all(folder_ / oldest->id, ignored);
    studies_.pop_front();
  }
}

std::string StudiesApi::NewFolder() {
  fs::create_directories(folder_);
  // A number is given out once: who kept the address of a deleted study meets no other.
  const int last = fs::exists(folder_ / kLast)
                       ? NumberOf(ReadTextFile(folder_ / kLast, kLargestFile_bytes))
                       : 0;
  int number = 1 + std::max(last, studies_.empty() ? 0 : NumberOf(studies_.back()->id));
  while (!fs::create_directory(folder_ / std::to_string(number))) ++number;
  std::string id = std::to_string(number);
  WriteDurably(folder_ / kLast, id);
  return id;
}

HttpResponse StudiesApi::Begin(const HttpRequest& request) {
  const auto one = std::make_shared<One>();
  one->asked = AskedBy(request);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& other : studies_) {
    if (other->state != "running") continue;
    throw Problem(
        409,
        fmt::format("study {} is running: one at a time", other->id),
        {{.detail = fmt::format("{} of {} runs are done", other->done, other->all),
          .hint = fmt::format("DELETE /api/studies/{} ends it", other->id)}},
        {{"running", other->id}});
  }
  MakeRoom();
  one->id = NewFolder();
  try {
    WriteStudy(folder_ / one->id / "study.yaml", one->asked);
  } catch (const std::exception&) {
    std::error_code ignored;
    fs::remove_all(folder_ / one->id, ignored);
    throw;
  }
  one->all = one->asked["trials"].get<std::int64_t>();
  one->begun_at = UtcNow();
  Keep(*one);
  studies_.push_back(one);
  one->thread = std::thread([this, raw = one.get()] { Work(raw); });
  HttpResponse response = JsonResponse(TreeOf(*one), 202);
  response.headers.emplace_back("Location", "/api/studies/" + one->id);
  return response;
}

void StudiesApi::Work(One* one) {
  std::string state = "done";
  std::string detail;
  std::string text;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Tell(*one);
  }
  try {
    text = RunOwnProgram({.words = {"study",
                                    "study.yaml",
                                    "--out",
                                    "out",
                                    "--report",
                                    "report",
                                    "--progress",
                                    "--workers",
                                    Workers()},
                          .folder = folder_ / one->id,
                          .patience = kPatience,
                          .stop = &one->stop,
                          .is_confined = false,
                          .takes = [this, one](std::string_view line) {
                            return TakesProgress(one, line);
                          }});
  } catch (const std::exception& fault) {
    state = one->stop ? "stopped" : "failed";
    detail = fault.what();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  one->state = state;
  one->detail = detail;
  one->text = text;
  one->ended_at = UtcNow();
  Keep(*one);
  Tell(*one);
}

bool StudiesApi::TakesProgress(One* one, std::string_view line) {
  const Json tree = Json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!tree.is_object() || !tree.contains("done") || !tree.contains("all"))
    return false;
  constexpr int kPercent = 100;
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::int64_t before = one->done;
  one->done = tree["done"].get<std::int64_t>();
  one->all = std::max<std::int64_t>(1, tree["all"].get<std::int64_t>());
  const bool is_far = one->done * kPercent / one->all != before * kPercent / one->all;
  if (is_far) Tell(*one);
  return true;
}

void StudiesApi::Tell(const One& one) const {
  events_->Publish(
      "study",
      JsonLine(Json{
          {"id", one.id}, {"state", one.state}, {"done", one.done}, {"all", one.all}}));
}

Json StudiesApi::TreeOf(const One& one) {
  Json tree{{"id", one.id}};
  tree.update(one.asked);
  tree["state"] = one.state;
  tree["progress"] = {{"done", one.done}, {"all", one.all}};
  tree["begun_at"] = one.begun_at;
  if (!one.ended_at.empty()) tree["ended_at"] = one.ended_at;
  if (!one.detail.empty()) tree["detail"] = one.detail;
  return tree;
}

HttpResponse StudiesApi::List() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Json list = Json::array();
  for (const auto& one : studies_) list.push_back(TreeOf(*one));
  return JsonResponse({{"studies", std::move(list)}});
}

HttpResponse StudiesApi::Read(const HttpRequest& request) const {
  Json tree;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto one = Find(request.places[0]);
    tree = TreeOf(*one);
    if (!one->text.empty()) tree["text"] = one->text;
  }
  tree["summary"] = nullptr;
  if (tree["state"] == "done") {
    const fs::path file =
        folder_ / tree["id"].get<std::string>() / "out" / "summary.json";
    tree["summary"] = Json::parse(ReadTextFile(file, kLargestData_bytes));
  }
  return JsonResponse(tree);
}

HttpResponse StudiesApi::Delete(const HttpRequest& request) {
  std::shared_ptr<One> one;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    one = Find(request.places[0]);
    std::erase(studies_, one);
  }
  one->stop = true;
  if (one->thread.joinable()) one->thread.join();
  std::error_code ignored;
  fs::remove_all(folder_ / one->id, ignored);
  return {.status = 204};
}

HttpResponse StudiesApi::Report(const HttpRequest& request) const {
  fs::path file;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto one = Find(request.places[0]);
    if (one->state != "done") throw Problem(409, "this study has no report yet");
    file = folder_ / one->id / "report" / "index.html";
  }
  return PageResponse(ReadTextFile(file, kLargestData_bytes));
}

void StudiesApi::Keep(const One& one) const {
  Json tree{{"format", 1}, {"asked", one.asked}, {"state", one.state}};
  tree.update({{"detail", one.detail},
               {"text", one.text},
               {"begun_at", one.begun_at},
               {"ended_at", one.ended_at},
               {"done", one.done},
               {"all", one.all},
               {"server", ::getpid()}});
  try {
    WriteDurably(folder_ / one.id / kKept, JsonLine(tree) + "\n");
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
}

void StudiesApi::ReadKept() {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const auto one = std::make_shared<One>();
    one->id = entry.path().filename().string();
    if (NumberOf(one->id) == 0) continue;
    try {
      const Json tree =
          Json::parse(ReadTextFile(entry.path() / kKept, kLargestData_bytes));
      one->asked = tree.at("asked");
      one->state = tree.at("state").get<std::string>();
      one->detail = tree.at("detail").get<std::string>();
      one->text = tree.at("text").get<std::string>();
      one->begun_at = tree.at("begun_at").get<std::string>();
      one->ended_at = tree.at("ended_at").get<std::string>();
      one->done = tree.at("done").get<std::int64_t>();
      one->all = tree.at("all").get<std::int64_t>();
      if (one->state == "running") {
        if (IsAnotherAlive(tree.at("server").get<int>())) continue;
        one->state = "stopped";
        one->detail = "the server ended during it";
        Keep(*one);
      }
    } catch (const std::exception&) {
      continue;  // None of ours: it stays where it is.
    }
    studies_.push_back(one);
  }
  std::ranges::sort(studies_, {}, [](const auto& one) { return NumberOf(one->id); });
}

}  // namespace caltwin
