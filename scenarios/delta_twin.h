#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/g33.h"
#include "scenarios/delta_link.h"
#include "sim/firmware/dialects/marlin_delta.h"
#include "sim/kinds/delta/calliper.h"
#include "sim/kinds/delta/plant.h"
#include "sim/kinds/delta/record.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// All that a simulated delta is made of.
struct DeltaTwinConfig {
  Machine machine{};
  BuiltDelta built{};
  DeltaModel<double> settings{};  ///< What the firmware wrongly believes at power-up.
  double calliper_sigma_mm = 0.02;
  Fidelity fidelity = Fidelity::kPhysics;
  std::uint64_t seed = 1;
  std::uint64_t sample = 0;
};

/// A simulated delta behind a wire: its controller speaks Marlin's dialect, G33 runs
/// inside it, and every touch is written down as a measured row.
class DeltaTwin {
 public:
  explicit DeltaTwin(const DeltaTwinConfig& config);
  DeltaTwin(const DeltaTwin&) = delete;
  DeltaTwin& operator=(const DeltaTwin&) = delete;

  Link& link() { return wire_; }
  /// A person with a calliper, who reads rods and prints. Borrows this.
  DeltaCalliper Calliper();

  const DeltaTwinConfig& config() const { return config_; }
  const MarlinDelta& marlin() const { return marlin_; }
  /// Which G33 the controller has.
  void SetG33Variant(G33Variant variant) { g33_variant_ = variant; }
  /// The deviation that the last G33 printed as its own; 0 before any.
  double said_mm() const { return said_mm_; }
  /// Touches and time, G33's own among them.
  int touches() const { return marlin_.touches() + g33_touches_; }
  double machine_time_s() const;

  /// @name What is written down
  /// Rows from here on belong to `campaign`; their tip stands where M851 has it.
  void BeginRecord(const std::string& campaign);
  const DeltaRecord& record() const { return record_; }

 private:
  std::vector<std::string> AnswerG33(const GcodeCommand& words,
                                     DeltaModel<double>* settings);

  DeltaTwinConfig config_;
  DeltaRecord record_{};
  DeltaTwinPlant simulated_;
  RecordingDeltaPlant plant_;
  SimulatedDeltaCalliper calliper_;
  MarlinDelta marlin_;
  MarlinDeltaWire wire_;
  G33Variant g33_variant_ = G33Variant::kCorrected;
  double said_mm_ = 0;
  int g33_touches_ = 0, g33_stows_ = 0;
};

}  // namespace caltwin
