#include "scenarios/linuxcnc/host.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "scenarios/host_log.h"
#include "scenarios/interrupt.h"
#include "scenarios/linuxcnc/sandbox.h"
#include "sim/base/input_error.h"
#include "sim/base/temporary_folder.h"
#include "sim/base/text_file.h"
#include "sim/controllers/linuxcnc/config.h"
#include "sim/controllers/linuxcnc/joints.h"
#include "sim/controllers/linuxcnc/plant_page.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using Now = std::chrono::steady_clock;

/// A line that is not done after so many cycles is looked at again: an answer costs a
/// call of the system.
constexpr int kCyclesPerGlance = 16;
/// LinuxCNC's own tasks look at the machine every real millisecond; while nothing moves
/// the servo cycles would run far ahead of them. Beyond a quarter of a second they wait
/// for time to go by, as in a dwell.
constexpr int kStill_cycles = 20, kDwell_cycles = 250;
constexpr auto kStillNap = std::chrono::microseconds(900);
/// What moved in the last cycles of an order is seen by the machine.
constexpr int kSettle_cycles = 3;

constexpr const char* kOperator = "/tmp/component/caltwin_operator.py";

// Lines that LinuxCNC always writes, and those that point to files inside its /tmp.
bool TellsSomething(std::string_view line) {
  constexpr std::array kAlways = {"task: main loop took",
                                  "LinuxCNC terminated with an error",
                                  "/tmp/home/",
                                  "as well as in the output of the shell",
                                  "Note: Using POSIX non-realtime",
                                  "link (updating variable file)"};
  const auto first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos || line.substr(first) == "and") return false;
  return std::ranges::none_of(kAlways, [&](std::string_view words) {
    return line.substr(first).starts_with(words);
  });
}

LinuxCncAnswer AnswerIn(const nlohmann::json& said) {
  LinuxCncAnswer answer{
      .done = said.at("done"),
      .errors = said.at("errors"),
      .messages = said.at("messages"),
      .probed_mm = said.at("probed"),
      .position_mm = said.at("position"),
  };
  for (auto* const texts : {&answer.errors, &answer.messages}) {
    for (std::string& text : *texts) text = Printable(text);
  }
  return answer;
}

}  // namespace

// Everything of one LinuxCNC, in the order in which it is needed.
class LinuxCncHost::Parts {
 public:
  Parts(Board* board, const LinuxCncOptions& options)
      : options_(options),
        kept_log_(folder_.path() / "linuxcnc.log", options.log),
        joints_(board, options.probe),
        page_(folder_.path() / "page", &joints_, /*patience=*/milliseconds(0)) {
    LinuxCncFiles files = options.files;
    std::string& ini = files.front().second;
    for (const std::string& one : options.set) ini = WithIniSetting(ini, one, one);
    ini = linuxcnc::WithIniValue(ini, "DISPLAY", "DISPLAY", kOperator);
    ini = linuxcnc::WithoutIniValue(ini, "DISPLAY", "INTRO_GRAPHIC");
    // Time goes fast: what LinuxCNC's programs wait for each other is by its clock.
    ini = linuxcnc::WithIniValue(ini, "TASK", "CYCLE_TIME", "0.001");
    ini = linuxcnc::WithIniValue(ini, "EMCIO", "CYCLE_TIME", "0.01");
    for (const auto& [name, text] : files) WriteTextFile(config() / name, text);
    sandbox_.Start(folder_.path(), options.files.front().first);
    if (!Await("start").done) throw HostLost("LinuxCNC cannot be switched on" + Log());
  }
  LinuxCncAnswer Obey(const nlohmann::json& order);
  fs::path config() const { return folder_.path() / "config"; }
  const Motors& motors() const { return joints_.steps(); }
  double machine_s() const { return page_.time_s(); }

 private:
  LinuxCncAnswer Await(const std::string& what);
  std::optional<LinuxCncAnswer> Hear();
  void Turn();
  std::string Log() const;
  [[noreturn]] void Ended() const;

  LinuxCncOptions options_;
  /// Short, and without spaces, which halcompile cannot take.
  TemporaryFolder folder_{"caltwin_linuxcnc", "/tmp"};
  KeptLog kept_log_;
  linuxcnc::Joints joints_;
  linuxcnc::PlantPage page_;
  LinuxCncSandbox sandbox_{};
  std::string heard_{};
  Now::time_point last_cycle_ = Now::now();
};

std::string LinuxCncHost::Parts::Log() const {
  std::string text = "; it wrote last:";
  const std::string end = EndOfWritten(folder_.path() / "linuxcnc.log");
  for (const TextLine& line : LinesOf(end)) {
    if (TellsSomething(line.text)) text += "\n  " + Printable(line.text);
  }
  return text;
}

void LinuxCncHost::Parts::Ended() const {
  const std::string log = Log();
  if (log.find("unshare failed") == std::string::npos) {
    throw HostLost("LinuxCNC has ended" + log);
  }
  throw InputError({},
                   "this system allows no user namespaces, which LinuxCNC is run in",
                   "docs/linuxcnc.md says how a container allows them");
}

std::optional<LinuxCncAnswer> LinuxCncHost::Parts::Hear() {
  std::array<char, 4096> bytes{};
  const ssize_t num = recv(sandbox_.line(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (num > 0) heard_.append(bytes.data(), static_cast<std::size_t>(num));
  const auto end = heard_.find('\n');
  if (end == std::string::npos) {
    if (num == 0 || sandbox_.HasEnded()) Ended();
    return std::nullopt;
  }
  const auto said = nlohmann::json::parse(heard_.substr(0, end), nullptr, false);
  heard_.erase(0, end + 1);
  if (said.is_discarded()) throw HostLost("LinuxCNC's operator speaks no JSON" + Log());
  return AnswerIn(said);
}

// Some cycles, or a glance without one.
void LinuxCncHost::Parts::Turn() {
  constexpr milliseconds kGlance(20);
  for (int i = 0; i < kCyclesPerGlance; ++i) {
    if (!page_.Turn(kGlance)) return;
    last_cycle_ = Now::now();
    const int still = page_.still_cycles();
    if (still <= kStill_cycles || still > kDwell_cycles) continue;
    std::this_thread::sleep_for(kStillNap);
    return;
  }
}

LinuxCncAnswer LinuxCncHost::Parts::Await(const std::string& what) {
  const double start_s = page_.time_s();
  last_cycle_ = Now::now();
  while (true) {
    if (InterruptRequested()) throw HostLost("interrupted");
    Turn();
    if (auto answer = Hear()) {
      for (int i = 0; i < kSettle_cycles; ++i) page_.Turn(milliseconds(100));
      return *answer;
    }
    if (Now::now() - last_cycle_ > options_.patience) {
      throw HostLost(fmt::format("LinuxCNC has made no servo cycle for {:.0f} s{}",
                                 1e-3 * static_cast<double>(options_.patience.count()),
                                 Log()));
    }
    if (page_.time_s() - start_s > options_.longest_s) {
      throw HostLost(
          fmt::format("'{}' is not done after {:.0f} s of the machine's time",
                      what,
                      options_.longest_s));
    }
  }
}

LinuxCncAnswer LinuxCncHost::Parts::Obey(const nlohmann::json& order) {
  const std::string line =
      order.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  const ssize_t num = send(sandbox_.line(), line.data(), line.size(), MSG_NOSIGNAL);
  if (num != static_cast<ssize_t>(line.size())) {
    throw HostLost("LinuxCNC's operator has ended" + Log());
  }
  try {
    return Await(order.value("line", order.value("file", std::string("homing"))));
  } catch (const Jammed& jammed) {
    return {.errors = {jammed.what()}};
  }
}

LinuxCncHost::LinuxCncHost(Board* board, const LinuxCncOptions& options)
    : parts_(std::make_unique<Parts>(board, options)) {}

LinuxCncHost::~LinuxCncHost() = default;

LinuxCncAnswer LinuxCncHost::Home() {
  return parts_->Obey({{"do", "home"}});
}

LinuxCncAnswer LinuxCncHost::Mdi(std::string_view line) {
  RequireMdiLine(line, std::string(line.substr(0, 40)));
  return parts_->Obey({{"do", "mdi"}, {"line", line}});
}

LinuxCncAnswer LinuxCncHost::Program(const std::string& name, const std::string& text) {
  RequireText(text, name);
  WriteTextFile(parts_->config() / name, text);
  return parts_->Obey({{"do", "program"}, {"file", name}});
}

const Motors& LinuxCncHost::MotorsNow() const {
  return parts_->motors();
}

double LinuxCncHost::machine_s() const {
  return parts_->machine_s();
}

}  // namespace caltwin
