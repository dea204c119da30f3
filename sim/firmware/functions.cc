#include "sim/firmware/functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/units.h"

namespace caltwin::rrf {
namespace {

constexpr std::int64_t kLongestArray = 10'000;

struct OneNumber {
  std::string_view name;
  double (*of)(double);
};
constexpr std::array<OneNumber, 11> kOfOneNumber = {{{"sqrt",
                                                      [](double x) {
                                                        return std::sqrt(x);
                                                      }},
                                                     {"exp",
                                                      [](double x) {
                                                        return std::exp(x);
                                                      }},
                                                     {"log",
                                                      [](double x) {
                                                        return std::log(x);
                                                      }},
                                                     {"sin",
                                                      [](double x) {
                                                        return std::sin(x);
                                                      }},
                                                     {"cos",
                                                      [](double x) {
                                                        return std::cos(x);
                                                      }},
                                                     {"tan",
                                                      [](double x) {
                                                        return std::tan(x);
                                                      }},
                                                     {"asin",
                                                      [](double x) {
                                                        return std::asin(x);
                                                      }},
                                                     {"acos",
                                                      [](double x) {
                                                        return std::acos(x);
                                                      }},
                                                     {"atan",
                                                      [](double x) {
                                                        return std::atan(x);
                                                      }},
                                                     {"degrees",
                                                      [](double x) {
                                                        return DegFromRad(x);
                                                      }},
                                                     {"radians", [](double x) {
                                                        return RadFromDeg(x);
                                                      }}}};

bool IsWhole(const Value& value) {
  return std::holds_alternative<std::int64_t>(value.of);
}

/// A number as a whole one where it is small enough to be.
Value Rounded(double number) {
  if (!std::isfinite(number) || std::abs(number) > 9e15) return Value{number};
  return Value{static_cast<std::int64_t>(number)};
}

Value Extreme(const std::vector<Value>& arguments, bool is_max) {
  return *std::ranges::max_element(arguments, [&](const Value& a, const Value& b) {
    return is_max ? a.Number() < b.Number() : b.Number() < a.Number();
  });
}

Value MakeVector(const std::vector<Value>& arguments) {
  const std::int64_t length = arguments[0].Whole();
  if (length < 0 || length > kLongestArray) {
    throw InputError({}, fmt::format("an array has 0 to {} elements", kLongestArray));
  }
  return Value{Value::Array(static_cast<std::size_t>(length), arguments[1])};
}

void NeedArguments(const std::string& name,
                   const std::vector<Value>& arguments,
                   std::size_t least,
                   std::size_t most) {
  if (arguments.size() < least || arguments.size() > most) {
    throw InputError({},
                     fmt::format("wrong number of arguments to function '{}'", name));
  }
}

}  // namespace

Value Calculate(const Value& left, char mark, const Value& right) {
  const double a = left.Number();
  const double b = right.Number();
  const bool are_small = std::abs(a) < 1e9 && std::abs(b) < 1e9;
  const bool is_whole = IsWhole(left) && IsWhole(right) && are_small;
  if (mark == '/') return Value{a / b};
  if (mark == '%') {
    if (b == 0) throw InputError({}, "division by zero");
    return is_whole ? Rounded(std::fmod(a, b)) : Value{std::fmod(a, b)};
  }
  const double result = mark == '+' ? a + b : mark == '-' ? a - b : a * b;
  return is_whole ? Rounded(result) : Value{result};
}

Value Compare(const Value& left, std::string_view mark, const Value& right) {
  const bool is_equality = mark == "=" || mark == "==" || mark == "!=";
  if (is_equality && (!left.is_number() || !right.is_number())) {
    const bool are_equal =
        left.of.index() == right.of.index() && ToText(left) == ToText(right);
    return Value{are_equal == (mark != "!=")};
  }
  const double a = left.Number();
  const double b = right.Number();
  if (mark == "<") return Value{a < b};
  if (mark == ">") return Value{a > b};
  if (mark == "<=") return Value{a <= b};
  if (mark == ">=") return Value{a >= b};
  return Value{(a == b) == (mark != "!=")};
}

Value ApplySign(char mark, const Value& operand) {
  if (mark == '!') return Value{!operand.Flag()};
  if (mark == '#') {
    if (const auto* array = operand.array()) {
      return Value{static_cast<std::int64_t>(array->size())};
    }
    if (const auto* text = std::get_if<std::string>(&operand.of)) {
      return Value{static_cast<std::int64_t>(text->size())};
    }
    throw InputError({}, "expected a string or an array behind '#'");
  }
  if (mark == '-') return Calculate(Value{std::int64_t{0}}, '-', operand);
  return Calculate(Value{std::int64_t{0}}, '+', operand);
}

Value CallFunction(const std::string& name, const std::vector<Value>& arguments) {
  const auto* const simple = std::ranges::find(kOfOneNumber, name, &OneNumber::name);
  if (simple != kOfOneNumber.end()) {
    NeedArguments(name, arguments, 1, 1);
    return Value{simple->of(arguments[0].Number())};
  }
  if (name == "min" || name == "max") {
    NeedArguments(name, arguments, 1, 1000);
    return Extreme(arguments, name == "max");
  }
  const bool has_two =
      name == "mod" || name == "pow" || name == "atan2" || name == "vector";
  NeedArguments(name, arguments, has_two ? 2 : 1, has_two ? 2 : 1);
  if (name == "vector") return MakeVector(arguments);
  if (name == "mod") return Calculate(arguments[0], '%', arguments[1]);
  if (name == "square") return Calculate(arguments[0], '*', arguments[0]);
  const double x = arguments[0].Number();
  if (name == "pow") return Value{std::pow(x, arguments[1].Number())};
  if (name == "atan2") return Value{std::atan2(x, arguments[1].Number())};
  if (name == "isnan") return Value{std::isnan(x)};
  if (name == "abs") return x < 0 ? ApplySign('-', arguments[0]) : arguments[0];
  if (name == "floor") return Rounded(std::floor(x));
  if (name == "ceil") return Rounded(std::ceil(x));
  if (name == "round") return Rounded(std::round(x));
  throw InputError({}, fmt::format("unknown function '{}'", name));
}

}  // namespace caltwin::rrf
