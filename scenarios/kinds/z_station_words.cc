#include <array>

#include "scenarios/kinds/z_station_scenario.h"

namespace caltwin {

namespace {

constexpr std::array kKeyWords = {
    Word{"station",
         "What is true of nozzle, endstop switch, probe and plate: switch_mm "
         "nozzle_mm ooze_mm ooze_flows_c body_mm trigger_mm plate_mm, the bed's "
         "shape, scatter, wear and growth. Numbers or distributions."},
    // Of a station.
    Word{"switch_mm",
         "Where the endstop switch triggers, over the bare bed, at 20 degC (1.5)."},
    Word{"nozzle_mm", "How much longer the nozzle is than drawn (0)."},
    Word{"ooze_mm",
         "Plastic under the nozzle's tip, as thick as the switch squashes it, from "
         "ooze_flows_c degC on; away once wiped, until the nozzle is heated anew."},
    Word{"ooze_flows_c",
         "Nozzle temperature [degC] from which on there is ooze (0: always)."},
    Word{"body_mm", "The probe's body hangs so far below the drawn tip (6.5)."},
    Word{"trigger_mm",
         "The probe's body over what its knob touches, at the trigger: what "
         "switch_offset should be (0.5)."},
    Word{"plate_mm", "Thickness of the plate that lies on the bed (0)."},
    Word{"bed_slope_x_mrad", "The bed's slope along x, about its middle (0)."},
    Word{"bed_slope_y_mrad", "The bed's slope along y, about its middle (0)."},
    Word{"bed_bowl_mm",
         "How much higher the bed is 100 mm from its middle than there (0)."},
    Word{"dock_misses", "1: the magnets do not take the probe along."},
    Word{"endstop_scatter_mm",
         "Standard deviation of where the endstop switch triggers (0.002)."},
    Word{"probe_scatter_mm", "Standard deviation of where the probe triggers (0.002)."},
    Word{"worn_mm",
         "A worn endstop switch: each trigger comes up to this much late, skewed "
         "(0)."},
    Word{"nozzle_mm_per_k", "Growth of the nozzle, from 20 degC (0.0002)."},
    Word{"bed_mm_per_k", "Growth of the bed at its edge, from 20 degC (0.0005)."},
    Word{"frame_mm_per_k", "The chamber's warmth lifts the head by this."},
    Word{"surface_mm_per_k",
         "How much more than at its edge the bed grows where it is probed."},
    Word{"trigger_mm_per_k", "Growth of the probe's trigger_mm with the chamber."},
    Word{"switch_offset_mm",
         "printer.cfg's switch_offset of [z_calibration]: body over what the knob "
         "touches, at the trigger. Not below 0."},
    // Of its settings, as in printer.cfg.
    Word{"position_endstop_mm", "[stepper_z] position_endstop (0)."},
    Word{"position_min_mm", "[stepper_z] position_min: no probing below it (-5)."},
    Word{"is_virtual_endstop",
         "true: endstop_pin is probe:z_virtual_endstop, which z_calibration refuses."},
    Word{"samples", "Touches of one place (3)."},
    Word{"samples_tolerance_mm",
         "Touches of one place that lie farther apart are repeated, "
         "samples_tolerance_retries times, then refused (0.1)."},
    Word{"samples_tolerance_retries",
         "How often touches beyond samples_tolerance_mm are made anew (0)."},
    Word{"samples_result", "What counts of the touches: average (usual) or median."},
    Word{"probing_speed_mm_s", "Down to a touch (5)."},
    Word{"lifting_speed_mm_s", "Up again between touches (5)."},
    Word{"sample_retract_dist_mm", "Up so far between touches (2)."},
    Word{"start_gcode", "Sent before CALIBRATE_Z begins (none)."},
    Word{"before_switch_gcode",
         "Sent before the probe's body goes to the switch (ATTACH_PROBE)."},
    Word{"end_gcode", "Sent when CALIBRATE_Z is done (DETACH_PROBE)."},
    Word{"max_deviation_mm", "An offset larger than this is refused (no limit)."},
    Word{"probe_bed_at_mm",
         "[x, y] where CALIBRATE_Z probes the bed; else the mesh's reference point, "
         "without a mesh the middle."},
    Word{"probe_z_offset_mm",
         "[probe] z_offset: what a mesh without relative_reference_index calls 0 "
         "(0)."},
    Word{"bed_mesh",
         "[bed_mesh]: {min_mm, max_mm, probe_count, relative_reference_index}. No "
         "mesh without it."},
    Word{"min_mm", "[x, y] of a mesh's first point."},
    Word{"max_mm", "[x, y] of its last one."},
    Word{"probe_count", "[nx, ny] points of a mesh, 2 to 20 each way."},
    Word{"relative_reference_index",
         "The mesh's point that is called 0, counted along x first. Without one "
         "CALIBRATE_Z wants probe_bed_at_mm."},
    Word{"CALIBRATE_Z",
         "Klipper's command for z_calibration; its last line is `Z-CALIBRATION: "
         "ENDSTOP= NOZZLE= SWITCH= PROBE= --> OFFSET=`."}};

}  // namespace

std::vector<Word> ZStationScenario::ScenarioSteps() const {
  return {{"change", "A step: what an operator changes of the station."}};
}

std::span<const Word> ZStationScenario::OwnKeys() const {
  return kKeyWords;
}

}  // namespace caltwin
