#include "sim/firmware/expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/firmware/functions.h"

namespace caltwin::rrf {
namespace {

constexpr int kDeepestNesting = 64;

bool IsNameStart(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool IsNamePart(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// Recursive descent, one function a level of binding, the loosest first.
class Parser {
 public:
  Parser(std::string_view text, const Lookup& lookup) : text_(text), lookup_(lookup) {}

  Value ReadAll() {
    Value value = ReadChoice();
    ExpectEnd();
    return value;
  }
  std::vector<Value> ReadListToEnd() {
    std::vector<Value> values;
    SkipSpace();
    if (at_ == text_.size()) return values;
    do {
      values.push_back(ReadChoice());
    } while (Take(","));
    ExpectEnd();
    return values;
  }
  Path ReadPath();
  std::string_view rest() const { return text_.substr(at_); }

 private:
  void SkipSpace() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  char Next() {
    SkipSpace();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool Take(std::string_view mark) {
    SkipSpace();
    if (text_.substr(at_, mark.size()) != mark) return false;
    at_ += mark.size();
    return true;
  }
  void Expect(std::string_view mark) {
    if (!Take(mark)) Fail(fmt::format("expected '{}'", mark));
  }
  void ExpectEnd() {
    if (Next() != '\0') Fail("unexpected characters after the expression");
  }
  [[noreturn]] void Fail(const std::string& what) const {
    const auto left = text_.substr(std::min(at_, text_.size()), 20);
    throw InputError(
        {},
        left.empty() ? what + " at the end" : fmt::format("{} at '{}'", what, left));
  }
  Value ReadChoice();
  Value ReadJoined();
  Value ReadLogic();
  Value ReadComparison();
  Value ReadSum();
  Value ReadProduct();
  Value ReadSigned();
  Value ReadPrimary();
  Value ReadNumber();
  Value ReadQuoted();
  Value ReadBraces();
  Value ReadNamed();
  Value ReadExists();
  std::vector<Value> ReadArguments();
  /// Combines two values, but only where the result is wanted.
  template <typename Combine>
  Value IfWanted(Combine combine) const {
    return is_wanted_ ? combine() : Value{};
  }

  std::string_view text_;
  const Lookup& lookup_;
  std::size_t at_ = 0;
  bool is_wanted_ = true;  ///< false in a branch that was not chosen.
  int depth_ = 0;
};

Value Parser::ReadChoice() {
  if (++depth_ > kDeepestNesting) Fail("the expression is nested too deeply");
  Value value = ReadJoined();
  if (Take("?")) {
    const bool was_wanted = is_wanted_;
    const bool condition = was_wanted && value.Flag();
    is_wanted_ = was_wanted && condition;
    Value yes = ReadChoice();
    Expect(":");
    is_wanted_ = was_wanted && !condition;
    Value no = ReadChoice();
    is_wanted_ = was_wanted;
    value = condition ? std::move(yes) : std::move(no);
  }
  --depth_;
  return value;
}

Value Parser::ReadJoined() {
  Value left = ReadLogic();
  while (Take("^")) {
    const Value right = ReadLogic();
    left = IfWanted([&] { return Value{ToText(left) + ToText(right)}; });
  }
  return left;
}

Value Parser::ReadLogic() {
  Value left = ReadComparison();
  for (;;) {
    const bool is_and = Take("&&") || Take("&");
    if (!is_and && !Take("||") && !Take("|")) return left;
    const bool was_wanted = is_wanted_;
    const bool first = was_wanted && left.Flag();
    is_wanted_ = was_wanted && first == is_and;
    const Value right = ReadComparison();
    const bool second = is_wanted_ ? right.Flag() : first;
    is_wanted_ = was_wanted;
    left = IfWanted([&] { return Value{second}; });
  }
}

Value Parser::ReadComparison() {
  static constexpr std::array<std::string_view, 7> kMarks = {
      "==", "!=", "<=", ">=", "=", "<", ">"};
  Value left = ReadSum();
  for (;;) {
    const auto* const mark =
        std::ranges::find_if(kMarks, [&](std::string_view m) { return Take(m); });
    if (mark == kMarks.end()) return left;
    const Value right = ReadSum();
    left = IfWanted([&] { return Compare(left, *mark, right); });
  }
}

Value Parser::ReadSum() {
  Value left = ReadProduct();
  for (char mark = Next(); mark == '+' || mark == '-'; mark = Next()) {
    ++at_;
    const Value right = ReadProduct();
    left = IfWanted([&] { return Calculate(left, mark, right); });
  }
  return left;
}

Value Parser::ReadProduct() {
  Value left = ReadSigned();
  for (char mark = Next(); mark == '*' || mark == '/' || mark == '%'; mark = Next()) {
    ++at_;
    const Value right = ReadSigned();
    left = IfWanted([&] { return Calculate(left, mark, right); });
  }
  return left;
}

Value Parser::ReadSigned() {
  if (++depth_ > kDeepestNesting) Fail("the expression is nested too deeply");
  const char mark = Next();
  Value value;
  if (mark == '-' || mark == '+' || mark == '!' || mark == '#') {
    ++at_;
    const Value operand = ReadSigned();
    value = IfWanted([&] { return ApplySign(mark, operand); });
  } else {
    value = ReadPrimary();
  }
  --depth_;
  return value;
}

Value Parser::ReadPrimary() {
  const char next = Next();
  if (next == '"') return ReadQuoted();
  if (next == '{') return ReadBraces();
  if (next == '(') {
    ++at_;
    Value value = ReadChoice();
    Expect(")");
    return value;
  }
  if (std::isdigit(static_cast<unsigned char>(next)) != 0 || next == '.') {
    return ReadNumber();
  }
  if (IsNameStart(next)) return ReadNamed();
  Fail("expected an expression");
}

Value Parser::ReadNumber() {
  const char* const begin = text_.data() + at_;
  const char* const end = text_.data() + text_.size();
  double number = 0;
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (error != std::errc()) Fail("expected a number");
  std::int64_t whole = 0;
  const auto [whole_stop, whole_error] = std::from_chars(begin, end, whole);
  at_ += static_cast<std::size_t>(stop - begin);
  if (whole_error == std::errc() && whole_stop == stop) return Value{whole};
  return Value{number};
}

Value Parser::ReadQuoted() {
  std::string text;
  for (++at_; at_ < text_.size(); ++at_) {
    if (text_[at_] != '"') {
      text += text_[at_];
    } else if (text_.substr(at_, 2) == "\"\"") {
      text += '"';
      ++at_;
    } else {
      ++at_;
      return Value{text};
    }
  }
  Fail("string has no closing quote");
}

Value Parser::ReadBraces() {
  ++at_;
  Value::Array elements;
  bool is_array = false;
  while (Next() != '}') {
    elements.push_back(ReadChoice());
    if (!Take(",")) break;
    is_array = true;
  }
  Expect("}");
  if (is_array || elements.empty()) return Value{std::move(elements)};
  return elements.front();
}

Path Parser::ReadPath() {
  Path path;
  SkipSpace();
  for (;;) {
    if (at_ >= text_.size() || !IsNameStart(text_[at_])) Fail("expected a name");
    const std::size_t start = at_;
    while (at_ < text_.size() && IsNamePart(text_[at_])) ++at_;
    path.emplace_back(std::string(text_.substr(start, at_ - start)));
    while (at_ < text_.size() && text_[at_] == '[') {
      ++at_;
      const Value index = ReadChoice();
      Expect("]");
      path.emplace_back(is_wanted_ ? index.Whole() : 0);
    }
    if (at_ >= text_.size() || text_[at_] != '.') return path;
    ++at_;
  }
}

std::vector<Value> Parser::ReadArguments() {
  std::vector<Value> arguments;
  if (Take(")")) return arguments;
  do {
    arguments.push_back(ReadChoice());
  } while (Take(","));
  Expect(")");
  return arguments;
}

Value Parser::ReadExists() {
  const Path path = ReadPath();
  Expect(")");
  return IfWanted([&] {
    const auto found = lookup_(path);
    return Value{found.has_value() && !found->is_null()};
  });
}

Value Parser::ReadNamed() {
  const Path path = ReadPath();
  const std::string name = ToText(path);
  if (Take("(")) {
    if (name == "exists") return ReadExists();
    const std::vector<Value> arguments = ReadArguments();
    return IfWanted([&] { return CallFunction(name, arguments); });
  }
  if (name == "true" || name == "false") return Value{name == "true"};
  if (name == "null") return Value{};
  if (name == "pi") return Value{std::numbers::pi};
  return IfWanted([&] {
    auto found = lookup_(path);
    if (found) return *found;
    const bool is_variable = name.starts_with("global.") || name.starts_with("var.") ||
                             name.starts_with("param.");
    throw InputError({},
                     is_variable ? fmt::format("unknown variable '{}'",
                                               name.substr(name.find('.') + 1))
                                 : fmt::format("unknown value '{}'", name));
  });
}

}  // namespace

std::string ToText(const Path& path) {
  std::string text;
  for (const PathStep& step : path) {
    if (const auto* name = std::get_if<std::string>(&step)) {
      if (!text.empty()) text += '.';
      text += *name;
    } else {
      text += fmt::format("[{}]", std::get<std::int64_t>(step));
    }
  }
  return text;
}

Value Evaluate(std::string_view text, const Lookup& lookup) {
  return Parser(text, lookup).ReadAll();
}

std::vector<Value> EvaluateList(std::string_view text, const Lookup& lookup) {
  return Parser(text, lookup).ReadListToEnd();
}

Path ParsePath(std::string_view text, const Lookup& lookup, std::string_view* rest) {
  Parser parser(text, lookup);
  Path path = parser.ReadPath();
  *rest = parser.rest();
  return path;
}

std::optional<Value> Element(const Value& value, const Path& path, std::size_t first) {
  const Value* now = &value;
  for (std::size_t i = first; i < path.size(); ++i) {
    const auto* const index = std::get_if<std::int64_t>(&path[i]);
    const Value::Array* const array = now->array();
    if (index == nullptr || array == nullptr || *index < 0 ||
        *index >= static_cast<std::int64_t>(array->size())) {
      return std::nullopt;
    }
    now = &(*array)[static_cast<std::size_t>(*index)];
  }
  return *now;
}

}  // namespace caltwin::rrf
