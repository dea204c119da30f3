#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/kind_trial.h"
#include "scenarios/kinds/nobody.h"
#include "scenarios/linuxcnc/host.h"
#include "scenarios/linuxcnc/under_linuxcnc.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A line to LinuxCNC: a block of G-code as typed at MDI, or kRunProgram. It is
/// started, and homed, with the first line.
class LinuxCncLink : public Link {
 public:
  /// `board` is borrowed.
  LinuxCncLink(Board* board, UnderLinuxCnc asked)
      : board_(board), asked_(std::move(asked)) {}

  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  /// Whether it was refused something, or was lost.
  bool has_failed() const { return has_failed_; }
  int touches() const { return touches_; }
  /// Where the motors stand, as the board counts; it was started.
  const Motors& MotorsNow() const { return host_->MotorsNow(); }
  double machine_time_s() const { return host_ ? host_->machine_s() - ready_s_ : 0; }

 private:
  Expected<std::vector<std::string>> Begin();
  Expected<std::vector<std::string>> Lines(const LinuxCncAnswer& answer);

  Board* board_;
  UnderLinuxCnc asked_;
  std::unique_ptr<LinuxCncHost> host_{};
  double ready_s_ = 0;
  int touches_ = 0;
  bool has_failed_ = false;
};

/// A place that LinuxCNC is sent to at the end, and whether the tip is looked at there.
struct Stop {
  Vec3<double> at_mm = Vec3<double>::Zero();
  bool is_looked_at = true;
};

/// How far the tip truly is from where it was sent, about the mean of all places. That
/// mean is where the part's zero goes.
struct PlacesReached {
  double zero_shift_mm = 0;
  double rms_mm = 0, p95_mm = 0, most_mm = 0;
};
PlacesReached ReachedBy(const std::vector<Vec3<double>>& errors_mm);

/// A machine in a trial that LinuxCNC drives: `controller: {linuxcnc: ...}`. After the
/// scenario's lines it is sent to places, and the truth looks where the tip is. The
/// figure is the p95 of how far it is off; before: where a controller would bring it
/// that knows what the firmware believes and corrects nothing. It has to fall to a
/// tenth, or to a motor's step, at least 2 um: switches are seen once a servo cycle.
class LinuxCncTrial : public KindTrial {
 public:
  LinuxCncTrial(const Machine& machine,
                std::unique_ptr<Board> board,
                UnderLinuxCnc asked);

  Link* wire() override { return &link_; }
  void Connect(Link* link) override { bench_.link = link; }
  Bench* bench() override { return &bench_; }
  void Finish(RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  /// Of a motor, along its own way.
  virtual double Step_mm() const = 0;
  /// In machine coordinates; nothing is in the way between any two that follow.
  virtual std::vector<Stop> Stops() const = 0;
  /// Where the tip truly is, the motors standing there as the board counts.
  virtual Vec3<double> Tip_mm(const Motors& steps) const = 0;
  /// How far it would be off at those stops without any correction.
  virtual std::vector<Vec3<double>> Uncorrected_mm(
      const std::vector<Stop>& stops) const = 0;

 private:
  std::optional<PlacesReached> Reached();

  std::unique_ptr<Board> board_;
  LinuxCncLink link_;
  std::optional<PlacesReached> before_{}, after_{};
  std::string refusal_{};  ///< Why it was not sent to all places.
  NoGauges gauges_{};
  NoHands hands_{};
  Bench bench_{};
};

}  // namespace caltwin
