#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/grbl/block.h"
#include "sim/firmware/grbl/memory.h"
#include "sim/firmware/motion.h"
#include "sim/firmware/pace.h"
#include "sim/machine/machine.h"

namespace caltwin::grbl {

/// What grbl 1.1h answers and does on a machine of three straight axes, written from
/// its documentation of the interface. docs/grbl.md says what is simpler.
///
/// Machine coordinates are grbl's: 0 at the upper end of each axis, negative below.
/// Lines come from one thread, the one that performs moves; the members under "from any
/// thread" serve bytes that act at once.
class Controller {
 public:
  using Lines = std::vector<std::string>;

  /// @param plant  keeps `pace`; both are borrowed
  /// @param stands_steps  of the motors, when it is switched on
  Controller(const Machine& machine,
             const Settings& believed,
             Plant* plant,
             Pace* pace,
             const Motors& stands_steps);

  /// Obeys one line: what is printed, `ok` or `error:n` last. After an alarm that
  /// grbl does not survive without a reset the answer ends with the new greeting.
  Lines Execute(std::string_view line);
  /// Moves that wait are performed one by one; what is printed of itself, an alarm.
  bool has_moves() const { return motion_.has_queued(); }
  Lines GoOn();
  /// Whether it obeys that line also while a move goes on; else it is to wait.
  bool TakesMeanwhile(std::string_view line) const;
  /// As a serial port that is opened does to the board: nothing is homed, the greeting.
  Lines SwitchOn();
  /// Ctrl-X; the pace is stopped by then. `in_motion`: it was InMotion() before that.
  Lines Reset(bool in_motion);
  /// The jog that is under way is over, those behind it too; the pace is stopped by
  /// then.
  void EndJogs();

  /// @name From any thread
  /// The answer to `?`; while only a reset helps there is none, an empty text.
  /// `rx_free`: bytes that its serial buffer still takes.
  std::string Status(std::size_t rx_free);
  /// `!`, where it means something: neither in an alarm nor while it checks or sleeps.
  void Hold();
  /// `~`.
  void Resume();
  bool is_jogging() const;
  /// Whether a reset now would lose the place.
  bool InMotion() const;
  /// A byte from 0x90: changes an override of feed, rapid or spindle.
  void Override(unsigned char byte);

  Vec3<double> machine_mm() const { return motion_.counted_mm(); }

 private:
  enum class Alarm {
    kHardLimit = 1,
    kSoftLimit = 2,
    kResetInMotion = 3,
    kProbeBefore = 4,
    kNoContact = 5,
    kResetInHoming = 6,
    kNoSwitch = 9
  };

  /// @name controller.cc
  void Obey(std::string_view line);
  /// An alarm of the motion: why is said beside it.
  void CheckMotion();
  void TakeSettings();
  void Publish();
  void Lock(Alarm alarm);
  /// What only a reset ends.
  void LockUntilReset(Alarm alarm);
  /// As after a reset; says the greeting.
  void Begin();
  void RunStartupLines();

  /// @name system_commands.cc: lines that begin with $
  void ObeySystem(std::string_view line);
  /// What needs the machine to stand still.
  void ObeyIdle(std::string_view line);
  void SwitchChecking();
  void ObeyAssignment(std::string_view line);
  void Restore(std::string_view what);
  void Home();
  void Jog(std::string_view line);
  void RequireIdle() const;

  /// @name program.cc: lines of G-code
  /// What a line does, once all of it has been read and found right.
  using Deeds = std::vector<std::function<void()>>;
  void ObeyBlock(Block block);
  void TakeFeed(Block* block) const;
  void TakeAlone(Block* block, Deeds* deeds);
  void TakeWorkplace(Block* block, Deeds* deeds);
  void TakeMotion(Block* block, Deeds* deeds);
  void EndProgram(int program);
  /// Where the program is; while it is only checked, nothing moves.
  Vec3<double> At_mm() const {
    return is_checking_ ? checked_mm_ : motion_.commanded_mm();
  }
  /// Where the axis words lead [mm]; they are used up.
  Vec3<double> TakeTarget_mm(Block* block) const;
  /// The value of a word that is a length.
  std::optional<double> TakeLength_mm(Block* block, char letter) const;
  void GoToPlace(const Vec3<double>& place_mm);
  void MoveTo(const Vec3<double>& target_mm, double feed_mm_s);
  void Probe(const Vec3<double>& target_mm, int mode);
  bool IsBeyondLimits(const Vec3<double>& target_mm) const;
  /// The overrides of feeds and rapids, as parts of one.
  std::array<double, 2> FeedAndRapidPart() const;
  bool RefuseBeyondLimits(const Vec3<double>& target_mm);

  /// @name arc.cc
  /// A circle's part in the plane of two axes, along the third a screw.
  struct Arc {
    std::array<Eigen::Index, 3> axes{};  ///< The two of the plane, then the other.
    Vec3<double> from_mm{}, to_mm{}, center_mm{};
    bool is_clockwise = false;
    double turn_rad() const;  ///< Counter-clockwise is positive.
    double length_mm() const;
  };
  Arc TakeArc(Block* block, const Vec3<double>& target_mm) const;
  void MoveAlong(const Arc& arc, double feed_mm_s);

  /// @name reports.cc
  Lines ParameterLines() const;
  std::string ModalLine() const;
  std::string ProbeLine() const;
  std::string Place(const Vec3<double>& at_mm) const;
  std::string StateName() const;

  Vec3<double> WorkOffset_mm(const Modal& modal) const;

  Machine machine_;    ///< In grbl's coordinates.
  Settings settings_;  ///< What Motion reads.
  Memory memory_;
  Motion motion_;
  Plant* plant_;
  Pace* pace_;

  Modal modal_{};
  Vec3<double> g92_mm_ = Vec3<double>::Zero();
  double tool_length_mm_ = 0;
  Vec3<double> probed_mm_ = Vec3<double>::Zero();
  bool has_probed_ = false;
  bool is_locked_ = false;  ///< By an alarm, or because it is not homed yet.
  bool needs_reset_ = false;
  bool is_checking_ = false;
  bool is_asleep_ = false;
  bool says_ok_ = true;
  bool begins_anew_ = false;    ///< Behind the ok of this line.
  bool is_performing_ = false;  ///< A move is on its way: GoOn has not returned.
  Vec3<double> checked_mm_ = Vec3<double>::Zero();  ///< Where $C has come.
  Lines said_{};

  /// What `?` tells of, as it last was between two lines.
  struct Live {
    bool is_locked = false, needs_reset = false, is_checking = false, is_asleep = false;
    bool is_homing = false, is_jogging = false;
    std::size_t waiting_moves = 0;
    Vec3<double> zero_steps = Vec3<double>::Zero(), offset_mm = Vec3<double>::Zero();
    std::array<double, 3> steps_per_mm{};
    std::string pins{};
    double spindle_rpm = 0;
    std::string accessories{};
    unsigned mask = 1;
    bool is_inches = false;
  };
  mutable std::mutex live_mutex_{};
  Live live_{};
  int until_offset_ = 0, until_overrides_ = 1;  ///< Reports until these are told again.
  int feed_percent_ = 100, rapid_percent_ = 100, spindle_percent_ = 100;
};

}  // namespace caltwin::grbl
