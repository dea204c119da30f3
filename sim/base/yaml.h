#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "sim/base/distribution.h"
#include "sim/base/input_error.h"

namespace caltwin {

/// Inclusive bounds of a number read from a file.
struct Bounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  bool Contains(double value) const { return min <= value && value <= max; }
};
inline constexpr Bounds kAnyNumber{-1e12, 1e12};
inline constexpr Bounds kPositive{1e-12, 1e12};
inline constexpr Bounds kNotNegative{0, 1e12};

class YamlMap;

/// One value of a YAML file, with its place and its dotted path ("effects.backlash.x").
///
/// Reading never throws: a value that is not what was asked for goes to `Faults`, and a
/// stand-in within the bounds is returned, so that one reading shows every fault of a
/// file. Call `Faults::ThrowIfAny` before using what was read.
class YamlValue {
 public:
  /// `key`: the place of the key, which stands for that of an empty value.
  YamlValue(const YAML::Node& node,
            std::string file,
            std::string path,
            Faults* faults,
            std::optional<Place> key = std::nullopt);

  bool is_map() const { return node_.IsMap(); }
  bool is_list() const { return node_.IsSequence(); }
  bool is_scalar() const { return node_.IsScalar(); }
  bool is_null() const { return node_.IsNull(); }

  /// A finite number within bounds (inclusive); `hint` tells how to think of the value.
  double Number(Bounds bounds = kAnyNumber, std::string_view hint = "") const;
  /// A number or one of {normal: {mean, sd}}, {uniform: {min, max}}, {lognormal:
  /// {median, factor}}; a plain number must lie within the bounds. What is drawn beyond
  /// them is to be clamped to them (Faults::Note says how often, from 0.1 % on).
  Distribution NumberOrDistribution(Bounds bounds = kAnyNumber,
                                    std::string_view hint = "") const;
  std::int64_t Integer(std::int64_t min, std::int64_t max) const;
  bool Flag() const;
  std::string Text() const;
  /// The text, which must be one of `allowed`; else a fault and the first of them.
  std::string Word(const std::vector<std::string>& allowed) const;
  YamlMap Map() const;
  std::vector<YamlValue> List() const;
  /// A list of exactly `count` numbers (a fault and zeros otherwise).
  std::vector<double> Numbers(std::size_t count, Bounds bounds = kAnyNumber) const;

  /// {first: {second: this}}, or {first: this} where there is no second: a map that the
  /// file does not have, with this value's place for its faults.
  YamlMap Within(const std::string& first, const std::string& second = "") const;

  Place place() const;
  const std::string& file() const { return file_; }
  const std::string& path() const { return path_; }
  Faults* faults() const { return faults_; }
  /// Adds the fault "`path` `text`" at this value's place.
  void Fail(const std::string& text, const std::string& hint = "") const;
  /// As written, for messages and for the verbatim copy kept with results.
  std::string AsWritten() const;

 private:
  std::string NotA(std::string_view wanted) const;
  void NoteWhatIsClamped(const Distribution& distribution, Bounds bounds) const;
  YAML::Node node_;
  std::string file_;
  std::string path_;
  Faults* faults_;
  std::optional<Place> key_;
};

/// One YAML mapping, read strictly: each key is asked for by name, and a key nobody
/// asked for is a fault, so a misspelt key never means "silently the default".
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, std::string file, std::string path, Faults* faults);

  bool Has(const std::string& key);
  /// The value; nullopt and a fault where it is missing. Where the file has a similar
  /// key that nobody asks for, that one is the fault (see NoMoreKeys).
  std::optional<YamlValue> Required(const std::string& key);
  std::optional<YamlValue> Optional(const std::string& key);
  /// Every entry in file order, all of them counted as asked for.
  std::vector<std::pair<std::string, YamlValue>> Entries();

  /// @name Shorthands. A missing required key is a fault, as above.
  double Number(const std::string& key,
                Bounds bounds = kAnyNumber,
                std::string_view hint = "");
  double NumberOr(const std::string& key,
                  double otherwise,
                  Bounds bounds = kAnyNumber,
                  std::string_view hint = "");
  std::int64_t IntegerOr(const std::string& key,
                         std::int64_t otherwise,
                         std::int64_t min,
                         std::int64_t max);
  bool FlagOr(const std::string& key, bool otherwise);
  std::string Text(const std::string& key);
  std::string TextOr(const std::string& key, const std::string& otherwise);
  std::string WordOr(const std::string& key,
                     const std::string& otherwise,
                     const std::vector<std::string>& allowed);

  Place place() const;
  Faults* faults() const { return faults_; }
  const std::string& file() const { return file_; }
  const std::string& path() const { return path_; }
  /// Adds a fault for each key never asked for, with the nearest known one. Call last.
  void NoMoreKeys();

 private:
  std::string PathOf(const std::string& key) const;
  Place PlaceOfKey(const std::string& key) const;
  void AddMissing(const std::string& key) const;
  YAML::Node node_;
  std::string file_;
  std::string path_;
  Faults* faults_;
  std::set<std::string> asked_;
  /// Missing keys, each with a key of the file that may be a misspelling of it.
  std::vector<std::pair<std::string, std::string>> perhaps_misspelt_;
};

/// Reads a file of at most 1 MB into its root mapping. Throws InputError for what is no
/// readable YAML mapping: missing file, a folder, empty, not UTF-8, too large, a syntax
/// error (with its line), tags, anchors, a second document, nesting beyond 32. Later
/// faults (a key twice among them) go to `faults`, which must outlive the map.
YamlMap ReadYamlFile(const std::filesystem::path& file, Faults* faults);
/// The same from text; `name` stands in messages.
YamlMap ReadYamlText(const std::string& text, const std::string& name, Faults* faults);

}  // namespace caltwin
