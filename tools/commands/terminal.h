#pragma once

#include <map>
#include <string>

#include "sim/link/link.h"

namespace caltwin {

/// Whether a person can be asked: stdin is a terminal.
bool CanAsk();

/// The person at the terminal as Operator: prints what is to be done and waits for
/// Enter; of a confirmation for y or n. Refuses where nobody can be asked.
class TerminalOperator final : public Operator {
 public:
  struct Options {
    bool apply = false;  ///< false: every confirmation is answered with no, unasked.
    bool yes = false;    ///< Everything is done and confirmed without asking.
  };
  explicit TerminalOperator(Options options) : options_(options) {}
  Expected<void> Do(const Act& act) override;

 private:
  Options options_;
};

/// The person at the terminal as Gauge: asks for a reading, unless it was given.
class TerminalGauge final : public Gauge {
 public:
  /// `given`: readings by id [mm], such as calliper.block.x; used whenever asked for.
  explicit TerminalGauge(std::map<std::string, double> given)
      : given_(std::move(given)) {}
  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;

 private:
  std::map<std::string, double> given_;
};

/// Confirms only where applying was asked for, and leaves acts to another operator: for
/// a twin, whose own hands turn the block.
class ConfirmingOperator final : public Operator {
 public:
  /// `hands` are borrowed.
  ConfirmingOperator(TerminalOperator::Options options, Operator* hands)
      : confirmations_(options), hands_(hands) {}
  Expected<void> Do(const Act& act) override {
    return act.kind == Act::Kind::kConfirm ? confirmations_.Do(act) : hands_->Do(act);
  }

 private:
  TerminalOperator confirmations_;
  Operator* hands_;
};

}  // namespace caltwin
