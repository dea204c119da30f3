#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/value.h"

namespace caltwin::rrf {

/// `left` + - * / or % `right`; whole numbers stay whole but for /.
Value Calculate(const Value& left, char mark, const Value& right);
/// = == != < > <= >=. Numbers by value, text by its bytes (= and != only), null equals
/// null only.
Value Compare(const Value& left, std::string_view mark, const Value& right);
/// - + ! or # (length of text or array).
Value ApplySign(char mark, const Value& operand);
/// abs, sqrt, square, floor, ceil, round, min, max, mod, pow, exp, log, sin, cos, tan,
/// asin, acos, atan, atan2, degrees, radians, isnan, vector. Angles in radians.
Value CallFunction(const std::string& name, const std::vector<Value>& arguments);

}  // namespace caltwin::rrf
