#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/judge.h"
#include "scenarios/kind_scenario.h"
#include "scenarios/kind_trial.h"
#include "scenarios/kinds/nobody.h"
#include "scenarios/klipper/host.h"
#include "sim/base/rng.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/printer_cfg_text.h"

namespace caltwin {

/// What stands before what a person does, among the lines for the host.
inline const std::string kPersonDoes = "person: ";

/// A line to Klipper's own host: what it prints is the answer. The host is started with
/// the first line.
class HostLink : public Link {
 public:
  /// `board` is borrowed.
  HostLink(Board* board, KlipperHostOptions options)
      : board_(board), options_(std::move(options)) {}

  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  /// Its printer.cfg, with what it includes: as given, until it is started.
  std::string Config() const {
    return WithIncluded(host_ ? host_->Config() : options_.config, options_.beside);
  }
  /// Where its motors stand, as the board counts; nullopt: it was never started.
  std::optional<Motors> MotorsNow() const;
  int touches() const { return touches_; }  ///< That the host has told of.
  /// What a person does who is asked to: the lines that come of it.
  using Person =
      std::function<Expected<std::vector<std::string>>(std::string_view act)>;
  void Beside(Person person) { person_ = std::move(person); }
  double machine_time_s() const { return host_ ? host_->printer_s() - ready_s_ : 0; }

 private:
  Board* board_;
  KlipperHostOptions options_;
  std::unique_ptr<KlipperHost> host_{};
  Person person_{};
  double ready_s_ = 0;
  int touches_ = 0;
};

/// What every machine under the host asks of a height where the scenario asks for
/// nothing: a tenth of what it was, or 10 um.
TrueFigure Flattened(double before_mm, double after_mm);

/// A machine in a trial that Klipper's own host drives: `controller: {klipper: ...}`.
/// What the truth says of what the host saved is the kind's.
class KlipperTrial : public KindTrial {
 public:
  /// @param config  its printer.cfg as it begins
  KlipperTrial(const Machine& machine,
               std::unique_ptr<Board> board,
               KlipperHostOptions options,
               const Chance& chance);

  Link* wire() override { return &host_; }
  void Connect(Link* link) override { bench_.link = link; }
  Bench* bench() override { return &bench_; }
  void Finish(RunResult* result) override;

 protected:
  HostLink* host() { return &host_; }
  const std::string& config_before() const { return config_before_; }
  /// What a person does beside it who sees the truth: a word of PersonsActs().
  virtual Expected<std::vector<std::string>> PersonDoes(std::string_view act);
  /// How high the clean nozzle, or a probe's ball, truly is over what lies beneath it,
  /// the motors standing there as the board counts; nullopt: nobody can say.
  virtual std::optional<double> NozzleOverBed_mm(const Motors& /*steps*/) {
    return std::nullopt;
  }
  /// Types lines; what all of them are answered, or the first refusal.
  Expected<std::vector<std::string>> Typed(const std::vector<std::string>& lines);
  /// Where the motors stand once the host has gone there; nullopt where it refuses.
  std::optional<Motors> MotorsAfter(const std::vector<std::string>& lines);

 private:
  Expected<std::vector<std::string>> GaugeUnderNozzle(bool is_taken_off);

  std::unique_ptr<Board> board_;
  std::string config_before_;
  HostLink host_;
  NoGauges gauges_{};
  NoHands hands_{};
  Bench bench_{};
  Rng felt_;
};

}  // namespace caltwin
