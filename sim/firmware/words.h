#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/firmware/expression.h"
#include "sim/link/gcode.h"

namespace caltwin::rrf {

/// The words of one command, their expressions evaluated. A letter given twice counts
/// once, with its last value, as in RepRapFirmware.
class Words {
 public:
  Words(const GcodeCommand& command, const Lookup& lookup);

  bool Has(char letter) const { return Find(letter) != nullptr; }
  /// Nullopt where the letter is absent; throws InputError, naming the command, where
  /// it has no number.
  std::optional<double> Number(char letter) const;
  /// Z0:1:2, or a single number: all of them. Throws as Number.
  std::optional<std::vector<double>> Numbers(char letter) const;
  std::optional<int> Whole(char letter, int min, int max) const;
  std::optional<std::string> Text(char letter) const;
  const std::vector<std::pair<char, Value>>& values() const { return values_; }

 private:
  const Value* Find(char letter) const;
  /// For messages.
  std::string Name() const;

  char letter_;
  int code_, minor_;
  std::vector<std::pair<char, Value>> values_{};
};

}  // namespace caltwin::rrf
