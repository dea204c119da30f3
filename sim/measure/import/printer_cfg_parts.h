#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

/// What stands in a printer.cfg, by whether the twin has such parts.
namespace caltwin {

/// Sections that need no hardware of their own, by their first word.
inline constexpr std::array<std::string_view, 32> kKeptSections = {
    "printer",
    "bed_mesh",
    "z_tilt",
    "z_tilt_ng",
    "quad_gantry_level",
    "screws_tilt_adjust",
    "bed_screws",
    "bed_tilt",
    "delta_calibrate",
    "skew_correction",
    "axis_twist_compensation",
    "safe_z_home",
    "homing_override",
    "manual_probe",
    "endstop_phase",
    "input_shaper",
    "gcode_macro",
    "delayed_gcode",
    "gcode_arcs",
    "force_move",
    "idle_timeout",
    "pause_resume",
    "respond",
    "save_variables",
    "exclude_object",
    "virtual_sdcard",
    "display_status",
    "firmware_retraction",
    "danger_options",
    "z_calibration",
    "constants",
    "tuning_tower"};
/// Sections of a probe, and what of them holds for any.
inline constexpr std::array<std::string_view, 9> kProbes = {"probe",
                                                            "bltouch",
                                                            "smart_effector",
                                                            "probe_eddy_current",
                                                            "cartographer",
                                                            "beacon",
                                                            "scanner",
                                                            "dockable_probe",
                                                            "load_cell_probe"};
inline constexpr std::array<std::string_view, 7> kOfAnyProbe = {
    "speed",
    "lift_speed",
    "samples",
    "sample_retract_dist",
    "samples_result",
    "samples_tolerance",
    "samples_tolerance_retries"};
inline constexpr std::array<std::string_view, 4> kPins = {
    "step_pin", "dir_pin", "enable_pin", "endstop_pin"};
inline constexpr std::array<std::string_view, 2> kWhichEnd = {"position_endstop",
                                                              "homing_positive_dir"};

/// Macros ask for their temperatures; of pins that lead nowhere that is 113 degrees.
inline constexpr std::string_view kExtruder =
    "nozzle_diameter: 0.4\nfilament_diameter: 1.75\nmin_extrude_temp: 0\nheater_pin: "
    "SPARE0\nsensor_pin: SPARE1\n";
inline constexpr std::string_view kBed = "heater_pin: SPARE2\nsensor_pin: SPARE3\n";
inline constexpr std::string_view kHeater =
    "sensor_type: Generic 3950\ncontrol: watermark\nmin_temp: 0\nmax_temp: 300\n";

/// What macros say to a part; the first word of its section begins so.
struct SaidTo {
  std::string_view part{};
  std::vector<std::string_view> commands{};
};
/// To parts that are left out.
const std::vector<SaidTo>& SaidToMissing();
/// To heaters that are there and never heat: what would wait for them.
const std::vector<SaidTo>& SaidToHeaters();

template <std::size_t kNum>
bool IsAmong(const std::array<std::string_view, kNum>& all, std::string_view one) {
  return std::ranges::find(all, one) != all.end();
}

}  // namespace caltwin
