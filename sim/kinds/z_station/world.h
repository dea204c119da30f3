#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "sim/mjcf/mjcf.h"
#include "sim/physics/world.h"

namespace caltwin {

/// What comes down on what.
enum class ZContact { kNozzleOnSwitch, kBodyOnSwitch, kKnobOnSurface };

/// How the parts of a nozzle's station stand now, grown, worn and exchanged as they are
/// [mm]; the head's over its carriage, the others over the bare, cold bed.
struct ZStationBuild {
  double tip_mm = 0;        ///< What of the nozzle comes down first, ooze included.
  double body_mm = -6.5;    ///< Underside of the probe's switch.
  double trigger_mm = 0.5;  ///< Body over what its knob touches, at the trigger.
  double switch_mm = 1.5;   ///< Top of the endstop switch's pin, at the trigger.
  double surface_mm = 0;    ///< Print surface where it is probed.
  double slope_x = 0, slope_y = 0;
  bool has_probe = true;  ///< The magnets hold it.
};

/// Nozzle, probe and switches in MuJoCo (models/z_station/model.xml), millimetres
/// outside. The head is driven exactly; contacts, the pin of the endstop switch and the
/// knob of the probe, each on its spring, are MuJoCo's. A switch triggers where its pin
/// has gone in by 0.3 mm.
class ZStationWorld {
 public:
  static constexpr double kInward_mm = 0.3;  ///< Of pin and knob, at the trigger.

  explicit ZStationWorld(const std::filesystem::path& file);

  /// Lowers the head at 5 mm/s from above `expected_mm` (height of its carriage) until
  /// the switch triggers; where the carriage then is. nullopt: it does not within 3 mm
  /// beyond.
  std::optional<double> Lower(ZContact contact,
                              const ZStationBuild& build,
                              double expected_mm);

 private:
  void Build(ZContact contact, const ZStationBuild& build);
  void PlaceHead(double carriage_mm);
  void Step(double carriage_mm);
  int BodyOf(const char* name) const;

  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  int head_ = 0, pin_ = 0, knob_ = 0;  ///< Joints: each is one coordinate.
};

}  // namespace caltwin
