#include "tools/commands/api/web_service.h"

#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/procedures/catalog.h"
#include "scenarios/kinds/kinds.h"
#include "sim/base/input_error.h"
#include "sim/base/sha256.h"
#include "sim/base/temporary_folder.h"
#include "sim/base/text_file.h"
#include "tools/commands/api/bench_api.h"
#include "tools/commands/api/catalog_api.h"
#include "tools/commands/api/diagnose_api.h"
#include "tools/commands/api/runs_api.h"
#include "tools/commands/api/scene_api.h"
#include "tools/commands/api/studies_api.h"
#include "tools/commands/kinds/bed_api.h"
#include "tools/commands/kinds/desks.h"
#include "tools/server/pages.h"
#include "tools/server/problem.h"
#include "tools/server/server.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kShortestToken = 16;

std::string TokenOf(const WebOptions& options) {
  if (options.token_file.empty()) {
    if (IsLoopback(options.address)) return "";
    throw InputError(
        {.file = "--listen"},
        fmt::format("others reach {}, so a token is needed", options.address),
        "--token-file FILE, a file with a secret of 16 letters or more: "
        "openssl rand -hex 16 > FILE");
  }
  std::string token = ReadTextFile(options.token_file, kLargestFile_bytes);
  while (!token.empty() &&
         std::isspace(static_cast<unsigned char>(token.back())) != 0) {
    token.pop_back();
  }
  if (token.size() < kShortestToken ||
      token.find_first_of(" \t\r\n;,\"") != std::string::npos) {
    throw InputError({.file = options.token_file.string()},
                     "a token is one word of 16 letters or more",
                     "openssl rand -hex 16 > " + options.token_file.string());
  }
  return token;
}

// A twin as a link's address says it.
std::string TwinUrl(const TwinOptions& twin) {
  std::string url = fmt::format(
      "twin:{}?fidelity={}&seed={}", twin.machine, twin.fidelity, twin.seed);
  if (!twin.truth.empty()) url += "&truth=" + twin.truth;
  return url;
}

std::unique_ptr<Desk> DeskOf(const TwinOptions& twin, const std::string& link) {
  CalibrateOptions options{.link = link.empty() ? TwinUrl(twin) : link,
                           .machine = link.empty() ? "" : twin.machine,
                           .apply = true,
                           .yes = true};
  const auto file = MachineToCalibrate(options);
  const auto kind = KindFor(file->machine);
  const Procedures known = kind->KnownProcedures();
  const DeskKind& desks = DeskKindOf(known.empty() ? "" : known.front()->kind);
  desks.refuse(options, twin, file);
  return desks.make(options, twin, file);
}

// A machine that came with the program, with errors that the person does not know.
TwinOptions Practice(const std::string& name, const std::string& fidelity) {
  const fs::path folder = ShareFolder() / "examples" / "practice";
  TwinOptions practice{.machine = name,
                       .truth = (folder / (name + ".yaml")).string(),
                       .fidelity = fidelity};
  ReadBenchFile((folder / "bench.yaml").string(), &practice);
  return practice;
}

HttpResponse NoBed(const HttpRequest&) {
  throw Problem(404,
                "the machine that is served has no bed on three screws",
                {{.detail = "no such machine",
                  .hint = "caltwin serve --http PORT --machine triple_z_printer"}});
}

}  // namespace

fs::path StateFolder() {
  if (const char* const state = std::getenv("XDG_STATE_HOME");
      state != nullptr && *state == '/') {
    return fs::path(state) / "caltwin";
  }
  if (const char* const home = std::getenv("HOME"); home != nullptr && *home == '/') {
    return fs::path(home) / ".local" / "state" / "caltwin";
  }
  return {};
}

struct WebService::Parts {
  std::string machine{};
  std::optional<TwinFiles> twin{};  ///< On the bench; nullopt: a real machine.
  Gate gate;
  Pages pages;
  std::shared_ptr<EventTopic> events = std::make_shared<EventTopic>();
  OperatorSeat bench_seat{}, printer_seat{};
  DiagnoseApi diagnose;
  RunsApi runs{events.get()};
  TemporaryFolder temporary{"caltwin_server"};  ///< Where no other is for what is kept.
  std::unique_ptr<StudiesApi> studies{};
  SceneApi scenes{};
  std::unique_ptr<BenchApi> bench{};
  std::unique_ptr<Desk> printer{};  ///< Of practice, beside the bench.
  std::unique_ptr<AbortableLink> printer_link{};
  std::unique_ptr<BedApi> bed{};
  Routes routes{};
};

WebService::WebService(const WebOptions& options, const std::atomic<bool>* stop)
    : options_(options),
      stop_(stop),
      parts_(new Parts{.gate = Gate(options.address, TokenOf(options)),
                       .pages = Pages(ShareFolder() / "web"),
                       .diagnose = DiagnoseApi(stop)}) {
  const fs::path state = options_.state.empty() ? StateFolder() : options_.state;
  parts_->studies = std::make_unique<StudiesApi>(
      fs::absolute(state.empty() ? parts_->temporary.path() : state) / "studies",
      parts_->events.get());
  BuildMachines();
  AddRoutes();
  AddPages();
}

// Where what belongs to a machine is kept; empty: nowhere. `which`: the wire or the
// twin, so that nothing of one is ever written to another.
fs::path WebService::StoreOf(const std::string& machine,
                             const std::string& which,
                             const char* what) const {
  const fs::path state = options_.state.empty() ? StateFolder() : options_.state;
  if (state.empty()) return {};
  std::string name = machine.empty() ? "machine" : machine;
  for (char& letter : name) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  }
  constexpr std::size_t kEnough = 8;
  return state /
         fmt::format("{}-{}.{}.json", name, Sha256(which).substr(0, kEnough), what);
}

void WebService::BuildMachines() {
  Parts& parts = *parts_;
  const std::string& fidelity = options_.twin.fidelity;
  const TwinOptions twin =
      options_.has_machine ? options_.twin : Practice("gantry_router", fidelity);
  std::unique_ptr<Desk> desk = DeskOf(twin, options_.link);
  Bench* const bench = desk->bench();
  parts.machine = bench->machine.name;
  if (options_.link.empty()) {
    parts.twin = {.machine = FindMachine(twin.machine, "", {.file = "--machine"}),
                  .truth = twin.truth,
                  .seed = twin.seed,
                  .artefacts = bench->artefacts};
  }
  const std::string which = options_.link.empty() ? TwinUrl(twin) : options_.link;
  parts.bench = std::make_unique<BenchApi>(
      std::move(desk),
      BenchApi::Options{.store = StoreOf(parts.machine, which, "bench"),
                        .is_twin = options_.link.empty()},
      &parts.bench_seat,
      parts.events.get());
  parts.bed = BedApiOn(bench,
                       {StoreOf(parts.machine, which, "bed"), parts.machine},
                       &parts.bench_seat,
                       parts.events.get());
  if (parts.bed || options_.has_machine) return;
  const TwinOptions printer = Practice("triple_z_printer", fidelity);
  parts.printer = DeskOf(printer, "");
  parts.printer_link = std::make_unique<AbortableLink>(
      parts.printer->wire(), &parts.printer_seat, [](std::string_view) {});
  parts.printer->Connect(parts.printer_link.get());
  parts.bed =
      BedApiOn(parts.printer->bench(),
               {StoreOf(printer.machine, TwinUrl(printer), "bed"), printer.machine},
               &parts.printer_seat,
               parts.events.get());
}

void WebService::AddRoutes() {
  Parts& parts = *parts_;
  Routes* const routes = &parts.routes;
  parts.diagnose.AddTo(routes);
  parts.runs.AddTo(routes);
  parts.studies->AddTo(routes);
  parts.scenes.AddTo(routes, parts.twin);
  parts.bench->AddTo(routes);
  AddCatalogTo(routes);
  const auto get = [&](const char* path, Handler go) {
    routes->Add({.method = "GET", .pattern = path, .handler = std::move(go)});
  };
  if (parts.bed) {
    parts.bed->AddTo(routes);
  } else {
    BedApi::Refuse(routes, NoBed);
  }
  get("/api/events", [events = parts.events](const HttpRequest&) {
    return HttpResponse{.events = events};
  });
  get("/api", [&parts](const HttpRequest&) {
    return JsonResponse({{"name", "caltwin"},
                         {"version", CALTWIN_VERSION},
                         {"machine", parts.machine},
                         {"has_bed", parts.bed != nullptr},
                         {"openapi", "/api/openapi.json"}});
  });
  const std::string document =
      ReadTextFile(ShareFolder() / "docs" / "openapi.json", kLargestFile_bytes);
  get("/api/openapi.json",
      [document](const HttpRequest&) { return HttpResponse{.body = document}; });
}

void WebService::AddPages() {
  Parts& parts = *parts_;
  if (!parts.pages.empty()) {
    parts.routes.SetRest(
        [&parts](const HttpRequest& request) { return parts.pages.Serve(request); });
    return;
  }
  parts.routes.Add(
      {.method = "GET", .pattern = "/", .handler = [](const HttpRequest&) {
         return HttpResponse{
             .content_type = "text/html; charset=utf-8",
             .body =
                 "<!doctype html><title>caltwin</title><p>The pages are not built. "
                 "<code>tools/pages.sh</code> builds them; the REST interface is "
                 "there: <a href=\"/api/openapi.json\">/api/openapi.json</a>.</p>\n"};
       }});
}

WebService::~WebService() = default;

std::vector<std::string> WebService::Notes() const {
  std::vector<std::string> notes;
  for (const std::string& note :
       {parts_->bench->note(), parts_->bed ? parts_->bed->note() : std::string()}) {
    if (!note.empty()) notes.push_back("note: " + note);
  }
  if (parts_->pages.empty()) {
    notes.emplace_back(
        "the pages are not built (tools/pages.sh builds them); the REST "
        "interface is there");
  }
  if (!options_.has_machine) {
    notes.emplace_back(
        "practice machines with hidden errors: gantry_router and "
        "triple_z_printer; --machine serves another");
  }
  return notes;
}

void WebService::Serve(const std::function<void(const std::string& url)>& listening) {
  const bool is_v6 = options_.address.find(':') != std::string::npos;
  const std::string host = is_v6 ? "[" + options_.address + "]" : options_.address;
  ServeHttp(parts_->routes,
            parts_->gate,
            {.address = options_.address, .port = options_.port},
            stop_,
            [&](int port) { listening(fmt::format("http://{}:{}/", host, port)); });
}

}  // namespace caltwin
