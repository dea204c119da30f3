#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/firmware/kinds/delta/marlin.h"
#include "sim/kinds/delta/calliper.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/kinds/delta_rows.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// What a G33 made of its touches.
struct G33Answer {
  DeltaModel<double> settings{};
  std::vector<std::string> lines{};  ///< That it prints.
  double said_mm = 0;                ///< The deviation that it prints as its own.
  bool stows = false;                ///< The probe, before each touch.
};
/// One touch of the bed: what the motors counted; nullopt: out of reach.
using TouchOfBed = std::function<std::optional<Vec3<double>>(
    const DeltaModel<double>& settings, double x_mm, double y_mm)>;
/// The calibration that the controller has inside. Who writes engines gives it one; the
/// twin only touches for it. Throws InputError for words that it does not take.
using G33Program = std::function<G33Answer(const GcodeCommand& words,
                                           const DeltaModel<double>& settings,
                                           const Vec3<double>& probe_offset_mm,
                                           const TouchOfBed& touch)>;

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
  /// What a person with a calliper reads.
  SimulatedDeltaCalliper& calliper() { return calliper_; }

  const DeltaTwinConfig& config() const { return config_; }
  const MarlinDelta& marlin() const { return marlin_; }
  /// Which G33 the controller has; none: it says so.
  void SetG33(G33Program g33) { g33_ = std::move(g33); }
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
  DeltaTwinPlant plant_;
  DeltaRows rows_;
  SimulatedDeltaCalliper calliper_;
  MarlinDelta marlin_;
  EmulatedLink wire_;
  G33Program g33_{};
  double said_mm_ = 0;
  int g33_touches_ = 0, g33_stows_ = 0;
};

}  // namespace caltwin
