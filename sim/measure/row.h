#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/input_error.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// A number that a row may not know; `Known(x)` tells.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr bool Known(double value) {
  return value == value;
}

enum class RowKind { kPosition, kTouch, kRadial };

/// One measurement, as one line of a data file (docs/data-format.md has every column).
///
/// `position`, `radial`: value = (actual - commanded) . n. `touch`: value = (reported -
/// nominal) . n, reported being the commanded tip centre at the trigger moved by the
/// configured tip radius along -n. In general touch = -(motion error) . n - pre-travel
/// - b/2 + (R_true - R_cfg) + (artefact error) . n.
struct Row {
  std::int64_t row = 0;  ///< Running number in the order measured.
  std::string campaign{};
  RowKind kind = RowKind::kPosition;
  std::string setup{}, home{}, settings{};
  std::optional<std::int64_t> rep{};  ///< Counted from any number.
  double t_s = kUnknown;
  double temp_screw_c = kUnknown, temp_frame_c = kUnknown, temp_bed_c = kUnknown;
  double temp_chamber_c = kUnknown, temp_ambient_c = kUnknown;
  double temp_nozzle_c = kUnknown;
  double nozzle_wiped = kUnknown;  ///< 1: just before, also before its calibration.
  std::array<double, 3> cmd_mm{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> motor_mm{kUnknown, kUnknown, kUnknown};  ///< a b c or z1 z2 z3.
  /// Screws under a bed beside motors a b.
  std::array<double, 3> screw_mm{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> dir{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> motor_dir{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> screw_dir{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> since_rev_mm{kUnknown, kUnknown, kUnknown};
  double feed_mm_s = kUnknown;
  double load_n = kUnknown;
  std::array<double, 3> n{kUnknown, kUnknown, kUnknown};
  std::string feature{};
  double artefact_turn_deg = kUnknown;
  double probe_angle_deg = kUnknown;
  std::array<double, 3> probe_off_mm{kUnknown, kUnknown, kUnknown};
  double value_mm = 0;
  double sigma_mm = kUnknown;
  std::string flag{};
  std::vector<std::string> extra{};  ///< Of the unknown columns, in the table's order.
  Place place{};                     ///< Where it was read from.
};

/// What a row says of the screws under a bed.
struct ScrewCells {
  std::array<double, 3>* mm = nullptr;
  std::array<double, 3>* dir = nullptr;
};
/// In columns of their own beside other motors, else in those of the motors.
inline ScrewCells ScrewCellsOf(Row* row, bool beside_motors) {
  if (beside_motors) return {&row->screw_mm, &row->screw_dir};
  return {&row->motor_mm, &row->motor_dir};
}

/// All rows of one file, in file order.
struct RowTable {
  std::vector<Row> rows{};
  std::vector<std::string> extra_columns{};  ///< Kept and reported, never used.
  std::vector<std::string> comments{};       ///< Without the '#'.
  std::vector<std::string> remarks{};  ///< What a person should know, but no fault.
};

}  // namespace caltwin
