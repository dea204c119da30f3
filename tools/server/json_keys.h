#pragma once

#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/server/problem.h"

namespace caltwin {

/// What a number of a body may be.
struct NumberRange {
  double least = -std::numeric_limits<double>::max();
  double most = std::numeric_limits<double>::max();
  std::string unit{};  ///< "mm", for the message.
};

/// Reads the keys of a JSON object and gathers every fault, each with its place
/// (`pointer`); Done throws them together. What a faulty key reads as is its fallback.
class JsonKeys {
 public:
  /// Throws Problem 422 where `tree` is no object. `tree` is borrowed; `at` is where it
  /// stands in the body (RFC 6901), "" the body itself.
  explicit JsonKeys(const nlohmann::ordered_json& tree, std::string at = "");

  bool Has(const std::string& key) const { return tree_->contains(key); }
  double Number(const std::string& key, const NumberRange& range);
  double Number(const std::string& key, const NumberRange& range, double fallback);
  int Integer(const std::string& key, int least, int most, int fallback);
  bool Bool(const std::string& key, bool fallback);
  std::string Text(const std::string& key, const std::string& fallback);
  /// An object of any keys, empty where the key is left out and may be.
  nlohmann::ordered_json Object(const std::string& key,
                                std::size_t most_bytes,
                                bool is_required = false);
  /// A list of `least` to `most` lists of `size` numbers each.
  std::vector<std::vector<double>> Tuples(const std::string& key,
                                          std::size_t size,
                                          std::size_t least,
                                          std::size_t most);

  void Add(const std::string& pointer,
           const std::string& detail,
           const std::string& hint);
  /// Throws Problem 422 with what was gathered, keys that nobody asked for first.
  void Done();

 private:
  const nlohmann::ordered_json* Find(const std::string& key);
  std::optional<double> NumberAt(const nlohmann::ordered_json& value,
                                 const std::string& pointer,
                                 const NumberRange& range);

  const nlohmann::ordered_json* tree_;
  std::string at_;
  std::set<std::string> known_{};
  std::vector<ProblemFault> faults_{};
};

}  // namespace caltwin
