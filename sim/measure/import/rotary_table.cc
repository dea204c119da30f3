#include "sim/measure/import/rotary_table.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/plain_table.h"
#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

constexpr double kTurn_deg = 360;

/// Angles told, and how far off [deg].
struct Angles {
  std::vector<double> told_deg{}, off_deg{};
};

bool HasToken(const std::string& heading, std::initializer_list<const char*> words) {
  const auto tokens = TokensOf(heading);
  return std::ranges::any_of(words, [&](const char* word) {
    return std::ranges::find(tokens, word) != tokens.end();
  });
}

Spreadsheet SheetIn(const std::string& text) {
  const std::string plain = WithoutMarkup(text);
  const std::string table = plain == text ? TableInText(text) : plain;
  return table.empty() ? Spreadsheet{}
                       : ReadSpreadsheet(table, "", PlaceCells::kAsTheyStand);
}

// Lines whose cells hold both; of the told column the cell may be turns.
Angles AnglesIn(const Spreadsheet& sheet) {
  std::size_t told = sheet.headings.size(), off = told;
  bool are_turns = false;
  for (std::size_t i = 0; i < sheet.headings.size(); ++i) {
    const std::string& heading = sheet.headings[i].text;
    const bool is_angle = HasToken(heading, {"deg", "degrees", "degree"}) ||
                          heading.find("°") != std::string::npos;
    const bool is_off = HasToken(heading, {"off", "error", "deviation", "dev", "lag"});
    const bool is_other = HasToken(
        heading, {"mm", "um", "in", "inch", "g", "kg", "n", "s", "ms", "v", "temp"});
    const bool is_axis =
        HasToken(heading, {"a", "b", "c"}) && !is_other &&
        (is_angle || TokensOf(heading).size() == 1 ||
         HasToken(heading,
                  {"dro", "axis", "told", "commanded", "position", "display"}));
    const bool is_turns = HasToken(heading, {"turns", "turn", "revs", "revolutions"});
    if (is_off && is_angle) {
      off = i;
    } else if (is_axis && (told == sheet.headings.size() || are_turns)) {
      told = i;
      are_turns = false;
    } else if (is_turns && told == sheet.headings.size()) {
      told = i;
      are_turns = true;
    }
  }
  Angles angles;
  if (told == sheet.headings.size() || off == sheet.headings.size()) return angles;
  for (const CsvRecord& record : sheet.records) {
    const auto at = NumberOf(record[told].text), by = NumberOf(record[off].text);
    if (!at || !by) continue;  // "cannot see any".
    angles.told_deg.push_back(are_turns ? *at * kTurn_deg : *at);
    angles.off_deg.push_back(*by);
  }
  return angles;
}

// "$103=53.333"; empty: it does not stand there.
std::string SettingIn(const std::string& text) {
  for (const TextLine& line : LinesOf(text)) {
    const ConsoleLine said = ConsoleLineOf(line.text);
    if (!GrblSetting(said, 103)) continue;
    const std::size_t equals = said.lower.find('=');
    if (equals == std::string::npos) continue;
    return said.lower.substr(
        equals + 1,
        said.lower.find_first_not_of(".0123456789", equals + 1) - equals - 1);
  }
  return "";
}

// Whether the last decimal of a setting could hide that fraction.
std::string OfRounding(const std::string& setting, double fraction) {
  const auto value = NumberOf(setting);
  const std::size_t dot = setting.find('.');
  if (!value || *value <= 0) return "";
  const double decimals =
      dot == std::string::npos ? 0 : static_cast<double>(setting.size() - dot - 1);
  const double hidden = 0.5 * std::pow(10.0, -decimals) / *value;
  const double right = *value / (1 + fraction);
  return fmt::format(
      ". $103={} would have to be {:.5f}{}",
      setting,
      right,
      std::abs(fraction) < 1.5 * hidden
          ? fmt::format(", and its {:.0f} decimals leave up to {:.1f} ppm open: it is "
                        "the rounding of the setting. Choose gears or microsteps of "
                        "which the steps per degree come out even, or set A anew every "
                        "few hundred turns",
                        decimals,
                        PpmFromFraction(hidden))
          : "");
}

}  // namespace

std::optional<FileNote> NoteOfRotaryTable(const std::string& text) {
  constexpr std::size_t kFewest = 4;
  constexpr double kSure = 10, kLeastTurns = 2;
  Angles angles;
  try {
    angles = AnglesIn(SheetIn(text));
  } catch (const InputError&) {
    return std::nullopt;  // No table: another reader says so.
  }
  const auto num = static_cast<double>(angles.told_deg.size());
  if (angles.told_deg.size() < kFewest) return std::nullopt;
  double told2 = 0, both = 0, left2 = 0;
  for (std::size_t i = 0; i < angles.told_deg.size(); ++i) {
    told2 += angles.told_deg[i] * angles.told_deg[i];
    both += angles.told_deg[i] * angles.off_deg[i];
  }
  const double most_deg = std::abs(
      std::ranges::max(angles.told_deg, {}, [](double deg) { return std::abs(deg); }));
  if (most_deg < kLeastTurns * kTurn_deg) return std::nullopt;
  // With a constant beside it, which must be small against what grows.
  constexpr double kMostConstant = 0.3;
  double mean_told = 0, mean_off = 0, about2 = 0, about = 0;
  for (std::size_t i = 0; i < angles.told_deg.size(); ++i) {
    mean_told += angles.told_deg[i] / num;
    mean_off += angles.off_deg[i] / num;
  }
  for (std::size_t i = 0; i < angles.told_deg.size(); ++i) {
    about2 += std::pow(angles.told_deg[i] - mean_told, 2);
    about += (angles.told_deg[i] - mean_told) * (angles.off_deg[i] - mean_off);
  }
  if (about2 <= 0) return std::nullopt;
  const double slope = about / about2, constant_deg = mean_off - slope * mean_told;
  const double fraction = both / told2;
  for (std::size_t i = 0; i < angles.told_deg.size(); ++i) {
    left2 += std::pow(angles.off_deg[i] - fraction * angles.told_deg[i], 2);
  }
  const double left_deg = std::sqrt(left2 / (num - 1));
  const double sd = left_deg / std::sqrt(told2);
  const bool grows =
      std::abs(constant_deg) < kMostConstant * std::abs(slope) * most_deg;
  if (!grows || std::abs(slope) < kSure * left_deg / std::sqrt(about2)) {
    return std::nullopt;
  }
  return FileNote{
      .kind = FileNote::Kind::kElsewhere,
      .what = "settings",
      .sentence = fmt::format(
          "The rotary axis is off by {} degrees a turn, in proportion to the turns ({} "
          "of what it is told), to {} degrees about that line: a ratio that is not "
          "quite right, and no lost steps, no slipping belt and no play, which would "
          "not grow so evenly{}",
          WithSd(fraction * kTurn_deg, sd * kTurn_deg, ""),
          WithSd(PpmFromFraction(fraction), PpmFromFraction(sd), "ppm"),
          TwoDigits(left_deg),
          OfRounding(SettingIn(text), fraction)),
      .fact = "scale",
      .axis = "a",
      .figures = {{"factor", 1 + fraction, sd},
                  {"deg_per_turn", fraction * kTurn_deg, sd * kTurn_deg}}};
}

Imported ReadRotaryTable(const std::string& text,
                         const std::string& name,
                         const ImportOptions& /*options*/) {
  const auto note = NoteOfRotaryTable(text);
  if (!note) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no table of a rotary axis whose errors grow stands here",
                     "columns: 'A' or 'turns', and 'off (deg)'");
  }
  return {.recognised = {"a table of a rotary axis: angles told, and how far off"},
          .assumed = {"angles are in degrees; the column of the axis (or its turns) is "
                      "what was told"},
          .notes = {*note}};
}

}  // namespace caltwin
