#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calibration/loop/bench.h"
#include "scenarios/kind_scenario.h"
#include "scenarios/kinds/nobody.h"
#include "scenarios/machine_file.h"
#include "tools/commands/calibrate.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// What `caltwin calibrate` has before it: a machine at the end of a wire, or a twin,
/// with who and what stands at it. One class a kind of machine (tools/commands/kinds);
/// the command leads every one the same way:
///
///   Connect, Begin, (BeforeStep, the step) for each, End
class Desk {
 public:
  virtual ~Desk() = default;
  /// The machine's own wire.
  Link* wire() const { return link_; }
  /// What procedures work on.
  Bench* bench() { return &bench_; }
  /// A twin's own hands, without a person to confirm; null where it has none.
  Operator* hands() const { return hands_; }

  /// From now on everything is said over `link`: the wire, with others listening in.
  virtual void Connect(Link* link) { bench_.link = link; }
  /// What comes before the first procedure; nullopt: nothing.
  virtual std::optional<ProcedureResult> Begin() { return std::nullopt; }
  virtual void BeforeStep(const CalibrationStep& /*step*/) {}
  /// Puts back what is not to stay.
  virtual void End() {}
  /// The last sentence; empty: none.
  virtual std::string Farewell() const;

 protected:
  /// Opens the link, unless it is a twin's, and puts the person and the gauges of the
  /// terminal there.
  Desk(const CalibrateOptions& options, const TwinOptions& papers);

  bool is_twin() const { return is_twin_; }
  /// A twin in place of a wire.
  void Take(std::shared_ptr<void> twin, Link* link) {
    twin_ = std::move(twin);
    link_ = link;
  }
  void Take(std::unique_ptr<Operator> person) {
    person_ = std::move(person);
    bench_.person = person_.get();
  }
  void SetHands(Operator* hands) { hands_ = hands; }
  /// Who answers: at the terminal, and on a twin yes where nobody is there.
  static TerminalOperator::Options AnswersFor(const CalibrateOptions& options);

  Bench bench_{};

 private:
  bool is_twin_;
  bool applies_;
  std::unique_ptr<Operator> person_;
  std::unique_ptr<TerminalGauge> gauge_;
  std::unique_ptr<Link> opened_{};
  std::shared_ptr<void> twin_{};
  Link* link_ = nullptr;
  Operator* hands_ = nullptr;
};

/// How machines of one kind are calibrated from the command line.
struct DeskKind {
  /// As Procedure::kind; empty: machines that are led like a gantry.
  std::string_view kind{};
  /// Throws InputError for options that it does not heed.
  void (*refuse)(const CalibrateOptions& options,
                 const TwinOptions& papers,
                 const std::optional<MachineFile>& file) = nullptr;
  /// `papers`: of the bench file. `file`: the machine; nullopt: none is named.
  std::unique_ptr<Desk> (*make)(const CalibrateOptions& options,
                                const TwinOptions& papers,
                                const std::optional<MachineFile>& file) = nullptr;
};

}  // namespace caltwin
