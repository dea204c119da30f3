#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace caltwin {

/// The only place where mm/min, the unit of G-code's F, meets mm/s, ours.
double FeedFromWord_mm_s(double f_mm_min);
double FeedWord_mm_min(double feed_mm_s);

/// One word of a command: a letter and what stands behind it.
struct GcodeWord {
  enum class Kind {
    kBare,       ///< Nothing: the X of "G28 X".
    kNumber,     ///< X12.5
    kNumbers,    ///< Z0:1:2
    kQuoted,     ///< P"sys/homeall.g"; a doubled quote means one.
    kExpression  ///< X{move.axes[0].max - 5}, kept as text without the braces.
  };
  char letter = 0;  ///< Capital.
  Kind kind = Kind::kBare;
  double number = 0;           ///< The first, where there are several.
  std::string text{};          ///< Of a quoted string or an expression.
  std::vector<double> more{};  ///< Behind colons.
};

/// One command with its words, such as G38.2 X10 F60.
struct GcodeCommand {
  char letter = 0;  ///< 'G', 'M' or 'T'; 0: words alone, for the modal G0 or G1.
  int code = -1;
  int minor = 0;  ///< The 2 of G38.2.
  std::vector<GcodeWord> words{};
  std::string rest{};  ///< Of M117 and M118: everything behind the code as written.

  const GcodeWord* Find(char letter) const;
  /// The number behind that letter; nullopt where there is none.
  std::optional<double> Number(char letter) const;
  bool Is(char of, int number, int fraction = 0) const {
    return letter == of && code == number && minor == fraction;
  }
  /// "G38.2", as messages name it.
  std::string Name() const;
};

/// A line taken apart.
struct GcodeLine {
  int indent = 0;               ///< Columns of white space before it; a tab counts one.
  std::optional<int> number{};  ///< N...
  std::string text{};           ///< Without number, checksum and comment.
  std::vector<GcodeCommand> commands{};  ///< Empty for a blank or a meta command line.
  bool is_meta = false;  ///< if, set, echo ...: `text` is to be read as such.
};

/// Parses a line of G-code as RepRapFirmware does in CNC mode: comments `;` and `( )`,
/// line numbers, checksums `*nn` (XOR of the bytes before), quoted strings, `{ }`
/// expressions kept as text, several G or M commands on one line, capital or small
/// letters. Throws InputError, with the column, for anything else, and for a line
/// longer than 1000 bytes.
GcodeLine ParseGcode(std::string_view line);

/// A number as G-code wants it: a dot whatever the locale, never an exponent, at most
/// `decimals` places, no trailing zeros ("12.3", "-0.05", "0").
std::string GcodeNumber(double value, int decimals = 6);

/// "G38.2 X12.3 F60": a command with its axis words [mm] in the order given and, where
/// it is positive, the feed.
std::string GcodeMove(std::string_view command,
                      const std::vector<std::pair<char, double>>& words_mm,
                      double feed_mm_s = 0);

/// The XOR of all bytes, as behind the `*` of a numbered line.
int GcodeChecksum(std::string_view bytes);

}  // namespace caltwin
