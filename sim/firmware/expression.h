#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/firmware/value.h"

namespace caltwin::rrf {

/// One step of a path such as move.axes[0].min: a name or an index.
using PathStep = std::variant<std::string, std::int64_t>;
using Path = std::vector<PathStep>;

/// "move.axes[0].min".
std::string ToText(const Path& path);

/// Finds what a path means; nullopt where there is no such thing.
using Lookup = std::function<std::optional<Value>(const Path& path)>;

/// Evaluates an expression of RepRapFirmware's meta commands: numbers, "text", true,
/// false, null, pi, paths, [index], # (length), ! - +, * / %, + -, comparisons (= and
/// == alike), & && | ||, ^ (text concatenation), ? :, ( ) and { }, {a, b} arrays,
/// exists(), vector() and the usual functions of numbers (radians). What `? :`, && and
/// || do not choose is not evaluated. Throws InputError in the firmware's words.
Value Evaluate(std::string_view text, const Lookup& lookup);

/// The expressions of a list separated by commas, as behind `echo`.
std::vector<Value> EvaluateList(std::string_view text, const Lookup& lookup);

/// A path alone, its indices evaluated: the left side of `set`. `*rest` is what
/// follows.
Path ParsePath(std::string_view text, const Lookup& lookup, std::string_view* rest);

/// The part of `value` that the steps from `first` on lead to: [index] into arrays.
std::optional<Value> Element(const Value& value, const Path& path, std::size_t first);

}  // namespace caltwin::rrf
