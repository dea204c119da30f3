#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/bed_probing.h"
#include "sim/firmware/emulated_controller.h"
#include "sim/firmware/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// How the probe reaches its controller.
enum class ProbeInput {
  kWired,    ///< As it should.
  kMissing,  ///< No probe is configured (M558): probe moves are refused.
  kOpen,     ///< It never reads triggered: a broken cable, another pin.
  kStuck     ///< It always reads triggered: a short, an inverted pin.
};

/// What distinguishes one controller from another of the same dialect.
struct FirmwareOptions {
  /// RepRapFirmware before 3.6.1 ignored backlash steps when it recomputed the position
  /// after M400.
  bool m400_ignores_backlash = false;
  /// The files of the controller's own storage, by path ("sys/nxt-user-vars.g");
  /// start-up runs nxt-user-vars.g where it is there.
  std::map<std::string, std::string> files{};
  /// Of a bed on screws: what M671 has said before the first line.
  std::optional<Leadscrews> leadscrews{};
  double probe_recovery_s = 0;  ///< M558 R: at rest before a touch of the bed.
  ProbeInput probe = ProbeInput::kWired;
  /// Of a bed on screws: the motor, from 0, that stays when it is an axis of its own
  /// (M584 names a driver for it that is not there).
  std::optional<int> still_alone{};
};

/// A controller that understands RepRapFirmware's G-code (3.6.1, CNC mode) and drives a
/// Plant. docs/firmware.md lists the commands and where the model is simpler than the
/// real one.
///
/// Moves wait in a queue, so that consecutive ones can be blended, and are performed
/// when the queue is full or a command needs the machine at rest (G4 G28 G38 G92 M92
/// M114 M400 M409 ...). The getters tell of the moves performed so far; call
/// FinishMoves first to learn of all of them.
class Firmware final : public EmulatedController {
 public:
  /// Switches the controller on: believes `settings`, then runs sys/nxt-user-vars.g
  /// where `options.files` has it. `plant` is borrowed.
  Firmware(const Machine& machine,
           const Settings& settings,
           const FirmwareOptions& options,
           Plant* plant);
  ~Firmware() override;
  Firmware(Firmware&&) noexcept;

  Reply Execute(std::string_view line) override;
  /// Performs what waits in the queue; an error where the machine alarmed on the way.
  Reply FinishMoves();

  /// An alarm or M112 stopped the machine; only M999 helps.
  bool halted() const;
  double machine_time_s() const override;
  /// What is believed now: M92, M425, and the globals nxtProbeDeflection (one number,
  /// or {x, y, z}) and nxtProbeTipRadius.
  const Settings& settings() const;
  /// Machine coordinates of the tip's centre as the controller believes them: whole
  /// steps divided by steps per mm, backlash steps excluded.
  Vec3<double> position_mm() const;
  /// Where the motors stand, as in Segment: absolute, whole, backlash steps included.
  const Motors& motor_steps() const;
  /// Sense of each axis's last move: +1, -1; 0 where it has not moved since start-up.
  Vec3<double> direction() const;

  /// @name A bed that is probed (G30)
  bool is_homed(Axis axis) const;
  /// Where it believes the screws to stand; only with options.leadscrews.
  const Pivots<double>& leadscrews_mm() const;
  /// How much higher than z alone has it each screw is told to stand, whole steps.
  Vec3<double> raised_mm() const;
  /// Every touch of G30, in order.
  const std::vector<ProbedPoint>& probed() const;

  /// The controller's own storage, by path without drive or leading slash.
  const std::map<std::string, std::string>& files() const;
  void WriteFile(const std::string& path, const std::string& text);

  struct Parts;  ///< The inside; only sim/firmware knows it.

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
