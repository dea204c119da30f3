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

/// A machine in a trial that LinuxCNC drives: `controller: {linuxcnc: ...}`. What the
/// truth says of where it then goes is the kind's.
class LinuxCncTrial : public KindTrial {
 public:
  LinuxCncTrial(const Machine& machine,
                std::unique_ptr<Board> board,
                UnderLinuxCnc asked);

  Link* wire() override { return &link_; }
  void Connect(Link* link) override { bench_.link = link; }
  Bench* bench() override { return &bench_; }
  void Finish(RunResult* result) override;

 protected:
  LinuxCncLink* link() { return &link_; }

 private:
  std::unique_ptr<Board> board_;
  LinuxCncLink link_;
  NoGauges gauges_{};
  NoHands hands_{};
  Bench bench_{};
};

}  // namespace caltwin
