#include "tools/server/json_keys.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

// As RFC 6901 has a key in a pointer.
std::string Pointer(const std::string& key) {
  std::string pointer = "/";
  for (const char letter : key) {
    if (letter == '~') pointer += "~0";
    if (letter == '/') pointer += "~1";
    if (letter != '~' && letter != '/') pointer += letter;
  }
  return pointer;
}

std::string RangeText(const NumberRange& range) {
  constexpr double kOpen = std::numeric_limits<double>::max();
  const std::string unit = range.unit.empty() ? "" : " " + range.unit;
  if (range.least > -kOpen && range.most < kOpen) {
    return fmt::format("{:g} to {:g}{}", range.least, range.most, unit);
  }
  if (range.least > -kOpen) return fmt::format("{:g}{} or more", range.least, unit);
  return range.unit.empty() ? "a number" : "a number of" + unit;
}

}  // namespace

JsonKeys::JsonKeys(const Json& tree, std::string at)
    : tree_(&tree), at_(std::move(at)) {
  if (!tree.is_object()) {
    throw Problem(422,
                  "the body is no JSON object",
                  {{.detail = "an object with keys is expected", .pointer = at_}});
  }
}

const Json* JsonKeys::Find(const std::string& key) {
  known_.insert(key);
  const auto found = tree_->find(key);
  return found == tree_->end() ? nullptr : &*found;
}

void JsonKeys::Add(const std::string& pointer,
                   const std::string& detail,
                   const std::string& hint) {
  faults_.push_back({.detail = detail, .hint = hint, .pointer = at_ + pointer});
}

std::optional<double> JsonKeys::NumberAt(const Json& value,
                                         const std::string& pointer,
                                         const NumberRange& range) {
  const bool is_number = value.is_number() && std::isfinite(value.get<double>());
  if (!is_number) {
    Add(pointer, "is no number", "allowed: " + RangeText(range));
    return std::nullopt;
  }
  const double number = value.get<double>();
  if (number < range.least || number > range.most) {
    Add(pointer,
        fmt::format("{:g} is out of range", number),
        "allowed: " + RangeText(range));
    return std::nullopt;
  }
  return number;
}

double JsonKeys::Number(const std::string& key, const NumberRange& range) {
  const Json* const value = Find(key);
  if (value == nullptr) {
    Add(Pointer(key), "is missing", "allowed: " + RangeText(range));
    return range.least;
  }
  return NumberAt(*value, Pointer(key), range).value_or(0);
}

double JsonKeys::Number(const std::string& key,
                        const NumberRange& range,
                        double fallback) {
  const Json* const value = Find(key);
  return value == nullptr ? fallback
                          : NumberAt(*value, Pointer(key), range).value_or(fallback);
}

int JsonKeys::Integer(const std::string& key, int least, int most, int fallback) {
  const Json* const value = Find(key);
  if (value == nullptr) return fallback;
  const auto number =
      NumberAt(*value,
               Pointer(key),
               {static_cast<double>(least), static_cast<double>(most), ""});
  if (!number) return fallback;
  if (*number != std::floor(*number)) {
    Add(Pointer(key), fmt::format("{:g} is no whole number", *number), "");
    return fallback;
  }
  return static_cast<int>(*number);
}

bool JsonKeys::Bool(const std::string& key, bool fallback) {
  const Json* const value = Find(key);
  if (value == nullptr) return fallback;
  if (value->is_boolean()) return value->get<bool>();
  Add(Pointer(key), "is neither true nor false", "");
  return fallback;
}

std::string JsonKeys::Text(const std::string& key, const std::string& fallback) {
  const Json* const value = Find(key);
  if (value == nullptr) return fallback;
  if (value->is_string()) return value->get<std::string>();
  Add(Pointer(key), "is no text", "");
  return fallback;
}

Json JsonKeys::Object(const std::string& key,
                      std::size_t most_bytes,
                      bool is_required) {
  const Json* const value = Find(key);
  if (value == nullptr) {
    if (is_required) Add(Pointer(key), "is missing", "an object is expected");
    return Json::object();
  }
  if (value->is_object() && value->dump().size() <= most_bytes) return *value;
  Add(Pointer(key),
      value->is_object() ? fmt::format("is larger than {} bytes", most_bytes)
                         : std::string("is no object"),
      "");
  return Json::object();
}

std::vector<std::vector<double>> JsonKeys::Tuples(const std::string& key,
                                                  std::size_t size,
                                                  std::size_t least,
                                                  std::size_t most) {
  const Json* const list = Find(key);
  const std::string shape =
      fmt::format("{} to {} lists of {} numbers", least, most, size);
  if (list == nullptr || !list->is_array()) {
    Add(Pointer(key),
        list == nullptr ? "is missing" : "is no list",
        "allowed: " + shape);
    return {};
  }
  if (list->size() < least || list->size() > most) {
    Add(Pointer(key), fmt::format("has {} entries", list->size()), "allowed: " + shape);
    return {};
  }
  std::vector<std::vector<double>> tuples;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string at = fmt::format("{}/{}", Pointer(key), i);
    const Json& entry = (*list)[i];
    if (!entry.is_array() || entry.size() != size) {
      Add(at, fmt::format("is no list of {} numbers", size), "");
      continue;
    }
    std::vector<double> tuple;
    for (std::size_t j = 0; j < size; ++j) {
      constexpr double kFar_mm = 1e6;
      tuple.push_back(
          NumberAt(entry[j], fmt::format("{}/{}", at, j), {-kFar_mm, kFar_mm, "mm"})
              .value_or(0));
    }
    tuples.push_back(std::move(tuple));
  }
  return tuples;
}

void JsonKeys::Done() {
  std::vector<ProblemFault> faults;
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const auto& [key, value] : tree_->items()) {
    if (known_.contains(key)) continue;
    const std::string near = NearestWord(key, known);
    const std::string meant =
        near.empty() ? "" : fmt::format("did you mean '{}'? ", near);
    faults.push_back(
        {.detail = "is no key of this body",
         .hint = fmt::format("{}It knows: {}", meant, fmt::join(known, ", ")),
         .pointer = at_ + Printable(Pointer(key))});
  }
  faults.insert(faults.end(), faults_.begin(), faults_.end());
  if (faults.empty()) return;
  throw Problem(422, *faults.front().pointer + " " + faults.front().detail, faults);
}

}  // namespace caltwin
