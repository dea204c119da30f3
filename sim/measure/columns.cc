#include "sim/measure/columns.h"

namespace caltwin {
namespace {

constexpr Bounds kCelsius{-273.15, 1e4};
constexpr Bounds kSense{-1, 1};
constexpr std::string_view kSenseHint =
    "the sense of the last approach: 1, -1, or 0 for an axis that did not move in it; "
    "empty where it is unknown";
constexpr std::string_view kUnitHint =
    "nx, ny, nz are a unit vector: each lies between -1 and 1";

constexpr std::array kColumns = {
    Column{"campaign", &Row::campaign},
    Column{"setup", &Row::setup},
    Column{"home", &Row::home},
    Column{"rep", &Row::rep, {-1e9, 1e9}, "repetitions are counted, from any number"},
    Column{"settings", &Row::settings},
    Column{"t_s", &Row::t_s},
    Column{"temp_screw_c", &Row::temp_screw_c, kCelsius},
    Column{"temp_frame_c", &Row::temp_frame_c, kCelsius},
    Column{"temp_bed_c", &Row::temp_bed_c, kCelsius},
    Column{"temp_chamber_c", &Row::temp_chamber_c, kCelsius},
    Column{"temp_ambient_c", &Row::temp_ambient_c, kCelsius},
    Column{"temp_nozzle_c", &Row::temp_nozzle_c, kCelsius},
    Column{"nozzle_wiped",
           &Row::nozzle_wiped,
           {0, 1},
           "1: the nozzle was wiped just before, 0: it was not; empty: unknown"},
    Column{"cmd_x_mm", Component{&Row::cmd_mm, 0}},
    Column{"cmd_y_mm", Component{&Row::cmd_mm, 1}},
    Column{"cmd_z_mm", Component{&Row::cmd_mm, 2}},
    Column{"motor_a_mm", Component{&Row::motor_mm, 0}},
    Column{"motor_b_mm", Component{&Row::motor_mm, 1}},
    Column{"motor_c_mm", Component{&Row::motor_mm, 2}},
    Column{"motor_z1_mm", Component{&Row::screw_mm, 0}},
    Column{"motor_z2_mm", Component{&Row::screw_mm, 1}},
    Column{"motor_z3_mm", Component{&Row::screw_mm, 2}},
    Column{"dir_x", Component{&Row::dir, 0}, kSense, kSenseHint},
    Column{"dir_y", Component{&Row::dir, 1}, kSense, kSenseHint},
    Column{"dir_z", Component{&Row::dir, 2}, kSense, kSenseHint},
    Column{"dir_a", Component{&Row::motor_dir, 0}, kSense, kSenseHint},
    Column{"dir_b", Component{&Row::motor_dir, 1}, kSense, kSenseHint},
    Column{"dir_c", Component{&Row::motor_dir, 2}, kSense, kSenseHint},
    Column{"dir_z1", Component{&Row::screw_dir, 0}, kSense, kSenseHint},
    Column{"dir_z2", Component{&Row::screw_dir, 1}, kSense, kSenseHint},
    Column{"dir_z3", Component{&Row::screw_dir, 2}, kSense, kSenseHint},
    Column{"since_rev_x_mm", Component{&Row::since_rev_mm, 0}, kNotNegative},
    Column{"since_rev_y_mm", Component{&Row::since_rev_mm, 1}, kNotNegative},
    Column{"since_rev_z_mm", Component{&Row::since_rev_mm, 2}, kNotNegative},
    Column{"feed_mm_s", &Row::feed_mm_s, kNotNegative},
    Column{"load_n", &Row::load_n},
    Column{"nx", Component{&Row::n, 0}, kSense, kUnitHint},
    Column{"ny", Component{&Row::n, 1}, kSense, kUnitHint},
    Column{"nz", Component{&Row::n, 2}, kSense, kUnitHint},
    Column{"feature", &Row::feature},
    Column{"artefact_turn_deg", &Row::artefact_turn_deg},
    Column{"probe_angle_deg", &Row::probe_angle_deg},
    Column{"probe_off_x_mm", Component{&Row::probe_off_mm, 0}},
    Column{"probe_off_y_mm", Component{&Row::probe_off_mm, 1}},
    Column{"probe_off_z_mm", Component{&Row::probe_off_mm, 2}},
    Column{"sigma_mm", &Row::sigma_mm, kNotNegative, "a standard uncertainty"},
    Column{"flag", &Row::flag},
};

}  // namespace

std::span<const Column> AllColumns() {
  return kColumns;
}

}  // namespace caltwin
