#include "sim/firmware/kinds/motor_stage/code_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include <fmt/format.h>

#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {
namespace {

/// What stands behind the letter of an axis.
enum class AxisWord { kNone, kNumber, kName, kNumberOrName };

struct CodeWords {
  char letter = 'M';
  int code = 0;
  AxisWord axes = AxisWord::kNone;
  std::string_view numbers{};  ///< Letters of words that carry a number.
};

constexpr std::array kCodes = {
    CodeWords{'G', 0, AxisWord::kNumber, "FH"},
    CodeWords{'G', 1, AxisWord::kNumber, "FH"},
    CodeWords{'G', 4, AxisWord::kNone, "S"},
    CodeWords{'G', 90},
    CodeWords{'G', 91},
    CodeWords{'M', 17, AxisWord::kName},
    CodeWords{'M', 18, AxisWord::kName},
    CodeWords{'M', 84, AxisWord::kName},
    CodeWords{'M', 92, AxisWord::kNumberOrName},
    CodeWords{'M', 112},
    CodeWords{'M', 114},
    CodeWords{'M', 119},
    CodeWords{'M', 201, AxisWord::kNumberOrName},
    CodeWords{'M', 203, AxisWord::kNumberOrName},
    CodeWords{'M', 206, AxisWord::kNumberOrName},
    CodeWords{'M', 208, AxisWord::kNumberOrName, "S"},
    CodeWords{'M', 400},
    CodeWords{'M', 425, AxisWord::kNumberOrName},
    CodeWords{'M', 500, AxisWord::kName},
    CodeWords{'M', 501},
    CodeWords{'M', 502, AxisWord::kName},
    CodeWords{'M', 504},
    CodeWords{'M', 505, AxisWord::kName},  // And P"text", which it asks for itself.
    CodeWords{'M', 810, AxisWord::kName},
    CodeWords{'M', 811, AxisWord::kNumber},
    CodeWords{'M', 812, AxisWord::kNumberOrName},
    CodeWords{'M', 813, AxisWord::kNumberOrName},
    CodeWords{'M', 814, AxisWord::kName},
    CodeWords{'M', 815, AxisWord::kName},
    CodeWords{'M', 816, AxisWord::kNumberOrName},
    CodeWords{'M', 817, AxisWord::kNone, "S"},
    CodeWords{'M', 818},
    CodeWords{'M', 999},
};

bool IsAxis(char letter) {
  return kMotorAxisLetters.find(static_cast<char>(std::tolower(letter))) !=
         std::string_view::npos;
}

std::string FaultOf(const GcodeWord& word, const CodeWords& code) {
  const bool is_axis = IsAxis(word.letter) && code.axes != AxisWord::kNone;
  const bool is_number = code.numbers.find(word.letter) != std::string_view::npos;
  const bool is_text = code.code == 505 && word.letter == 'P';
  if (is_text) return "";
  if (!is_axis && !is_number) {
    return fmt::format("{} is no word of it; a number is written like 12.5",
                       word.letter);
  }
  const bool wants_number = is_number || code.axes == AxisWord::kNumber;
  const bool takes_number = wants_number || code.axes == AxisWord::kNumberOrName;
  if (word.kind == GcodeWord::Kind::kNumber && takes_number) return "";
  if (word.kind == GcodeWord::Kind::kBare && !wants_number) return "";
  return fmt::format(
      "{} wants {}",
      word.letter,
      !takes_number ? "nothing behind it" : "a number behind it, like 12.5");
}

}  // namespace

std::string MotorWordFault(const GcodeCommand& command) {
  const auto* code = std::ranges::find_if(kCodes, [&](const CodeWords& each) {
    return command.Is(each.letter, each.code);
  });
  if (code == kCodes.end()) return "";
  for (const GcodeWord& word : command.words) {
    if (auto fault = FaultOf(word, *code); !fault.empty()) return fault;
    const auto times =
        std::ranges::count(command.words, word.letter, &GcodeWord::letter);
    if (times > 1) return fmt::format("{} stands {} times", word.letter, times);
  }
  return "";
}

}  // namespace caltwin
