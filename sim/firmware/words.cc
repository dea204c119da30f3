#include "sim/firmware/words.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin::rrf {
namespace {

Value ValueOf(double number) {
  if (std::floor(number) == number && std::abs(number) < 1e9) {
    return Value{static_cast<std::int64_t>(number)};
  }
  return Value{number};
}

Value ValueOf(const GcodeWord& word, const Lookup& lookup) {
  switch (word.kind) {
    case GcodeWord::Kind::kNumber:
      return ValueOf(word.number);
    case GcodeWord::Kind::kNumbers: {
      Value::Array numbers = {ValueOf(word.number)};
      for (const double number : word.more) numbers.push_back(ValueOf(number));
      return Value{std::move(numbers)};
    }
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
    : letter_(command.letter), code_(command.code), minor_(command.minor) {
  values_.reserve(command.words.size());
  for (const GcodeWord& word : command.words) {
    const auto known =
        std::ranges::find(values_, word.letter, &std::pair<char, Value>::first);
    if (known == values_.end()) {
      values_.emplace_back(word.letter, ValueOf(word, lookup));
    } else {
      known->second = ValueOf(word, lookup);
    }
  }
}

const Value* Words::Find(char letter) const {
  const auto found = std::ranges::find(values_, letter, &std::pair<char, Value>::first);
  return found == values_.end() ? nullptr : &found->second;
}

std::string Words::Name() const {
  return GcodeCommand{.letter = letter_, .code = code_, .minor = minor_}.Name();
}

std::optional<double> Words::Number(char letter) const {
  const Value* const found = Find(letter);
  if (found == nullptr) return std::nullopt;
  if (!found->is_number() || !std::isfinite(found->Number())) {
    throw InputError({}, fmt::format("{}: expected number after '{}'", Name(), letter));
  }
  return found->Number();
}

std::optional<std::vector<double>> Words::Numbers(char letter) const {
  const Value* const found = Find(letter);
  if (found == nullptr) return std::nullopt;
  const Value::Array* const several = found->array();
  if (several == nullptr) return std::vector<double>{*Number(letter)};
  std::vector<double> numbers;
  for (const Value& one : *several) {
    if (!one.is_number() || !std::isfinite(one.Number())) {
      throw InputError({},
                       fmt::format("{}: expected numbers after '{}'", Name(), letter));
    }
    numbers.push_back(one.Number());
  }
  return numbers;
}

std::optional<int> Words::Whole(char letter, int min, int max) const {
  const auto number = Number(letter);
  if (!number) return std::nullopt;
  if (*number < min || *number > max || std::floor(*number) != *number) {
    throw InputError({},
                     fmt::format("{}: parameter '{}' is a whole number from {} to {}",
                                 Name(),
                                 letter,
                                 min,
                                 max));
  }
  return static_cast<int>(*number);
}

std::optional<std::string> Words::Text(char letter) const {
  const Value* const found = Find(letter);
  if (found == nullptr) return std::nullopt;
  const auto* const text = std::get_if<std::string>(&found->of);
  if (text == nullptr) {
    throw InputError({}, fmt::format("{}: expected string after '{}'", Name(), letter));
  }
  return *text;
}

}  // namespace caltwin::rrf
