#include "sim/base/yaml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/base/yaml_check.h"

namespace caltwin {
namespace {

Place PlaceOf(const std::string& file, const YAML::Node& node) {
  return YamlPlace(file, node.Mark());
}

// A map of one key without a value, both at that place of the file.
YAML::Node MapAt(const Place& place, const std::string& key) {
  constexpr std::size_t kLongest = 200;  // Of a key that yaml-cpp takes so: 1024.
  if (place.line < 1 || place.column < 1 || key.size() > kLongest) {
    return YAML::Node(YAML::NodeType::Map);
  }
  YAML::Emitter quoted;
  quoted << YAML::DoubleQuoted << key;
  return YAML::Load(std::string(static_cast<std::size_t>(place.line) - 1, '\n') +
                    std::string(static_cast<std::size_t>(place.column) - 1, ' ') +
                    quoted.c_str() + ": ");
}

std::string Kind(const YAML::Node& node) {
  if (node.IsMap()) return "a mapping";
  if (node.IsSequence()) return "a list";
  if (node.IsNull()) return "empty";
  return fmt::format("'{}'", node.Scalar());
}

std::optional<double> ParseNumber(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  std::string_view text = node.Scalar();
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

YamlValue::YamlValue(const YAML::Node& node,
                     std::string file,
                     std::string path,
                     Faults* faults,
                     std::optional<Place> key)
    : node_(node),
      file_(std::move(file)),
      path_(std::move(path)),
      faults_(faults),
      key_(std::move(key)) {}

// Of a value left empty yaml-cpp tells where the next thing stands: its key is nearer.
Place YamlValue::place() const {
  return node_.IsNull() && key_ ? *key_ : PlaceOf(file_, node_);
}

void YamlValue::Fail(const std::string& text, const std::string& hint) const {
  faults_->Add(place(), path_ + " " + text, hint);
}

std::string YamlValue::AsWritten() const {
  if (node_.IsScalar()) return node_.Scalar();
  std::ostringstream text;
  text << node_;
  return text.str();
}

std::string YamlValue::NotA(std::string_view wanted) const {
  if (node_.IsScalar()) return fmt::format("= {} is not {}", Kind(node_), wanted);
  return fmt::format("is {}, where {} is wanted", Kind(node_), wanted);
}

double YamlValue::Number(Bounds bounds, std::string_view hint) const {
  const double stand_in = std::clamp(0.0, bounds.min, bounds.max);
  const std::optional<double> value = ParseNumber(node_);
  if (!value) {
    Fail(NotA("a number"), std::string(hint));
    return stand_in;
  }
  if (*value < bounds.min || *value > bounds.max) {
    const std::string range =
        bounds.min == kPositive.min && bounds.max == kPositive.max ? "not above 0"
        : bounds.min == 0 && bounds.max == kNotNegative.max
            ? "below 0"
            : fmt::format("outside {} .. {}", bounds.min, bounds.max);
    Fail(fmt::format("= {} is {}", node_.Scalar(), range), std::string(hint));
    return stand_in;
  }
  return *value;
}

std::int64_t YamlValue::Integer(std::int64_t min, std::int64_t max) const {
  const std::int64_t stand_in = std::clamp<std::int64_t>(0, min, max);
  if (node_.IsScalar()) {
    const std::string& text = node_.Scalar();
    std::int64_t value = 0;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size()) {
      if (value >= min && value <= max) return value;
      Fail(fmt::format("= {} is outside {} .. {}", text, min, max));
      return stand_in;
    }
  }
  Fail(NotA("a whole number"));
  return stand_in;
}

bool YamlValue::Flag() const {
  if (node_.IsScalar() && node_.Scalar() == "true") return true;
  if (node_.IsScalar() && node_.Scalar() == "false") return false;
  Fail(node_.IsScalar() ? fmt::format("= {} is neither true nor false", Kind(node_))
                        : NotA("true or false"));
  return false;
}

std::string YamlValue::Text() const {
  if (node_.IsScalar()) return node_.Scalar();
  Fail(fmt::format("is {}, where a text is wanted", Kind(node_)));
  return "";
}

std::string YamlValue::Word(const std::vector<std::string>& allowed) const {
  std::string text = node_.IsScalar() ? node_.Scalar() : "";
  if (std::find(allowed.begin(), allowed.end(), text) != allowed.end()) return text;
  const std::string nearest = NearestWord(text, allowed);
  Fail(
      node_.IsScalar() ? fmt::format("= {} is not known", Kind(node_)) : NotA("a word"),
      (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
          fmt::format("It may be: {}", fmt::join(allowed, ", ")));
  return allowed.front();
}

YamlMap YamlValue::Map() const {
  if (!node_.IsMap()) {
    Fail(fmt::format("is {}, where a mapping is wanted", Kind(node_)));
    return {YAML::Node(YAML::NodeType::Map), file_, path_, faults_};
  }
  return {node_, file_, path_, faults_};
}

YamlMap YamlValue::Within(const std::string& first, const std::string& second) const {
  const Place at = key_ ? *key_ : place();
  YAML::Node node = MapAt(at, first);
  if (second.empty()) {
    node[first] = node_;
  } else {
    YAML::Node inner = MapAt(at, second);
    inner[second] = node_;
    node[first] = inner;
  }
  // The value's own path ends with these names already.
  const std::string names = "." + first + (second.empty() ? "" : "." + second);
  return {node,
          file_,
          path_.ends_with(names) ? path_.substr(0, path_.size() - names.size()) : path_,
          faults_};
}

std::vector<YamlValue> YamlValue::List() const {
  if (!node_.IsSequence()) {
    Fail(fmt::format("is {}, where a list is wanted", Kind(node_)));
    return {};
  }
  std::vector<YamlValue> items;
  for (const YAML::Node& item : node_) {
    items.emplace_back(
        item, file_, fmt::format("{}[{}]", path_, items.size()), faults_);
  }
  return items;
}

std::vector<double> YamlValue::Numbers(std::size_t count, Bounds bounds) const {
  std::vector<double> numbers(count, std::clamp(0.0, bounds.min, bounds.max));
  if (!node_.IsSequence() || node_.size() != count) {
    Fail(fmt::format("is not a list of {} numbers", count));
    return numbers;
  }
  const auto items = List();
  for (std::size_t i = 0; i < count; ++i) numbers[i] = items[i].Number(bounds);
  return numbers;
}

YamlMap::YamlMap(const YAML::Node& node,
                 std::string file,
                 std::string path,
                 Faults* faults)
    : node_(node), file_(std::move(file)), path_(std::move(path)), faults_(faults) {}

std::string YamlMap::PathOf(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

Place YamlMap::place() const {
  return PlaceOf(file_, node_);
}

Place YamlMap::PlaceOfKey(const std::string& key) const {
  for (const auto& entry : node_) {
    if (entry.first.Scalar() == key) return PlaceOf(file_, entry.first);
  }
  return place();
}

bool YamlMap::Has(const std::string& key) {
  asked_.insert(key);
  return static_cast<bool>(node_[key]);
}

std::optional<YamlValue> YamlMap::Optional(const std::string& key) {
  if (!Has(key)) return std::nullopt;
  return YamlValue(node_[key], file_, PathOf(key), faults_, PlaceOfKey(key));
}

std::optional<YamlValue> YamlMap::Required(const std::string& key) {
  auto value = Optional(key);
  if (value) return value;
  // One misspelling causes an unknown key and a missing one: the unknown one tells.
  // Whether a similar key is unknown shows when all have been asked for.
  for (const auto& entry : node_) {
    const std::string& written = entry.first.Scalar();
    if (!asked_.contains(written) && NearestWord(written, {key}) == key) {
      perhaps_misspelt_.emplace_back(key, written);
      return std::nullopt;
    }
  }
  AddMissing(key);
  return std::nullopt;
}

void YamlMap::AddMissing(const std::string& key) const {
  faults_->Add(place(),
               path_.empty() ? fmt::format("the key '{}' is missing", key)
                             : fmt::format("{} lacks the key '{}'", path_, key));
}

std::vector<std::pair<std::string, YamlValue>> YamlMap::Entries() {
  std::vector<std::pair<std::string, YamlValue>> entries;
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) continue;
    const std::string key = entry.first.Scalar();
    asked_.insert(key);
    const Place place = PlaceOf(file_, entry.first);
    entries.emplace_back(key,
                         YamlValue(entry.second, file_, PathOf(key), faults_, place));
  }
  return entries;
}

double YamlMap::Number(const std::string& key, Bounds bounds, std::string_view hint) {
  const auto value = Required(key);
  return value ? value->Number(bounds, hint) : std::clamp(0.0, bounds.min, bounds.max);
}

double YamlMap::NumberOr(const std::string& key,
                         double otherwise,
                         Bounds bounds,
                         std::string_view hint) {
  const auto value = Optional(key);
  return value ? value->Number(bounds, hint) : otherwise;
}

std::int64_t YamlMap::IntegerOr(const std::string& key,
                                std::int64_t otherwise,
                                std::int64_t min,
                                std::int64_t max) {
  const auto value = Optional(key);
  return value ? value->Integer(min, max) : otherwise;
}

bool YamlMap::FlagOr(const std::string& key, bool otherwise) {
  const auto value = Optional(key);
  return value ? value->Flag() : otherwise;
}

std::string YamlMap::Text(const std::string& key) {
  const auto value = Required(key);
  return value ? value->Text() : "";
}

std::string YamlMap::TextOr(const std::string& key, const std::string& otherwise) {
  const auto value = Optional(key);
  return value ? value->Text() : otherwise;
}

std::string YamlMap::WordOr(const std::string& key,
                            const std::string& otherwise,
                            const std::vector<std::string>& allowed) {
  const auto value = Optional(key);
  return value ? value->Word(allowed) : otherwise;
}

void YamlMap::NoMoreKeys() {
  for (const auto& [missing, similar] : perhaps_misspelt_) {
    if (asked_.contains(similar)) AddMissing(missing);
  }
  const std::vector<std::string> known(asked_.begin(), asked_.end());
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) continue;
    const std::string key = entry.first.Scalar();
    if (asked_.contains(key)) continue;
    const std::string nearest = NearestWord(key, known);
    faults_->Add(
        PlaceOf(file_, entry.first),
        fmt::format("{} has no key '{}'", path_.empty() ? "this file" : path_, key),
        (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
            (known.empty() ? "it takes none"
                           : fmt::format("It knows: {}", fmt::join(known, ", "))));
  }
}

YamlMap ReadYamlText(const std::string& text, const std::string& name, Faults* faults) {
  if (text.size() > kLargestFile_bytes) {
    throw InputError(
        {.file = name},
        fmt::format("{} bytes: larger than any file of this kind (at most {})",
                    text.size(),
                    kLargestFile_bytes));
  }
  RequireText(text, name);
  CheckYamlShape(text, name);
  YAML::Node root;
  try {
    CheckYamlEvents(text, name);
    root = YAML::Load(text);
    CheckYamlKeys(root, name, faults);
  } catch (const YAML::Exception& error) {
    throw InputError(
        {.file = name, .line = error.mark.line + 1, .column = error.mark.column + 1},
        fmt::format("this is not YAML: {}", error.msg));
  }
  if (!root.IsMap()) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     root.IsNull() ? "the file is empty"
                                   : "the file is not a mapping of keys to values");
  }
  return {root, name, "", faults};
}

YamlMap ReadYamlFile(const std::filesystem::path& file, Faults* faults) {
  return ReadYamlText(ReadTextFile(file, kLargestFile_bytes), file.string(), faults);
}

}  // namespace caltwin
