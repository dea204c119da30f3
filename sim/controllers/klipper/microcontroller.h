#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/controllers/board.h"
#include "sim/controllers/klipper/dictionary.h"
#include "sim/controllers/klipper/formats.h"
#include "sim/controllers/klipper/objects.h"
#include "sim/controllers/klipper/wire.h"

namespace caltwin {
namespace klipper {

/// A microcontroller as the host of the Klipper family meets it on its serial line,
/// with a board behind its pins. Bytes and time in, bytes out: no clock and no
/// descriptor of its own, so that the same bytes at the same ticks give the same
/// answers.
///
/// Steps are not performed one by one: where the motors stand is a function of the
/// clock (StepQueue). While an endstop is watched its pin is looked at every 2 ms and,
/// where it has changed, the first sample that shows it is found by bisection; so a
/// pin that changes and changes back within 2 ms may be missed. An endstop that is
/// passed for a shorter time than that is none.
///
/// What a real one refuses, it refuses in the same words: it shuts down, and says why
/// to whatever comes next.
class Microcontroller {
 public:
  /// `board` is borrowed. At the first Advance it has been on for so long.
  explicit Microcontroller(Board* board);

  /// Time passes: whatever falls due up to and including `to` happens. Never back.
  void Advance(Clock to);
  /// Bytes from the host, at the time of the last Advance. Any bytes.
  void Receive(ByteView bytes);
  /// What is to be sent to the host, taken.
  Bytes TakeOutput();

  /// When something happens next by itself that the host would be told of, at the
  /// latest: while an endstop is watched, a look at it.
  std::optional<Clock> NextEvent() const;
  Clock now() const { return now_; }
  /// Where the motors stand then, as the board counts; not before the last Advance.
  Motors MotorsAt(Clock clock) const;
  /// Why it has stopped; nullopt: it has not.
  std::optional<std::string_view> shutdown() const;

 private:
  using Handler = void (Microcontroller::*)(const Message&);
  struct Command {
    std::string_view name;
    Handler obey;
    bool in_shutdown = false;  ///< Obeyed then too.
  };
  static const std::vector<Command>& Obeyed();

  /// @name The wire
  void Say(std::string_view response, const std::vector<Argument>& arguments);
  void Obey(const Message& message);
  void ObeyAll(ByteView payload);
  void ShutDown(std::string_view why);

  /// @name Time
  std::optional<Clock> NextOfObjects() const;
  Clock Horizon(Clock to) const;
  void WatchEndstops(Clock horizon);
  void Watch(Endstop* endstop, Clock horizon);
  std::optional<Clock> FirstHit(const Endstop& endstop, Clock horizon);
  bool ReadsAsAwaited(const Endstop& endstop, Clock clock);
  void GoTo(Clock clock);
  /// Takes the board along, from turning point to turning point: play depends on them.
  void Follow(Clock clock);
  bool IsWatching() const;
  void FireDue();
  void Fire(int oid, Stepper*) { static_cast<void>(oid); }
  void Fire(int oid, std::monostate*) { static_cast<void>(oid); }
  void Fire(int oid, TriggerSync* sync);
  void Fire(int oid, Endstop* endstop);
  void Fire(int oid, Output* output);
  void Fire(int oid, AnalogIn* analog);
  void Fire(int oid, Buttons* buttons);
  void Trigger(TriggerSync* sync, std::int64_t reason);
  void Report(int oid, const TriggerSync& sync, Clock clock);

  /// @name Objects
  /// The object of a message's `oid`, or of another of its arguments; null, and the
  /// chip has shut down, where it is of another type.
  template <typename T>
  T* Find(const Message& message, std::string_view name = "oid");
  void Add(const Message& message, Object object);
  /// The pin of that argument; it has shut down where there is none.
  std::optional<int> PinOf(const Message& message, std::string_view name);
  std::size_t NumMovesWaiting() const;
  /// Its `clock`, as time to act; it has shut down where that has passed.
  std::optional<Clock> TimeOf(const Message& message);
  void QueueChange(const Message& message, std::string_view value);
  void SendButtons(int oid, Buttons* buttons);
  void AddOutput(const Message& message, bool is_pwm);

  /// @name Commands
  void Identify(const Message& message);
  void GetUptime(const Message& message);
  void GetClock(const Message& message);
  void GetConfig(const Message& message);
  void AllocateOids(const Message& message);
  void FinalizeConfig(const Message& message);
  void EmergencyStop(const Message& message);
  void ClearShutdown(const Message& message);
  void ConfigReset(const Message& message);
  void ConfigStepper(const Message& message);
  void QueueStep(const Message& message);
  void SetNextStepDir(const Message& message);
  void ResetStepClock(const Message& message);
  void StepperGetPosition(const Message& message);
  void StepperStopOnTrigger(const Message& message);
  void ConfigTrsync(const Message& message);
  void TrsyncStart(const Message& message);
  void TrsyncSetTimeout(const Message& message);
  void TrsyncTrigger(const Message& message);
  void ConfigEndstop(const Message& message);
  void EndstopHome(const Message& message);
  void EndstopQueryState(const Message& message);
  void ConfigDigitalOut(const Message& message);
  void SetDigitalOutPwmCycle(const Message& message);
  void QueueDigitalOut(const Message& message);
  void UpdateDigitalOut(const Message& message);
  void SetDigitalOut(const Message& message);
  void ConfigPwmOut(const Message& message);
  void QueuePwmOut(const Message& message);
  void ConfigAnalogIn(const Message& message);
  void QueryAnalogIn(const Message& message);
  void ConfigButtons(const Message& message);
  void ButtonsAdd(const Message& message);
  void ButtonsQuery(const Message& message);
  void ButtonsAck(const Message& message);

  /// What repeats by itself does so no faster: 0.1 ms.
  static constexpr Clock kFastest = kTicksPerSecond / 10'000;

  Board* board_;
  Bytes dictionary_;
  Clock now_ = 0;
  BlockReader reader_{};
  int sequence_ = 1;  ///< Of the block that is expected next.
  Bytes output_{};
  std::vector<Object> objects_{};          ///< By oid.
  std::vector<std::int64_t> origin_{};     ///< Of each motor when it was configured.
  std::optional<std::int64_t> crc_{};      ///< Of the configuration, once it is final.
  std::optional<std::size_t> shutdown_{};  ///< Number of its words.
  Clock stats_at_ = 0;
};

template <typename T>
T* Microcontroller::Find(const Message& message, std::string_view name) {
  const auto oid = static_cast<std::size_t>(message[name]);
  T* const found = oid < objects_.size() ? std::get_if<T>(&objects_[oid]) : nullptr;
  if (found == nullptr) ShutDown("Invalid oid type");
  return found;
}

}  // namespace klipper
}  // namespace caltwin
