#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "sim/base/yaml.h"
#include "sim/measure/row.h"

namespace caltwin {

/// One of three numbers of a row.
struct Component {
  std::array<double, 3> Row::*numbers = nullptr;
  int index = 0;
};

/// Where in a `Row` a column's value stands.
using Member = std::variant<double Row::*,
                            Component,
                            std::optional<std::int64_t> Row::*,
                            std::string Row::*>;

/// A column of measured rows, format 1: its name in the file and what it may hold.
/// `row`, `kind` and `value_mm` have rules of their own (sim/measure/rows.cc).
struct Column {
  std::string_view name{};
  Member member{};
  Bounds bounds = kAnyNumber;
  std::string_view hint{};
};

/// What `kind` may say, in the order of RowKind.
inline constexpr std::array<std::string_view, 3> kRowKinds = {
    "position", "touch", "radial"};

/// Every column but `row`, `kind` and `value_mm`, in the order they are written.
std::span<const Column> AllColumns();

}  // namespace caltwin
