#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/loop/contact_ahead.h"
#include "calibration/loop/probe_reading.h"
#include "sim/link/link.h"
#include "sim/machine/axis.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin {

/// The number behind the axis letter in a controller's reply: 800.12 in "Steps/mm: X:
/// 800.120, Y: ..."; nullopt where the letter does not stand alone before a number.
std::optional<double> NumberAfter(std::string_view reply, char letter);

/// Motor steps of M114: the three numbers behind "Count". nullopt where there are none.
std::optional<Vec3<double>> CountOf(std::string_view reply);

/// What a fault is, by the words of the controllers we know: a probe move without
/// contact, an alarm, or a refusal.
MachineFault Classified(MachineFault fault);

/// Whether the words of a fault say that the stylus was bent.
bool IsCollision(const MachineFault& fault);

/// The conversation with a RepRapFirmware controller in units of our own: mm, mm/s.
/// Keeps what it was told: position, sense of the last move of each axis, settings.
class Controller {
 public:
  /// `link` is borrowed. `drawing` gives limits and feeds.
  Controller(Link* link, const Machine& drawing);

  Expected<std::vector<std::string>> Send(const std::string& line);

  /// Reads M92, M425 and the globals that NeXT keeps; what a controller does not tell
  /// stays as it was.
  Expected<void> ReadSettings();
  const Settings& settings() const { return settings_; }
  /// What was written with more digits than the controller prints.
  void Remember(const Settings& exact);
  Expected<void> WriteStepsPerMm(Axis axis, double steps_per_mm);
  Expected<void> WriteBacklash(Axis axis, double gap_mm);
  /// One value an axis: `global.nxtProbeDeflection = {x, y, z}`.
  Expected<void> WriteDeflection(Axis axis, double deflection_mm);
  /// The seed's single number, meant for every axis.
  Expected<void> WriteSingleDeflection(double deflection_mm);

  Expected<bool> IsHomed();
  /// All axes: Z first and out of the way, as the machine's own G28 does.
  Expected<void> Home();
  /// A straight move to a place in machine coordinates; what is not changed is not
  /// named. At most `feed_mm_s`; 0: as fast as the drawing allows.
  Expected<void> MoveTo(const Vec3<double>& target_mm, double feed_mm_s = 0);
  /// G38.2: towards `target_mm` until the probe triggers.
  Expected<void> ProbeTowards(const Vec3<double>& target_mm, double feed_mm_s);
  /// G38.4: away until it releases.
  Expected<void> ProbeAway(const Vec3<double>& target_mm, double feed_mm_s);
  /// The probe move that was begun last and did not end in a touch, if it was the last.
  const std::optional<ProbeMove>& failed_probe_move() const { return probe_move_; }
  /// What the probe reads now; kUnknown of a controller that does not say.
  ProbeReading ReadProbe();
  /// Tip centre in machine coordinates, from whole motor steps (M114 Count, without
  /// backlash steps) over the steps per mm believed, of the drives.
  Expected<Vec3<double>> ReadPosition_mm();
  /// Where it was last commanded to, or read.
  const Vec3<double>& position_mm() const { return position_mm_; }
  /// Sense of each axis's last move, +1 or -1; NaN: unknown.
  const Vec3<double>& direction() const { return direction_; }
  void set_direction(const Vec3<double>& sense) { direction_ = sense; }
  /// The same of each drive, where drives move the axes together.
  const Vec3<double>& drive_direction() const { return drive_direction_; }
  void set_drive_direction(const Vec3<double>& sense) { drive_direction_ = sense; }
  /// Where its drives move the axes together: what they were told for `row.cmd_mm`, and
  /// in which sense they moved last.
  void NoteMotors(Row* row) const;
  /// Restarts the controller (M999); it has to be homed again.
  Expected<void> Restart();

 private:
  /// Numbers in a global variable's text; none where there is no such variable.
  Expected<std::vector<double>> ReadGlobal(const std::string& name);
  Expected<void> Move(const char* command,
                      const Vec3<double>& target_mm,
                      double feed_mm_s);
  void NoteMove(const Vec3<double>& target_mm);

  Link* link_;
  Machine drawing_;
  Settings settings_{};
  std::optional<ProbeMove> probe_move_{};  ///< Begun, not ended.
  Vec3<double> position_mm_;
  Vec3<double> direction_;
  Vec3<double> drive_direction_;
};

}  // namespace caltwin
