#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/host_lost.h"
#include "sim/controllers/board.h"

namespace caltwin {

struct KlipperHostOptions {
  std::filesystem::path program{};   ///< Its start script; empty: HostProgram finds it.
  std::string config{};              ///< Its printer.cfg; `serial:` is exchanged.
  std::string name = "printer.cfg";  ///< What faults call it.
  std::string add{};                 ///< Further lines of it.
  std::filesystem::path
      beside{};                 ///< Where files are that it includes; empty: nowhere.
  std::filesystem::path log{};  ///< Where its log is kept; empty: nowhere.
  /// So long it may compute without asking for time, by the computer's clock.
  std::chrono::milliseconds patience{120'000};
  double longest_s = 7200;  ///< One line may take, by the printer's clock.
};

/// What the host says to one line of G-code.
struct HostAnswer {
  std::vector<std::string> lines{};      ///< What it printed, as it printed it.
  std::optional<std::string> refusal{};  ///< Why it did not do it, or not to its end.
  std::optional<std::string>
      shut_down{};             ///< Why the chip has stopped, or the machine.
  bool has_restarted = false;  ///< As after SAVE_CONFIG.
};

/// An unmodified host of the Klipper family in front of a machine, both in lock-step:
/// its time goes on only while it is asked something. The same lines give the same
/// answers and the same printer.cfg, however fast or busy the computer is.
///
/// Works in a TemporaryFolder. Ends the host whatever happens; a host whose caltwin was
/// killed ends by itself. Ctrl-C (InterruptRequested) ends it as HostLost.
class KlipperHost {
 public:
  /// Starts it and waits until it is ready. Throws HostLost; InputError where the host
  /// does not take its printer.cfg, or the program cannot be started.
  KlipperHost(Board* board, const KlipperHostOptions& options);
  ~KlipperHost();
  KlipperHost(const KlipperHost&) = delete;
  KlipperHost& operator=(const KlipperHost&) = delete;

  /// Sends a line as a page of the printer does, and waits for its end: of a restart
  /// too.
  HostAnswer Say(std::string_view line);

  /// Its printer.cfg as it stands now.
  std::string Config() const;
  /// Where the motors stand now, as the board counts.
  Motors MotorsNow() const;
  /// By the printer's clock, since the host was started [s].
  double printer_s() const;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
