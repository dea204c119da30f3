#pragma once

#include <map>
#include <string>

#include "sim/base/rng.h"
#include "sim/firmware/firmware.h"
#include "sim/link/link.h"
#include "sim/measure/instrument.h"
#include "sim/twin/twin_plant.h"

namespace caltwin {

/// Simulated instruments: `laser.x` (where the tip is along x), `dial.x` (the same,
/// relative to its zero), `calliper.block.x` (size of an artefact along x),
/// `calliper.tip` (the ball's diameter). Each has the noise and resolution declared for
/// its id or kind; without a declaration it is ideal. Shows readings, never the truth.
class TwinGauge final : public Gauge {
 public:
  /// All are borrowed. `firmware` is asked to finish its moves before a reading.
  TwinGauge(Instruments instruments,
            TwinPlant* plant,
            Firmware* firmware,
            std::uint64_t seed,
            std::uint64_t sample);

  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;

 private:
  Expected<double> Truth_mm(const std::string& id);
  double Reading_mm(const std::string& id, double truth_mm);

  Instruments instruments_;
  TwinPlant* plant_;
  Firmware* firmware_;
  std::map<std::string, double> zeros_mm_{};
  std::uint64_t seed_;
  std::uint64_t sample_;
  std::map<std::string, Rng> noise_{};
};

/// Does at once what is asked: turns blocks, changes the stylus, confirms everything.
class TwinOperator final : public Operator {
 public:
  TwinOperator(TwinPlant* plant, Firmware* firmware);
  Expected<void> Do(const Act& act) override;

 private:
  TwinPlant* plant_;
  Firmware* firmware_;
};

}  // namespace caltwin
