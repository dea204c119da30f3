#include "sim/firmware/words.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin::rrf {
namespace {

Value ValueOf(const GcodeWord& word, const Lookup& lookup) {
  switch (word.kind) {
    case GcodeWord::Kind::kNumber:
      if (std::floor(word.number) == word.number && std::abs(word.number) < 1e9) {
        return Value{static_cast<std::int64_t>(word.number)};
      }
      return Value{word.number};
    case GcodeWord::Kind::kQuoted:
      return Value{word.text};
    case GcodeWord::Kind::kExpression:
      return Evaluate("{" + word.text + "}", lookup);
    case GcodeWord::Kind::kBare:
      break;
  }
  return Value{};
}

}  // namespace

Words::Words(const GcodeCommand& command, const Lookup& lookup)
    : command_(command.Name()) {
  for (const GcodeWord& word : command.words) {
    values_[word.letter] = ValueOf(word, lookup);
  }
}

std::optional<double> Words::Number(char letter) const {
  const auto found = values_.find(letter);
  if (found == values_.end()) return std::nullopt;
  if (!found->second.is_number() || !std::isfinite(found->second.Number())) {
    throw InputError({},
                     fmt::format("{}: expected number after '{}'", command_, letter));
  }
  return found->second.Number();
}

std::optional<int> Words::Whole(char letter, int min, int max) const {
  const auto number = Number(letter);
  if (!number) return std::nullopt;
  if (*number < min || *number > max || std::floor(*number) != *number) {
    throw InputError({},
                     fmt::format("{}: parameter '{}' is a whole number from {} to {}",
                                 command_,
                                 letter,
                                 min,
                                 max));
  }
  return static_cast<int>(*number);
}

std::optional<std::string> Words::Text(char letter) const {
  const auto found = values_.find(letter);
  if (found == values_.end()) return std::nullopt;
  const auto* const text = std::get_if<std::string>(&found->second.of);
  if (text == nullptr) {
    throw InputError({},
                     fmt::format("{}: expected string after '{}'", command_, letter));
  }
  return *text;
}

}  // namespace caltwin::rrf
