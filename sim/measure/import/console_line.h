#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim/measure/row.h"

namespace caltwin {

/// A line of a console without what host, terminal or chat wrote before it: `Recv:`,
/// `>>>`, `//`, `echo:`, times of day and dates in the forms of OctoPrint, Pronterface,
/// Mainsail, Fluidd and Duet Web Control, bullets, line numbers and checksums of
/// G-code.
struct ConsoleLine {
  std::string_view text{};
  std::string lower{};    ///< The same in small letters.
  double t_s = kUnknown;  ///< From any fixed zero; kUnknown: none stood there.
};
ConsoleLine ConsoleLineOf(std::string_view line);

/// Whether the line gives that command of G-code or of Klipper: the word, then a blank,
/// a checksum or nothing. `word` in small letters.
bool IsCommand(const ConsoleLine& line, std::string_view word);

/// The number behind a letter of G-code ("x" in "g30 p0 x20 y-3"); nullopt where none
/// stands there. `letter` small.
std::optional<double> WordOf(const ConsoleLine& line, char letter);

/// grbl's setting of that number, as it lists it ("$100=640.000 (x, step/mm)") or as
/// people copy it ("$100    640"); nullopt: the line is none of that.
std::optional<double> GrblSetting(const ConsoleLine& line, int number);

}  // namespace caltwin
