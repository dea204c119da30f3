#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What is odd about measured rows before anything is fitted to them: mistakes of the
/// person or the program that wrote them, which a diagnosis would name as causes.
struct Doubt {
  /// not_finite, too_few, constant, duplicated_rows, time_backwards, temperature_unit,
  /// sigma_unit, quantised, one_direction, direction_unknown, value_unit,
  /// position_unit, value_is_position, reversed_axis, scale_absurd, units_differ,
  /// reversed_sign, negative_gap, moves_contradict, outside_travel,
  /// other_drive.
  std::string kind{};
  std::string message{};  ///< One sentence, with its figures.
  std::string hint{};     ///< What to do; may be empty.
  /// Running numbers (Row::row) of the rows it is about; of duplicates the later ones,
  /// so that leaving them out cures it. Empty: all of them.
  std::vector<std::int64_t> rows{};
  /// Nothing true can come of these rows as they stand: to be shown with exit code 2.
  bool refuse = false;
};

/// What whoever read the rows knows of them for sure.
struct KnownOfRows {
  /// The file's format, or a person, says the unit of the readings.
  bool has_unit = false;
  /// value_mm was made here, as position read less position commanded.
  bool is_deviation = false;
};

/// Every doubt about the rows, the gravest first. `machine`, if given, says how far its
/// axes travel.
///
/// Only what cannot be a machine's doing is refused; what might be is a note: a screw
/// that moves 5 % too far is a finding, one that moves 25.4 times too far is a unit.
std::vector<Doubt> Doubts(const RowTable& table,
                          const DataHeader& header,
                          const Machine* machine = nullptr,
                          const KnownOfRows& known = {});

}  // namespace caltwin
