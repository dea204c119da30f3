#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a log of trigger heights against temperature, as `touch` rows: value =
/// reported height along +z, so a frame that lifts the tool reads less, a bed that
/// grows more.
///
/// - frame expansion CSV (measure_thermal_behavior): `sample,time,mcu_pos_z,frame_t,
///   chamber_t,bed_t,...` below comments that hold `step_dist`. value = (mcu_pos_z -
///   first) * step_dist; an offset is nobody's loss, it is absorbed by the placement.
///   A step distance that makes the frame grow more than it can is refused (StepFault).
/// - probe drift JSON, a record a line: temperatures `{ts, btemp, etemp, atherms}`
///   between readings `{ts, z}`; temperatures between two records lie on the straight
///   line through them, after the last they stay.
///
/// Temperatures of the hot end and targets of heaters are kept as columns of their own.
Imported ReadKlipperThermal(const std::string& text,
                            const std::string& name,
                            const ImportOptions& options);

/// @name The forms, one file each.
Imported ReadFrameLog(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options);
Imported ReadProbeDrift(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);

/// What a frame expansion log says of its machine.
struct FrameLogHeader {
  std::string printer{};
  double step_mm = kUnknown;
  int step_line = 0;                  ///< Where it stands; 0: given by the person.
  double expansion_per_k = 23.4e-6;   ///< Of the frame; aluminium where not said.
  double frame_length_mm = kUnknown;  ///< Its upright, else the travel of Z.
};

/// How much the frame grows if the log's steps are that long, against what it can.
struct GrowthPerKelvin {
  double growth_mm_per_k = 0;  ///< Of the trigger height with the frame, bed held.
  double range_k = 0;          ///< Of frame temperature in the log.
  double metres_needed = 0;    ///< Of frame, to grow that much.
  double ratio = 0;            ///< metres_needed by the frame's stated length.
};
GrowthPerKelvin GrowthOf(const RowTable& table, const FrameLogHeader& header);

/// Why that step cannot be true, as a sentence; empty where it can. More than five
/// lengths of frame would have to grow in a row: a Z drive's closed loop (frame up,
/// belt or screw down, gantry, bed) is at most four.
std::string StepFault(const GrowthPerKelvin& growth, const FrameLogHeader& header);

}  // namespace caltwin
