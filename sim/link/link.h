#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

namespace caltwin {

/// Why a machine, a gauge or an operator did not do what was asked. Expected in any
/// machine shop, so a value and never an exception.
struct MachineFault {
  enum class Kind {
    kAlarm,  ///< The machine stopped itself: a collision, a switch, an emergency stop.
    kRefused,    ///< It did not do it and says why: out of limits, not homed, "no".
    kNoTrigger,  ///< A probe move ended without the contact it was to find.
    kTimeout,
    kLinkLost
  };
  Kind kind = Kind::kRefused;
  std::string reply;  ///< In the machine's own words.
};

template <typename T>
using Expected = tl::expected<T, MachineFault>;

/// A wire to a machine that speaks G-code: the simulated one or a real one.
///
/// This is all that calibration may know of a machine. The simulator's truth (real
/// gaps, real angles, real positions) is not reachable through it, so a calibration
/// that works here has not cheated.
class Link {
 public:
  virtual ~Link() = default;

  /// Sends one line and waits for its `ok`.
  /// @param line  without newline, e.g. "G38.2 Z-20 F60" [mm, mm/min]
  /// @param patience  how long the move may take, beyond which the fault is kTimeout
  /// @return the reply lines before "ok"; a fault where the machine alarmed, refused
  ///   ("Error: ...") or fell silent
  virtual Expected<std::vector<std::string>> Send(
      std::string_view line, std::chrono::milliseconds patience) = 0;

  /// Says a line at once, past whatever waits for its answer, from any thread: an
  /// emergency stop. Its own answer is not read. false: this wire knows no such way.
  virtual bool Interject(std::string_view /*line*/) { return false; }
};

/// Reads what no controller can say: callipers, dial indicators, lasers, at standstill.
class Gauge {
 public:
  virtual ~Gauge() = default;

  /// One reading [mm] of the instrument and quantity `id`: `laser.x` (where the moving
  /// part is along x), `dial.x` (the same, relative to its last zero),
  /// `calliper.block.x` (the size of artefact `block` along x), `calliper.tip` (the
  /// ball's diameter).
  virtual Expected<double> Read_mm(std::string_view id) = 0;
  /// Zeroes a dial where it stands now.
  virtual Expected<void> Zero(std::string_view id) = 0;
};

/// Something a person must do or decide.
struct Act {
  enum class Kind {
    kConfirm,    ///< May this be applied? Refused means no.
    kTurnBlock,  ///< Put `artefact` (a 1-2-3 block) with `length_mm` along `axis`.
    kFitStylus,  ///< Fit the stylus `artefact`: "ball" or "disc".
    kOther       ///< Only `text` says what.
  };
  Kind kind = Kind::kOther;
  std::string text;  ///< What the person reads.
  std::string artefact{};
  char axis = 'x';
  double length_mm = 0;
};

/// A person at the machine, or what stands in for one.
class Operator {
 public:
  virtual ~Operator() = default;
  /// Asks for an act and waits until it is done; kRefused where the answer is no.
  virtual Expected<void> Do(const Act& act) = 0;
};

}  // namespace caltwin
