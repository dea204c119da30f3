#include "sim/firmware/grbl/block.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace caltwin::grbl {
namespace {

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Which of the groups, of which a line may have one command each, have one.
struct Groups {
  unsigned taken = 0;
  void Take(unsigned group) {
    if ((taken & (1U << group)) != 0) throw LineError(kModalGroupTwice);
    taken |= 1U << group;
  }
};

/// Numbers of groups, of G-code's standard for G; those of M behind.
enum Group : unsigned {
  kOfLineAlone = 0,
  kMotionMode = 1,
  kPlane = 2,
  kDistance = 3,
  kArcDistance = 4,
  kFeedMode = 5,
  kUnits = 6,
  kCutterRadius = 7,
  kToolLengthOffset = 8,
  kWorkplace = 12,
  kPathControl = 13,
  kProgram = 14,
  kSpindle = 15,
  kCoolant = 16
};

/// Reads one line into a block.
class BlockReader {
 public:
  explicit BlockReader(const Modal& modal) { block_.modal = modal; }
  Block Read(std::string_view line);

 private:
  void TakeG(int code, int hundredths);
  bool TakeAxisG(int code, int hundredths);
  void TakeM(int code);
  void TakeValue(char letter, double value);
  void TakeAxes(Block::AxisCommand command) {
    if (block_.axis_command != Block::AxisCommand::kNone)
      throw LineError(kTwoAxisCommands);
    block_.axis_command = command;
  }

  Block block_{};
  Groups groups_{};
};

/// Where a G with axis words is only one of several codes with a digit behind the dot.
void RequireWhole(int hundredths) {
  if (hundredths != 0) throw LineError(kNotWhole);
}

bool BlockReader::TakeAxisG(int code, int hundredths) {
  switch (code) {
    case 10:
    case 28:
    case 30:
    case 92: {
      // 28.1, 30.1 and 92.1 keep or forget a place: they take no axis words.
      if (hundredths == 0) TakeAxes(Block::AxisCommand::kNonModal);
      if (hundredths != 0 && (code == 10 || hundredths != 10))
        throw LineError(kUnsupported);
      groups_.Take(kOfLineAlone);
      block_.non_modal = hundredths == 0 ? code : 10 * code + 1;
      return true;
    }
    case 0:
    case 1:
    case 2:
    case 3:
      TakeAxes(Block::AxisCommand::kMotion);
      RequireWhole(hundredths);
      groups_.Take(kMotionMode);
      block_.modal.motion = code;
      return true;
    case 38:
      TakeAxes(Block::AxisCommand::kMotion);
      if (hundredths % 10 != 0 || hundredths < 20 || hundredths > 50)
        throw LineError(kUnsupported);
      groups_.Take(kMotionMode);
      block_.modal.motion = 380 + hundredths / 10;
      return true;
    case 43:
      TakeAxes(Block::AxisCommand::kToolLength);
      if (hundredths != 10) throw LineError(kUnsupported);
      groups_.Take(kToolLengthOffset);
      return true;
    default:
      return false;
  }
}

void BlockReader::TakeG(int code, int hundredths) {
  const bool is_for_jogs = code == 20 || code == 21 || code == 53 || code == 90 ||
                           (code == 91 && hundredths == 0);
  block_.has_more_than_jog = block_.has_more_than_jog || !is_for_jogs;
  if (TakeAxisG(code, hundredths)) return;
  Modal& modal = block_.modal;
  if (code == 91 && hundredths == 10) return groups_.Take(kArcDistance);
  if (code == 4 || code == 53) {
    groups_.Take(kOfLineAlone);
    block_.non_modal = code;
  } else if (code == 80) {
    groups_.Take(kMotionMode);
    modal.motion = kNoMotion;
  } else if (code >= 17 && code <= 19) {
    groups_.Take(kPlane);
    modal.plane = code;
  } else if (code == 90 || code == 91) {
    groups_.Take(kDistance);
    modal.is_relative = code == 91;
  } else if (code == 93 || code == 94) {
    groups_.Take(kFeedMode);
    modal.is_inverse_time = code == 93;
    block_.sets_feed_mode = true;
  } else if (code == 20 || code == 21) {
    groups_.Take(kUnits);
    modal.is_inches = code == 20;
  } else if (code == 40) {
    groups_.Take(kCutterRadius);
  } else if (code == 49) {
    TakeAxes(Block::AxisCommand::kToolLength);
    groups_.Take(kToolLengthOffset);
    block_.cancels_tool_length = true;
  } else if (code >= 54 && code <= 59) {
    groups_.Take(kWorkplace);
    modal.workplace = code - 54;
  } else if (code == 61) {
    groups_.Take(kPathControl);
  } else {
    throw LineError(kUnsupported);
  }
  RequireWhole(hundredths);
}

void BlockReader::TakeM(int code) {
  block_.has_more_than_jog = true;
  switch (code) {
    case 0:
    case 1:
    case 2:
    case 30:
      groups_.Take(kProgram);
      block_.program = code;
      break;
    case 3:
    case 4:
    case 5:
      groups_.Take(kSpindle);
      block_.modal.spindle = code;
      break;
    case 8:
    case 9:
      groups_.Take(kCoolant);
      block_.modal.has_flood = code == 8;
      break;
    default:
      throw LineError(kUnsupported);
  }
}

void BlockReader::TakeValue(char letter, double value) {
  constexpr std::string_view kKnown = "FIJKLNPRSTXYZ", kNeverNegative = "FNPTS";
  if (kKnown.find(letter) == std::string_view::npos) throw LineError(kUnsupported);
  std::optional<double>& place = block_.values[Block::Place(letter)];
  if (place) throw LineError(kWordRepeated);
  if (value < 0 && kNeverNegative.find(letter) != std::string_view::npos)
    throw LineError(kNegativeValue);
  place = value;
}

Block BlockReader::Read(std::string_view line) {
  std::size_t at = 0;
  while (at < line.size()) {
    const char letter = line[at++];
    if (letter < 'A' || letter > 'Z') throw LineError(kExpectedLetter);
    const auto value = ReadNumber(line, &at);
    if (!value) throw LineError(kBadNumber);
    if (letter != 'G' && letter != 'M') {
      TakeValue(letter, *value);
      continue;
    }
    constexpr double kLargest = 1000;
    if (*value < 0 || *value > kLargest) throw LineError(kUnsupported);
    const int code = static_cast<int>(*value);
    const int hundredths = static_cast<int>(std::lround(100 * (*value - code)));
    if (letter == 'G') {
      TakeG(code, hundredths);
    } else {
      RequireWhole(hundredths);
      TakeM(code);
    }
  }
  constexpr double kLastLine = 10'000'000;
  if (block_.Take('N').value_or(0) > kLastLine) throw LineError(kInvalidLineNumber);
  if (block_.has_axis_words() && block_.axis_command == Block::AxisCommand::kNone)
    block_.axis_command = Block::AxisCommand::kMotion;
  return block_;
}

}  // namespace

LineError::LineError(int number)
    : std::runtime_error(fmt::format("error:{}", number)), number_(number) {}

std::string Stripped(std::string_view line) {
  std::string stripped;
  bool is_in_brackets = false;
  for (const char c : line) {
    if (is_in_brackets) {
      is_in_brackets = c != ')';
    } else if (c == '(') {
      is_in_brackets = true;
    } else if (c == ';') {
      break;
    } else if (c > ' ' && c != '/') {
      stripped += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    }
  }
  return stripped;
}

std::optional<double> ReadNumber(std::string_view text, std::size_t* at) {
  std::size_t first = *at;
  if (first < text.size() && text[first] == '+') ++first;
  std::size_t last = first;
  if (last < text.size() && text[last] == '-') ++last;
  int digits = 0;
  for (bool has_dot = false; last < text.size(); ++last) {
    const bool is_dot = text[last] == '.' && !has_dot;
    if (!is_dot && !IsDigit(text[last])) break;
    has_dot = has_dot || is_dot;
    if (!is_dot) ++digits;
  }
  double value = 0;
  const auto [stop, error] = std::from_chars(
      text.data() + first, text.data() + last, value, std::chars_format::fixed);
  if (digits == 0 || error != std::errc() || !std::isfinite(value)) return std::nullopt;
  *at = last;
  return value;
}

std::optional<double> Block::Take(char letter) {
  return std::exchange(values[Place(letter)], std::nullopt);
}

bool Block::HasValues() const {
  return std::ranges::any_of(
      values, [](const std::optional<double>& value) { return value.has_value(); });
}

Block ReadBlock(std::string_view stripped, const Modal& modal) {
  return BlockReader(modal).Read(stripped);
}

}  // namespace caltwin::grbl
