#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/base/rng.h"
#include "sim/effects/surroundings.h"
#include "sim/kinds/perform.h"

namespace caltwin {

/// What both fidelities know of the rows to be performed.
class Readings {
 public:
  /// `config` is borrowed.
  Readings(const PerformConfig& config, const std::vector<Row>& rows);

  const Settings& SettingsFor(const Row& row) const;
  /// Everything that is known of the reading. Borrows the row's texts.
  At AtFor(const Row& row) const;
  /// The same touch, had it read `value_mm`.
  static At WithValue(At at, const Row& row, double value_mm);

  /// The reading as it is shown: of a touch the nearest whole steps of the motors, then
  /// noise and resolution of the campaign's instrument and, for a touch, `scatter_mm`
  /// times chance. Draws, so call it once a row in the rows' order.
  double Shown_mm(const Row& row, const At& at, double value_mm, double scatter_mm);
  /// The nearest position that whole motor steps can reach.
  Vec3<double> Reachable_mm(const Vec3<double>& q_mm, const Settings& settings) const;

 private:
  const Instrument& InstrumentFor(const Row& row) const;
  const PerformConfig& config_;
  Surroundings surroundings_;
  std::map<std::string, Settings> settings_{};
  Rng noise_;
  Rng scatter_;
};

}  // namespace caltwin
