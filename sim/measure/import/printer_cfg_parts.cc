#include "sim/measure/import/printer_cfg_parts.h"

namespace caltwin {

const std::vector<SaidTo>& SaidToMissing() {
  static const std::vector<SaidTo> kAll = {
      {"z_tilt", {"Z_TILT_ADJUST", "Z_TILT_CALIBRATE", "Z_TILT_AUTODETECT"}},
      {"quad_gantry_level", {"QUAD_GANTRY_LEVEL"}},
      {"display", {"SET_DISPLAY_GROUP"}},
      {"manual_stepper", {"MANUAL_STEPPER"}},
      {"extruder_stepper", {"SYNC_EXTRUDER_MOTION"}},
      {"dual_carriage",
       {"SET_DUAL_CARRIAGE",
        "SAVE_DUAL_CARRIAGE_STATE",
        "RESTORE_DUAL_CARRIAGE_STATE"}},
      {"resonance_tester",
       {"TEST_RESONANCES", "SHAPER_CALIBRATE", "MEASURE_AXES_NOISE"}},
      {"mcp4018", {"SET_DIGIPOT"}},
      {"extruder",
       {"SET_PRESSURE_ADVANCE",
        "SET_EXTRUDER_ROTATION_DISTANCE",
        "SYNC_EXTRUDER_MOTION"}},
      {"fan", {"M106", "M107", "SET_FAN_SPEED"}},
      {"temperature_fan", {"SET_TEMPERATURE_FAN_TARGET"}},
      {"neopixel", {"SET_LED"}},
      {"led", {"SET_LED"}},
      {"dotstar", {"SET_LED"}},
      {"tmc", {"SET_TMC_CURRENT", "SET_TMC_FIELD", "INIT_TMC"}},
      {"output_pin", {"SET_PIN"}},
      {"servo", {"SET_SERVO"}},
      {"bltouch", {"BLTOUCH_DEBUG"}},
      {"filament_", {"SET_FILAMENT_SENSOR", "QUERY_FILAMENT_SENSOR"}}};
  return kAll;
}

const std::vector<SaidTo>& SaidToHeaters() {
  static const std::vector<SaidTo> kAll = {
      {"extruder",
       {"M104", "M109", "SET_HEATER_TEMPERATURE", "TEMPERATURE_WAIT", "PID_CALIBRATE"}},
      {"heater_bed",
       {"M140",
        "M190",
        "SET_HEATER_TEMPERATURE",
        "TEMPERATURE_WAIT",
        "PID_CALIBRATE"}}};
  return kAll;
}

}  // namespace caltwin
