#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/firmware/firmware.h"
#include "sim/link/link.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/measure/instrument.h"
#include "sim/twin/twin_plant.h"

namespace caltwin {

enum class Fidelity { kPhysics, kFast };
std::string ToString(Fidelity fidelity);

/// Everything a twin is made of. `artefacts` lie as drawn; effects that move or resize
/// them act on top.
struct TwinConfig {
  Machine machine{};
  std::vector<Injected> effects{};
  Settings settings{};  ///< What the firmware wrongly believes at power-up.
  std::vector<Artefact> artefacts{};
  Instruments instruments{};
  Fidelity fidelity = Fidelity::kPhysics;
  FirmwareOptions firmware{};
  std::uint64_t seed = 1;
  std::uint64_t sample = 0;
};

/// The machine alone, for another controller than RepRapFirmware's.
std::unique_ptr<TwinPlant> MakeTwinPlant(const TwinConfig& config);

/// A simulated machine with its firmware, instruments and operator. Calibration sees
/// the three interfaces only; the rest is the simulator's truth, for tests, scenarios
/// and pictures.
class Twin {
 public:
  explicit Twin(const TwinConfig& config);
  ~Twin();
  Twin(Twin&&) noexcept;

  Link& link();
  Gauge& gauge();
  Operator& person();  ///< Does what is asked at once; confirms everything.

  const TwinConfig& config() const;
  const Built& built() const;  ///< As it is now: the block as last turned.
  Settings settings() const;   ///< What the firmware believes now.
  double machine_time_s() const;
  int touches() const;
  const std::vector<TrueTrigger>& triggers() const;

  /// @name The truth
  /// Tip position, actual minus commanded [mm], at a commanded pose with the settings
  /// of now, last moved in the sense `dir`; the closed forms' answer.
  Vec3<double> PositionError_mm(const Vec3<double>& q_mm,
                                const Vec3<double>& dir) const;
  Vec3<double> TipPosition_mm() const;  ///< Where the ball's centre is now.

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace caltwin
