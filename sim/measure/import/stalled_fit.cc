#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// What a fit printed of itself.
struct Fit {
  std::vector<double> errors_mm{};
  std::size_t num_free = 0;  ///< 0: not said.
  double num_touches = kUnknown;
  std::map<char, double> first{}, last{};  ///< By the parameter's letter.
};

// "A:4.3 B:5.04 ...", four letters at least.
std::map<char, double> LettersIn(const std::string& lower) {
  constexpr std::size_t kFewest = 4;
  std::map<char, double> letters;
  for (const TextLine& line : LinesOf(lower)) {
    for (const CsvField& word : line.words) {
      const bool is_one = word.text.size() > 2 && word.text[1] == ':' &&
                          std::isalpha(static_cast<unsigned char>(word.text[0])) != 0;
      const auto value = is_one ? NumberOf(word.text.substr(2)) : std::nullopt;
      if (!value) return {};
      letters[word.text[0]] = *value;
    }
  }
  return letters.size() >= kFewest ? letters : std::map<char, double>{};
}

Fit FitIn(const std::string& text) {
  constexpr std::string_view kParameters = "of parameters: ";
  Fit fit;
  for (const TextLine& line : LinesOf(text)) {
    const ConsoleLine said = ConsoleLineOf(line.text);
    const std::size_t error = said.lower.find("rms error");
    const std::size_t free = said.lower.find(kParameters);
    if (error != std::string::npos) {
      const auto value_mm = NumberAfter(said.lower.substr(error), ":");
      if (value_mm) fit.errors_mm.push_back(*value_mm);
    } else if (free != std::string::npos) {
      const std::string names = said.lower.substr(free + kParameters.size());
      fit.num_free = static_cast<std::size_t>(std::ranges::count_if(
          names, [](unsigned char c) { return std::isalpha(c) != 0; }));
    } else if (const auto touches = NumberAfter(said.lower, "probing ")) {
      fit.num_touches = *touches;
    } else if (auto letters = LettersIn(said.lower); !letters.empty()) {
      if (fit.first.empty()) fit.first = letters;
      fit.last = std::move(letters);
    }
  }
  return fit;
}

// Of three towers: all went the same way, by about as much.
std::string Together(const Fit& fit, const std::string& letters) {
  constexpr double kAlike = 0.35, kLeast_mm = 0.5;
  std::vector<double> changes;
  for (const char letter : letters) {
    if (!fit.first.contains(letter) || !fit.last.contains(letter)) return "";
    changes.push_back(fit.last.at(letter) - fit.first.at(letter));
  }
  double mean = 0;
  for (const double change : changes)
    mean += change / static_cast<double>(changes.size());
  const bool are_alike = std::ranges::all_of(changes, [&](double change) {
    return std::abs(change - mean) < kAlike * std::abs(mean);
  });
  if (!are_alike || std::abs(mean) < kLeast_mm) return "";
  const auto capital = [&](std::size_t k) {
    return static_cast<char>(std::toupper(static_cast<unsigned char>(letters[k])));
  };
  return fmt::format("{}, {} and {} went {} together ({:+.2f}). ",
                     capital(0),
                     capital(1),
                     capital(2),
                     mean > 0 ? "up" : "down",
                     fmt::join(changes, ", "));
}

}  // namespace

std::optional<Imported> StalledFitIn(const std::string& text) {
  constexpr std::size_t kFewest = 3;
  constexpr double kProbe_mm = 0.1, kStands = 0.2;
  const Fit fit = FitIn(text);
  if (fit.errors_mm.size() < kFewest) return std::nullopt;
  const double left_mm = fit.errors_mm.back();
  const double before_mm = fit.errors_mm[fit.errors_mm.size() - 2];
  const double step = 1 - left_mm / before_mm;
  if (left_mm < kProbe_mm || step > kStands) return std::nullopt;
  const std::string together = Together(fit, "abc") + Together(fit, "xyz");
  const std::string model =
      fit.num_free > 0 ? fmt::format("with {} free values", fit.num_free) : "as it is";
  const std::string touches = Known(fit.num_touches)
                                  ? fmt::format("the {:.0f} touches", fit.num_touches)
                                  : std::string("the touches");
  Imported imported =
      ToldOf(fmt::format("a firmware's own fit, {} rounds", fit.errors_mm.size() - 1),
             "which of the fitted values is the machine's, and why the touches do "
             "not fit any of them",
             "calliper",
             "print an object with distances in three directions "
             "and measure them with a calliper: touches of a bed "
             "alone do not tell the values apart");
  imported.notes.push_back(
      {.kind = FileNote::Kind::kFact,
       .sentence = fmt::format(
           "The fit stalls: its error goes {:.3g} mm and "
           "stays there (the last round took {:.0f} %), far more than a probe "
           "scatters, "
           "so the model {} does not explain {}. {}{}Do not set them, and go back to "
           "the values before if they printed better. Free fewer (end stops and radius "
           "first), touch each place several times to see how the probe repeats, and "
           "add lengths measured on a print",
           fmt::join(fit.errors_mm, ", "),
           100 * step,
           model,
           touches,
           together,
           together.empty()
               ? ""
               : "What such have in common can stand in for the radius or the height, "
                 "so no value by itself means anything. "),
       .fact = "contradiction",
       .axis = "z",
       .word = "fit",
       .figures = {{"left_um", UmFromMm(left_mm)}}});
  return imported;
}

}  // namespace caltwin
