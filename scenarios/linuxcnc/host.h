#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/host_lost.h"
#include "scenarios/linuxcnc/config_files.h"
#include "sim/controllers/board.h"
#include "sim/controllers/linuxcnc/joints.h"

namespace caltwin {

struct LinuxCncOptions {
  LinuxCncFiles files{};           ///< The DISPLAY of its INI file is exchanged.
  std::vector<std::string> set{};  ///< In that file: SECTION.KEY=VALUE.
  linuxcnc::ProbeInput probe{};
  std::filesystem::path log{};  ///< Where what it printed is kept; empty: nowhere.
  /// So long it may compute without a servo cycle, by the computer's clock.
  std::chrono::milliseconds patience{10'000};
  double longest_s = 7200;  ///< One line or program, by the machine's clock.
};

/// What LinuxCNC makes of one order. Where the machine is Jammed it makes nothing of
/// it: that is the error, and it cannot be asked again.
struct LinuxCncAnswer {
  bool done = false;  ///< To its end, without an error.
  std::vector<std::string> errors{}, messages{};
  /// Where the probe met something, in machine coordinates, in order [mm]. A program's
  /// touch at exactly the place of the one before it is not among them.
  std::vector<std::array<double, 3>> probed_mm{};
  std::array<double, 3> position_mm{};  ///< Where LinuxCNC has the tool now.
};

/// An unmodified LinuxCNC in front of a machine, both in lock-step: its servo cycles go
/// on only while it is asked something, as fast as both compute. Between two orders it
/// stands still.
///
/// The same lines give the same coordinates. How many cycles pass while it is idle
/// differs from run to run.
///
/// Works in a TemporaryFolder and ends LinuxCNC whatever happens (LinuxCncSandbox).
/// Ctrl-C (InterruptRequested) ends it as HostLost.
class LinuxCncHost {
 public:
  /// Starts it and switches it on. `board` is borrowed. Throws HostLost; InputError
  /// where it cannot be started.
  LinuxCncHost(Board* board, const LinuxCncOptions& options);
  ~LinuxCncHost();
  LinuxCncHost(const LinuxCncHost&) = delete;
  LinuxCncHost& operator=(const LinuxCncHost&) = delete;

  /// All joints, in the order of HOME_SEQUENCE.
  LinuxCncAnswer Home();
  /// Throws InputError where the line is longer than LinuxCNC takes (RequireMdiLine).
  LinuxCncAnswer Mdi(std::string_view line);
  /// Runs a program to its end. `name`: as the file is called. Throws InputError where
  /// it is not UTF-8, which LinuxCNC's operator cannot take.
  LinuxCncAnswer Program(const std::string& name, const std::string& text);

  /// Where the motors stand, as the board counts.
  const Motors& MotorsNow() const;
  /// By LinuxCNC's clock, since it was started [s].
  double machine_s() const;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
