#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace caltwin::rrf {

/// A value of RepRapFirmware's meta commands: null, true or false, a whole number, a
/// number, text or an array.
struct Value {
  using Array = std::vector<Value>;
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array> of{};

  bool is_null() const { return std::holds_alternative<std::monostate>(of); }
  bool is_number() const {
    return std::holds_alternative<std::int64_t>(of) ||
           std::holds_alternative<double>(of);
  }
  const Array* array() const { return std::get_if<Array>(&of); }

  /// Each throws InputError where the value is something else.
  double Number() const;
  std::int64_t Whole() const;
  bool Flag() const;
};

/// As `echo` prints it: numbers with at most six decimals, arrays in braces.
std::string ToText(const Value& value);

}  // namespace caltwin::rrf
