#include "scenarios/klipper/host.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "scenarios/host_log.h"
#include "scenarios/interrupt.h"
#include "scenarios/klipper/host_api.h"
#include "scenarios/klipper/host_process.h"
#include "sim/base/input_error.h"
#include "sim/base/temporary_folder.h"
#include "sim/base/text_file.h"
#include "sim/controllers/klipper/lock_step.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/link/pseudo_terminal.h"
#include "sim/measure/import/printer_cfg.h"
#include "sim/measure/import/printer_cfg_text.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using klipper::LockStep;

/// The host takes a line whose path begins so as it is, without the settings of a
/// serial port.
constexpr std::string_view kFolders = "klipper_host_caltwin";

// What the host includes stands beside its printer.cfg; it may read it there, and write
// nothing back.
void LinkNeighbours(const fs::path& from, const fs::path& to) {
  if (from.empty()) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(from)) {
    std::error_code is_there_already;
    fs::create_symlink(
        fs::absolute(entry.path()), to / entry.path().filename(), is_there_already);
  }
}

// What makes the host keep its variables in a copy: a person's own file stays as it is.
// Empty: it keeps none.
std::string OwnVariables(const KlipperHostOptions& options, const fs::path& folder) {
  const std::string whole =
      WithIncluded(WithAdded(options.config, options.add), options.beside);
  const PrinterCfg cfg(whole, options.name);
  const CfgSetting* const setting = cfg.Find("save_variables", "filename");
  if (setting == nullptr) return "";
  fs::path from = setting->value.text;
  const char* const home = std::getenv("HOME");
  if (setting->value.text.starts_with("~/") && home != nullptr) {
    from = fs::path(home) / setting->value.text.substr(2);
  }
  const fs::path copy = folder / "variables_of_caltwin.cfg";
  std::error_code is_not_there;
  fs::copy_file(options.beside / from, copy, is_not_there);
  return fmt::format("[save_variables]\nfilename: {}\n", copy.string());
}

}  // namespace

// Everything of one host, in the order in which it is needed.
class KlipperHost::Parts {
 public:
  Parts(Board* board, const KlipperHostOptions& options)
      : options_(options),
        kept_log_(folder_.path() / "klippy.log", options.log),
        terminal_(folder_.path() / "serial", "the host's serial line"),
        api_(folder_.path() / "api"),
        lock_step_(board, terminal_.number(), process_.clock()) {
    // What is written last counts.
    added_ = fmt::format("[mcu]\nserial: {}\n", fs::path(terminal_.path()).string()) +
             OwnVariables(options, folder_.path());
    WriteTextFile(config(), WithAdded(WithAdded(options.config, options.add), added_));
    LinkNeighbours(options.beside, folder_.path());
    const fs::path program =
        options.program.empty() ? HostProgram("") : options.program;
    process_.Start(program, folder_.path());
    WaitUntilReady();
  }
  HostAnswer Say(std::string_view line);
  void Hear(HostAnswer* answer);
  std::string Config() const {
    std::string now = WrittenIn(config());
    const std::size_t at = now.find(added_);
    return at == std::string::npos ? now : now.erase(at, added_.size());
  }
  fs::path config() const { return folder_.path() / "printer.cfg"; }
  std::string LogEnd() const;
  double printer_s() const { return lock_step_.host_s(); }
  Motors MotorsNow() const {
    return lock_step_.chip().MotorsAt(lock_step_.chip().now());
  }

 private:
  void WaitUntilReady();
  void Run(const std::function<bool()>& is_done);
  nlohmann::json Info();

  KlipperHostOptions options_;
  TemporaryFolder folder_{kFolders, "/tmp"};
  std::string added_{};  ///< Lines for the twin, not the person's.
  KeptLog kept_log_;
  PseudoTerminal terminal_;
  HostApi api_;
  HostProcess process_{};
  LockStep lock_step_;
};

std::string KlipperHost::Parts::LogEnd() const {
  const std::string printed = EndOfWritten(folder_.path() / "host.log");
  return printed.empty() ? EndOfWritten(folder_.path() / "klippy.log") : printed;
}

void KlipperHost::Parts::Run(const std::function<bool()>& is_done) {
  switch (lock_step_.Run(is_done, options_.patience, &InterruptFlag())) {
    case LockStep::End::kDone:
      return;
    case LockStep::End::kStopped:
      throw HostLost("interrupted");
    case LockStep::End::kHostEnded:
      throw HostLost("the host has ended; it wrote last:\n" + LogEnd());
    case LockStep::End::kHostSilent:
      throw HostLost(
          fmt::format("the host has worked for {} s without waiting for anything; it "
                      "wrote last:\n{}",
                      options_.patience.count() / 1000,
                      LogEnd()));
  }
}

// What it says of itself; not before it listens.
nlohmann::json KlipperHost::Parts::Info() {
  nlohmann::json info;
  std::optional<int> asked;
  Run([&] {
    if (!api_.is_open() && !api_.Open()) return false;
    api_.Receive();
    if (!api_.is_open()) asked.reset();  // It begins anew.
    if (api_.is_open() && !asked) asked = api_.Ask("info", nlohmann::json::object());
    const auto answer = asked ? api_.TakeAnswer(*asked) : std::nullopt;
    if (answer) info = *answer;
    return answer.has_value();
  });
  return info;
}

void KlipperHost::Parts::WaitUntilReady() {
  constexpr double kPatience_s = 60, kBetween_s = 0.2;
  const double until_s = printer_s() + kPatience_s;
  for (;;) {
    const nlohmann::json answer = Info();
    const nlohmann::json info = answer.value("result", nlohmann::json::object());
    const std::string state = info.value("state", "");
    if (state == "ready") break;
    const std::string says = info.value("state_message", "");
    if (state == "error" && says.find("mcu") == std::string::npos) {
      throw InputError(PlaceOfComplaint(says, options_.config, options_.name),
                       "the host does not take it: " + says.substr(0, says.find('\n')));
    }
    if (state != "startup" || printer_s() > until_s) {
      throw HostLost(fmt::format("the host is not ready but in {}: {}", state, says));
    }
    const double again_s = printer_s() + kBetween_s;
    Run([&] { return printer_s() >= again_s; });
  }
  const int asked = api_.Ask("gcode/subscribe_output",
                             {{"response_template", nlohmann::json::object()}});
  Run([&] {
    api_.Receive();
    return api_.TakeAnswer(asked).has_value();
  });
}

// What it prints until then, and whether it begins anew.
void KlipperHost::Parts::Hear(HostAnswer* answer) {
  api_.Receive();
  for (std::string& printed : api_.TakePrinted()) {
    if (printed.find("Klipper state: Disconnect") != std::string::npos) {
      answer->has_restarted = true;
    }
    const std::size_t unknown = printed.find("Unknown command:");
    if (unknown != std::string::npos && !answer->refusal) {
      answer->refusal = printed.substr(unknown);
    }
    answer->lines.push_back(std::move(printed));
  }
  if (!api_.is_open()) answer->has_restarted = true;
}

HostAnswer KlipperHost::Parts::Say(std::string_view line) {
  HostAnswer answer;
  const double until_s = printer_s() + options_.longest_s;
  const int asked = api_.Ask("gcode/script", {{"script", std::string(line)}});
  bool is_over = false;
  Run([&] {
    Hear(&answer);
    const auto said = api_.TakeAnswer(asked);
    if (said && said->contains("error")) {
      answer.refusal = (*said)["error"].value("message", said->dump());
    }
    is_over = said || !api_.is_open();
    return is_over || printer_s() > until_s;
  });
  if (!is_over) {
    throw HostLost(fmt::format("'{}' has not ended after {} s of the printer's time",
                               line,
                               options_.longest_s));
  }
  // A stop or a restart that it was told to do follows its answer; to begin anew the
  // host may first stop the chip.
  constexpr double kSettles_s = 0.002, kRestarts_s = 3;
  const auto hear_for = [&](double s) {
    const double until_s = printer_s() + s;
    Run([&] {
      Hear(&answer);
      return answer.has_restarted || printer_s() >= until_s;
    });
  };
  hear_for(kSettles_s);
  if (!answer.has_restarted && lock_step_.chip().shutdown()) hear_for(kRestarts_s);
  if (answer.has_restarted) {
    Run([&] {
      api_.Receive();
      return !api_.is_open();
    });
    WaitUntilReady();
  }
  if (const auto why = lock_step_.chip().shutdown())
    answer.shut_down = std::string(*why);
  return answer;
}

KlipperHost::KlipperHost(Board* board, const KlipperHostOptions& options)
    : parts_(std::make_unique<Parts>(board, options)) {}

KlipperHost::~KlipperHost() = default;

HostAnswer KlipperHost::Say(std::string_view line) {
  try {
    return parts_->Say(line);
  } catch (const Jammed& jammed) {
    return {.shut_down = jammed.what()};
  }
}

std::string KlipperHost::Config() const {
  return parts_->Config();
}

Motors KlipperHost::MotorsNow() const {
  return parts_->MotorsNow();
}

double KlipperHost::printer_s() const {
  return parts_->printer_s();
}

}  // namespace caltwin
