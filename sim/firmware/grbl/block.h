#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/machine/axis.h"

namespace caltwin::grbl {

/// Why a line is refused: `error:n`, with grbl 1.1's number.
class LineError : public std::runtime_error {
 public:
  explicit LineError(int number);
  int number() const { return number_; }

 private:
  int number_;
};

/// @name Numbers of LineError, as grbl 1.1's documentation of its interface lists them
inline constexpr int kExpectedLetter = 1;
inline constexpr int kBadNumber = 2;
inline constexpr int kInvalidStatement = 3;
inline constexpr int kNegativeValue = 4;
inline constexpr int kHomingIsOff = 5;
inline constexpr int kPulseTooShort = 6;
inline constexpr int kNotIdle = 8;
inline constexpr int kLocked = 9;
inline constexpr int kSoftLimitsNeedHoming = 10;
inline constexpr int kLineTooLong = 11;
inline constexpr int kTravelExceeded = 15;
inline constexpr int kInvalidJog = 16;
inline constexpr int kUnsupported = 20;
inline constexpr int kModalGroupTwice = 21;
inline constexpr int kUndefinedFeed = 22;
inline constexpr int kNotWhole = 23;
inline constexpr int kTwoAxisCommands = 24;
inline constexpr int kWordRepeated = 25;
inline constexpr int kNoAxisWords = 26;
inline constexpr int kInvalidLineNumber = 27;
inline constexpr int kValueMissing = 28;
inline constexpr int kNoSuchWorkplace = 29;
inline constexpr int kNotWithG53 = 30;
inline constexpr int kUnusedAxisWords = 31;
inline constexpr int kArcOutOfPlane = 32;
inline constexpr int kInvalidTarget = 33;
inline constexpr int kArcRadius = 34;
inline constexpr int kArcOffsets = 35;
inline constexpr int kUnusedWords = 36;
inline constexpr int kToolLengthAxis = 37;
inline constexpr int kNoSuchTool = 38;

/// The motion modes of G-code's group 1; a probe's are 382 to 385.
inline constexpr int kRapid = 0, kLinear = 1, kClockwise = 2, kCounterClockwise = 3;
inline constexpr int kNoMotion = 80;

/// A line as grbl's serial reader leaves it: without white space and comments, in
/// capitals.
std::string Stripped(std::string_view line);

/// The number at `*at`, which moves behind it: digits with at most one dot, no
/// exponent. nullopt: none stands there.
std::optional<double> ReadNumber(std::string_view text, std::size_t* at);

/// What stays in force from line to line.
struct Modal {
  int motion = kRapid;
  int plane = 17;
  bool is_inches = false;
  bool is_relative = false;
  bool is_inverse_time = false;  ///< G93: F is one over the move's minutes.
  int workplace = 0;             ///< 0: G54.
  int spindle = 5;               ///< M3, M4 or M5.
  bool has_flood = false;
  int tool = 0;
  double feed_mm_s = 0;  ///< Under G93 in moves a second.
  double spindle_rpm = 0;
};

/// A line of G-code, its words told apart; not yet what they mean.
struct Block {
  Modal modal{};       ///< As it was, with what this line sets.
  int non_modal = -1;  ///< 4 10 28 30 53 92; 281, 301, 921 for 28.1 ...; -1: none.
  int program = -1;    ///< M0 M1 M2 M30; -1: none.
  /// The command that takes the axis words: none, of this line alone, a motion, G43.1.
  enum class AxisCommand { kNone, kNonModal, kMotion, kToolLength };
  AxisCommand axis_command = AxisCommand::kNone;
  bool cancels_tool_length = false;  ///< G49.
  /// Commands beside G20 G21 G53 G90 G91, which are all that a jog may have.
  bool has_more_than_jog = false;
  bool sets_feed_mode = false;                     ///< G93 or G94 stands in it.
  std::array<std::optional<double>, 26> values{};  ///< Of words that are no G and M.

  std::optional<double> Value(char letter) const { return values[Place(letter)]; }
  /// The value, which counts as used from then on.
  std::optional<double> Take(char letter);
  /// Whether any is not used yet.
  bool HasValues() const;
  bool has_axis_words() const { return Value('X') || Value('Y') || Value('Z'); }

  static std::size_t Place(char letter) {
    return static_cast<std::size_t>(letter - 'A');
  }
};

/// Reads the words of a stripped line. Throws LineError.
Block ReadBlock(std::string_view stripped, const Modal& modal);

}  // namespace caltwin::grbl
