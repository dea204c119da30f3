#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

constexpr std::size_t kTowers = 3;

/// Corrections of the rods and the rods themselves, by tower.
struct Rods {
  std::vector<double> trims_mm{};
  double length_mm = kUnknown;  ///< As set.
  std::array<std::vector<double>, kTowers> measured_mm{};
};

// "#define DELTA_DIAGONAL_ROD_TRIM_TOWER { 1.2, 0, -0.4 }", or one a tower.
void TakeTrims(const std::string& lower, Rods* rods) {
  const std::size_t at = lower.find("rod_trim");
  if (at == std::string::npos) return;
  const std::size_t value = lower.find_first_of(" ={", at);
  if (value == std::string::npos) return;
  // "// found by 3 trials": a remark.
  const std::vector<double> numbers = NumbersApart(
      std::string_view(lower).substr(value, lower.find("//", value) - value));
  if (numbers.size() == kTowers) rods->trims_mm = numbers;
  if (numbers.size() == 1) rods->trims_mm.push_back(numbers[0]);
}

// "tower A  180.3 180.4", "rod b: 180.2", "arm 3 = 180.1"
void TakeRods(const TextLine& line, const std::string& lower, Rods* rods) {
  if (line.words.size() < 3) return;
  const std::string first = Lowered(line.words[0].text);
  const bool is_named = first == "tower" || first == "rod" || first == "rods" ||
                        first == "arm" || first == "arms";
  const char letter = Lowered(line.words[1].text)[0];
  const std::size_t tower = letter >= 'a' ? static_cast<std::size_t>(letter - 'a')
                                          : static_cast<std::size_t>(letter - '1');
  if (!is_named || tower >= kTowers || line.words[1].text.size() > 2) return;
  const std::size_t from = lower.find(Lowered(line.words[1].text), first.size());
  if (from == std::string::npos) return;
  for (const double mm :
       NumbersApart(std::string_view(lower).substr(from + line.words[1].text.size()))) {
    rods->measured_mm[tower].push_back(mm);
  }
}

Rods RodsIn(const std::string& text) {
  Rods rods;
  for (const TextLine& line : LinesOf(text)) {
    const ConsoleLine said = ConsoleLineOf(line.text);
    if (IsCommand(said, "m665")) {
      rods.length_mm = WordOf(said, 'l').value_or(rods.length_mm);
      const std::array trims = {
          WordOf(said, 'a'), WordOf(said, 'b'), WordOf(said, 'c')};
      if (trims[0] && trims[1] && trims[2])
        rods.trims_mm = {*trims[0], *trims[1], *trims[2]};
    }
    const std::string lower = Lowered(line.text);
    if (lower.find("rod_length") != std::string::npos) {
      const std::vector<double> numbers = NumbersApart(lower);
      if (!numbers.empty()) rods.length_mm = numbers[0];
    }
    TakeTrims(lower, &rods);
    TakeRods(line, lower, &rods);
  }
  return rods;
}

// Lengths of rods: near to what is set, where that is known.
bool AreRods(const Rods& rods) {
  constexpr double kNear = 0.1;
  return std::ranges::all_of(rods.measured_mm, [&](const auto& tower) {
    return !tower.empty() && std::ranges::all_of(tower, [&](double mm) {
      return !Known(rods.length_mm) || std::abs(mm / rods.length_mm - 1) < kNear;
    });
  });
}

}  // namespace

std::optional<Imported> RodTrimsIn(const std::string& text) {
  constexpr double kLeast_mm = 0.5, kTimes = 3;
  const Rods rods = RodsIn(text);
  if (rods.trims_mm.size() != kTowers || !AreRods(rods)) return std::nullopt;
  std::vector<double> all_mm;
  for (const auto& tower : rods.measured_mm)
    all_mm.insert(all_mm.end(), tower.begin(), tower.end());
  const auto [least_mm, most_mm] = std::ranges::minmax(all_mm);
  const auto [low_mm, high_mm] = std::ranges::minmax(rods.trims_mm);
  const double apart_mm = most_mm - least_mm, trims_mm = high_mm - low_mm;
  if (trims_mm < kLeast_mm || trims_mm < kTimes * apart_mm) return std::nullopt;
  Imported imported =
      ToldOf("corrections of a delta's rods, and the rods as measured",
             "what the corrections of the rods stand in for: widths of one object "
             "do not tell",
             "probe",
             "touch the bed at many points and let a calibration free the "
             "towers' angles and radii with the rods as measured; then print "
             "and measure distances in every direction");
  imported.notes.push_back(
      {.kind = FileNote::Kind::kFact,
       .sentence = fmt::format(
           "The corrections of the rods are no lengths of rods: they differ by {:.1f} "
           "mm "
           "({:+.1f}, {:+.1f}, {:+.1f}), the rods as measured by {:.1f} mm ({:g} to "
           "{:g}). Towers that stand at other angles or "
           "distances, a tilted effector or a wrong common length can look the same. "
           "Keep the measured rods and take the corrections out",
           trims_mm,
           rods.trims_mm[0],
           rods.trims_mm[1],
           rods.trims_mm[2],
           apart_mm,
           least_mm,
           most_mm),
       .fact = "contradiction",
       .word = "rods",
       .figures = {{"trims_um", UmFromMm(trims_mm)}, {"rods_um", UmFromMm(apart_mm)}}});
  return imported;
}

}  // namespace caltwin
