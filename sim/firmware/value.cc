#include "sim/firmware/value.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/link/gcode.h"

namespace caltwin::rrf {
namespace {

[[noreturn]] void Fail(const std::string& expected, const Value& value) {
  throw InputError({}, fmt::format("expected {}, not '{}'", expected, ToText(value)));
}

}  // namespace

double Value::Number() const {
  if (const auto* whole = std::get_if<std::int64_t>(&of)) {
    return static_cast<double>(*whole);
  }
  if (const auto* number = std::get_if<double>(&of)) return *number;
  Fail("a number", *this);
}

std::int64_t Value::Whole() const {
  if (const auto* whole = std::get_if<std::int64_t>(&of)) return *whole;
  const auto* const number = std::get_if<double>(&of);
  if (number == nullptr || std::floor(*number) != *number || std::abs(*number) > 1e15) {
    Fail("a whole number", *this);
  }
  return static_cast<std::int64_t>(*number);
}

bool Value::Flag() const {
  if (const auto* flag = std::get_if<bool>(&of)) return *flag;
  Fail("true or false", *this);
}

std::string ToText(const Value& value) {
  if (value.is_null()) return "null";
  if (const auto* flag = std::get_if<bool>(&value.of)) return *flag ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&value.of)) {
    return fmt::format("{}", *whole);
  }
  if (const auto* number = std::get_if<double>(&value.of)) {
    return std::isfinite(*number) ? GcodeNumber(*number)
                                  : std::string(std::isnan(*number) ? "nan" : "inf");
  }
  if (const auto* text = std::get_if<std::string>(&value.of)) return *text;
  std::string text = "{";
  for (const Value& element : *value.array()) {
    if (text.size() > 1) text += ',';
    text += ToText(element);
  }
  text += '}';
  return text;
}

}  // namespace caltwin::rrf
