#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/input_error.h"

namespace caltwin {

/// What a number measures; each has its own unit in measured rows.
enum class Quantity { kLength, kTime, kTemperature, kFeed, kForce, kAngle, kPlain };

/// A unit people write, and how to come from it to the unit of measured rows (mm, s,
/// degrees Celsius, mm/s, N, degrees).
struct NamedUnit {
  std::string_view name{};
  Quantity quantity = Quantity::kPlain;
  double (*convert)(const double&) = nullptr;
};

/// The unit of measured rows for a quantity: "mm/s". Empty for kPlain.
std::string_view UsualUnit(Quantity quantity);

/// The unit of that name, in the spellings people use (um, µm, micron; in, inch, ";
/// thou, mil; K, F ...). Throws InputError, with what is allowed for the quantity.
const NamedUnit& FindUnit(std::string_view name, Quantity quantity, const Place& place);

/// The unit a column's heading ends in: `dev_um`, `X [mm]`, `error (µm)`; null where it
/// names none.
const NamedUnit* UnitInHeading(std::string_view heading, Quantity quantity);

}  // namespace caltwin
