#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/study/aggregate.h"

namespace caltwin {

/// Which pieces of work, counted from 0, are done: all before one of them, and the few
/// beyond it that ended sooner. Memory does not grow with their number.
class DoneIndices {
 public:
  void Add(std::int64_t index);
  bool Has(std::int64_t index) const;
  std::int64_t count() const;
  /// Throws what nlohmann does, or std::invalid_argument, where the tree is none.
  nlohmann::json ToJson() const;
  static DoneIndices OfJson(const nlohmann::json& json);

 private:
  std::int64_t before_ = 0;
  std::set<std::int64_t> beyond_{};
};

/// What a study that keeps no trials knows of its contenders, in their order.
using Aggregates = std::vector<Aggregate>;

/// A study, or part of one, that keeps no trials, on its way.
struct HalfDone {
  Aggregates aggregates{};
  DoneIndices done{};  ///< Runs of its shard; of a linear one blocks of trials.

  /// Without loss: what is read again goes on as if nothing had happened.
  std::string Text() const;
  /// Throws what nlohmann does, or std::invalid_argument, where it is none.
  static HalfDone OfText(const std::string& text);
};

}  // namespace caltwin
