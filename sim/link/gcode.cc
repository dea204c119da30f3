#include "sim/link/gcode.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/link/gcode_frame.h"

namespace caltwin {
namespace {

constexpr std::size_t kLongestLine = 1000;
constexpr double kSecondsPerMinute = 60;

constexpr std::array<std::string_view, 16> kMetaWords = {"if",
                                                         "elif",
                                                         "else",
                                                         "while",
                                                         "break",
                                                         "continue",
                                                         "return",
                                                         "abort",
                                                         "var",
                                                         "global",
                                                         "set",
                                                         "echo",
                                                         "param",
                                                         "skip",
                                                         "local",
                                                         "const"};

bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}
bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}
bool IsLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
char Capital(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

/// Reads one line from left to right.
class Reader {
 public:
  explicit Reader(std::string_view line) : line_(line), end_(line.size()) {}

  GcodeLine Read();
  /// The same without its commands.
  GcodeLine ReadFrame();

 private:
  [[noreturn]] void Fail(const std::string& text, const std::string& hint = "") const {
    throw InputError(Place{"G-code", 1, static_cast<int>(at_) + 1}, text, hint);
  }
  bool done() const { return at_ >= end_; }
  char now() const { return line_[at_]; }
  void SkipSpace() {
    while (!done() && IsSpace(now())) ++at_;
  }
  /// Past white space and bracketed comments.
  void SkipBlanks();
  bool StartsWithMetaWord() const;
  void CutComment();
  void CutChecksum();
  std::size_t EndOfQuoted(std::size_t from) const;
  std::size_t EndOfBraces(std::size_t from) const;
  /// The first of `marks` outside quotes, braces and bracketed comments, or the end.
  std::size_t FindOutside(std::string_view marks) const;
  std::optional<double> ReadNumber();
  int ReadWhole(std::string_view what);
  GcodeCommand ReadCommand(bool is_first);
  GcodeWord ReadWord();
  std::string ReadQuoted();
  void ReadFreeText(GcodeCommand* command);

  std::string_view line_;
  std::size_t at_ = 0;
  std::size_t end_;
};

void Reader::SkipBlanks() {
  SkipSpace();
  while (!done() && now() == '(') {
    const std::size_t close = line_.find(')', at_);
    if (close >= end_) Fail("'(' opens a comment that no ')' closes");
    at_ = close + 1;
    SkipSpace();
  }
}

bool Reader::StartsWithMetaWord() const {
  // Nearly every line begins with a letter and a digit: "G1".
  if (at_ + 1 < end_ && !IsLetter(line_[at_ + 1])) return false;
  std::size_t stop = at_;
  while (stop < end_ && IsLetter(line_[stop])) ++stop;
  if (stop < end_ && (IsDigit(line_[stop]) || line_[stop] == '_')) return false;
  const std::string_view word = line_.substr(at_, stop - at_);
  return std::ranges::find(kMetaWords, word) != kMetaWords.end();
}

std::size_t Reader::EndOfQuoted(std::size_t from) const {
  const std::size_t close = line_.find('"', from + 1);
  return close >= end_ ? end_ : close + 1;
}

std::size_t Reader::EndOfBraces(std::size_t from) const {
  int depth = 0;
  std::size_t i = from;
  while (i < end_) {
    if (line_[i] == '"') {
      i = EndOfQuoted(i);
      continue;
    }
    if (line_[i] == '{') ++depth;
    if (line_[i] == '}' && --depth == 0) return i + 1;
    ++i;
  }
  return end_;
}

std::size_t Reader::FindOutside(std::string_view marks) const {
  std::size_t i = at_;
  while (i < end_) {
    const char c = line_[i];
    if (marks.find(c) != std::string_view::npos) return i;
    if (c == '"') {
      i = EndOfQuoted(i);
    } else if (c == '{') {
      i = EndOfBraces(i);
    } else if (c == '(') {
      i = std::min(line_.find(')', i), end_ - 1) + 1;
    } else {
      ++i;
    }
  }
  return end_;
}

void Reader::CutComment() {
  // In a meta command brackets are arithmetic, so only quotes and braces hide a ';'.
  std::size_t i = at_;
  while (i < end_ && line_[i] != ';') i = line_[i] == '"' ? EndOfQuoted(i) : i + 1;
  end_ = i;
}

void Reader::CutChecksum() {
  if (line_.substr(0, end_).find('*') == std::string_view::npos) return;
  const std::size_t star = FindOutside("*");
  if (star == end_) return;
  const int computed = GcodeChecksum(line_.substr(0, star));
  const std::size_t start = at_;
  at_ = star + 1;
  const int stated = ReadWhole("a checksum");
  SkipSpace();
  if (!done()) Fail("something stands behind the checksum");
  if (stated != computed) {
    at_ = star;
    Fail(fmt::format("checksum {} where the line gives {}", stated, computed));
  }
  at_ = start;
  end_ = star;
}

std::optional<double> Reader::ReadNumber() {
  std::size_t first = at_;
  if (first < end_ && line_[first] == '+') ++first;
  const std::size_t sign = first < end_ && line_[first] == '-' ? 1 : 0;
  const bool starts_well =
      first + sign < end_ && (IsDigit(line_[first + sign]) ||
                              (line_[first + sign] == '.' && first + sign + 1 < end_ &&
                               IsDigit(line_[first + sign + 1])));
  if (!starts_well) return std::nullopt;
  double value = 0;
  const char* const begin = line_.data() + first;
  const auto [stop, error] =
      std::from_chars(begin, line_.data() + end_, value, std::chars_format::fixed);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  at_ = first + static_cast<std::size_t>(stop - begin);
  return value;
}

int Reader::ReadWhole(std::string_view what) {
  int value = 0;
  const char* const begin = line_.data() + at_;
  const auto [stop, error] = std::from_chars(begin, line_.data() + end_, value);
  if (error != std::errc() || value < 0)
    Fail(fmt::format("expected {}: a whole number", what));
  at_ += static_cast<std::size_t>(stop - begin);
  return value;
}

std::string Reader::ReadQuoted() {
  std::string text;
  for (++at_; !done(); ++at_) {
    if (now() != '"') {
      text += now();
    } else if (at_ + 1 < end_ && line_[at_ + 1] == '"') {
      text += '"';
      ++at_;
    } else {
      ++at_;
      return text;
    }
  }
  Fail("a '\"' opens a string that no '\"' closes");
}

GcodeWord Reader::ReadWord() {
  if (!IsLetter(now())) {
    const char c = now();
    Fail(std::isprint(static_cast<unsigned char>(c)) != 0
             ? fmt::format("'{}' begins no word", c)
             : fmt::format("byte {} begins no word", static_cast<unsigned char>(c)),
         "a word is a letter with a number, \"text\" or {expression} behind it");
  }
  GcodeWord word{.letter = Capital(now())};
  ++at_;
  SkipSpace();
  if (done()) return word;
  if (now() == '"') {
    word.kind = GcodeWord::Kind::kQuoted;
    word.text = ReadQuoted();
  } else if (now() == '{') {
    const std::size_t stop = EndOfBraces(at_);
    if (line_[stop - 1] != '}') Fail("'{' opens an expression that no '}' closes");
    word.kind = GcodeWord::Kind::kExpression;
    word.text = std::string(line_.substr(at_ + 1, stop - at_ - 2));
    at_ = stop;
  } else if (const auto number = ReadNumber()) {
    word.kind = GcodeWord::Kind::kNumber;
    word.number = *number;
    while (!done() && now() == ':') {
      ++at_;
      const auto next = ReadNumber();
      if (!next) Fail("expected a number behind ':'");
      word.kind = GcodeWord::Kind::kNumbers;
      word.more.push_back(*next);
    }
  }
  return word;
}

void Reader::ReadFreeText(GcodeCommand* command) {
  const std::size_t start = at_;
  try {
    for (SkipBlanks(); !done(); SkipBlanks()) command->words.push_back(ReadWord());
  } catch (const InputError&) {
    command->words.clear();  // Plain text: `rest` has it.
  }
  command->rest = std::string(line_.substr(start, end_ - start));
  at_ = end_;
}

GcodeCommand Reader::ReadCommand(bool is_first) {
  GcodeCommand command;
  const char letter = Capital(now());
  const bool starts_command =
      letter == 'G' || letter == 'M' || (letter == 'T' && is_first);
  if (starts_command) {
    ++at_;
    command.letter = letter;
    if (letter == 'T' && !done() && now() == '-') {
      ++at_;
      command.code = -ReadWhole("a tool number");
    } else if (letter != 'T' || (!done() && IsDigit(now()))) {
      command.code = ReadWhole(letter == 'G'   ? "the number of a G command"
                               : letter == 'M' ? "the number of an M command"
                                               : "the number of a T command");
    }
    if (!done() && now() == '.') {
      ++at_;
      command.minor = ReadWhole("the digit behind the dot");
    }
    if (command.Is('M', 117) || command.Is('M', 118)) {
      SkipSpace();
      ReadFreeText(&command);
      return command;
    }
  }
  constexpr std::size_t kUsualWords = 4;
  for (SkipBlanks(); !done(); SkipBlanks()) {
    const char next = Capital(now());
    if (next == 'G' || next == 'M') break;
    if (command.words.empty()) command.words.reserve(kUsualWords);
    command.words.push_back(ReadWord());
  }
  return command;
}

GcodeLine Reader::ReadFrame() {
  GcodeLine parsed;
  while (!done() && (now() == ' ' || now() == '\t')) ++at_;
  parsed.indent = static_cast<int>(at_);
  SkipBlanks();
  if (done()) return parsed;
  parsed.is_meta = StartsWithMetaWord();
  CutComment();
  if (!parsed.is_meta) {
    CutChecksum();
    if (!done() && Capital(now()) == 'N') {
      ++at_;
      const bool is_negative = !done() && now() == '-';
      if (is_negative) ++at_;
      const int number = ReadWhole("a line number");
      parsed.number = is_negative ? -number : number;
      SkipBlanks();
      parsed.is_meta = StartsWithMetaWord();
    }
  }
  std::size_t last = end_;
  while (last > at_ && IsSpace(line_[last - 1])) --last;
  parsed.text = std::string(line_.substr(at_, last - at_));
  return parsed;
}

GcodeLine Reader::Read() {
  GcodeLine parsed = ReadFrame();
  if (parsed.is_meta) return parsed;
  constexpr std::size_t kUsualCommands = 2;  // G53 G1 ...
  parsed.commands.reserve(kUsualCommands);
  for (SkipBlanks(); !done(); SkipBlanks()) {
    parsed.commands.push_back(ReadCommand(parsed.commands.empty()));
  }
  return parsed;
}

void RequireShort(std::string_view line) {
  if (line.size() <= kLongestLine) return;
  throw InputError(Place{"G-code", 1, static_cast<int>(kLongestLine)},
                   fmt::format("a line of {} bytes", line.size()),
                   fmt::format("{} are allowed", kLongestLine));
}

}  // namespace

double FeedFromWord_mm_s(double f_mm_min) {
  return f_mm_min / kSecondsPerMinute;
}

double FeedWord_mm_min(double feed_mm_s) {
  return feed_mm_s * kSecondsPerMinute;
}

const GcodeWord* GcodeCommand::Find(char wanted) const {
  const auto found = std::ranges::find(words, wanted, &GcodeWord::letter);
  return found == words.end() ? nullptr : &*found;
}

std::optional<double> GcodeCommand::Number(char wanted) const {
  const GcodeWord* word = Find(wanted);
  if (word == nullptr || word->kind != GcodeWord::Kind::kNumber) return std::nullopt;
  return word->number;
}

std::string GcodeCommand::Name() const {
  if (letter == 0 && words.empty()) return "a line without a command";
  std::string name(1, letter == 0 ? words.front().letter : letter);
  if (code >= 0) name += fmt::format("{}", code);
  if (minor > 0) name += fmt::format(".{}", minor);
  return name;
}

GcodeLine ParseGcode(std::string_view line) {
  RequireShort(line);
  return Reader(line).Read();
}

GcodeFrame ReadGcodeFrame(std::string_view line) {
  RequireShort(line);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto byte = static_cast<unsigned char>(line[i]);
    if (byte >= ' ' || IsSpace(line[i])) continue;
    throw InputError(Place{"G-code", 1, static_cast<int>(i) + 1},
                     fmt::format("byte {} begins no word", byte));
  }
  GcodeLine parsed = Reader(line).ReadFrame();
  return {.number = parsed.number, .text = std::move(parsed.text)};
}

int GcodeChecksum(std::string_view bytes) {
  unsigned sum = 0;
  for (const char c : bytes) sum ^= static_cast<unsigned char>(c);
  return static_cast<int>(sum);
}

}  // namespace caltwin
