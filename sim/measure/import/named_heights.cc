#include "sim/measure/import/named_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

/// A name, a height, and where they stand.
struct Named {
  std::string name{};
  double height_mm = 0;
  int line = 0;
};

/// Names of a run of lines that follow each other, and the line before them.
struct Run {
  std::string title{};
  std::vector<Named> all{};
};

// "c: 0.0016", "FrontR 0.065", "back left = 0.35": a name and one number.
std::optional<Named> NamedIn(const TextLine& line) {
  constexpr std::size_t kMostWords = 4;
  if (line.words.size() < 2 || line.words.size() > kMostWords) return std::nullopt;
  std::string number = line.words.back().text;
  if (number.starts_with('+')) number.erase(0, 1);
  const auto height_mm = NumberOf(number);
  if (!height_mm) return std::nullopt;
  std::string name(line.text.substr(0, line.text.rfind(line.words.back().text)));
  while (!name.empty() && std::string_view(" \t:=").find(name.back()) != name.npos) {
    name.pop_back();
  }
  return Named{Lowered(name), *height_mm, line.line};
}

std::vector<Run> RunsOf(const std::string& text) {
  std::vector<Run> runs;
  std::string title;
  bool is_on = false;
  for (const TextLine& line : LinesOf(text)) {
    const auto named = NamedIn(line);
    if (!named) {
      title = line.text;
      is_on = false;
      continue;
    }
    if (!is_on) runs.push_back({.title = title});
    is_on = true;
    runs.back().all.push_back(*named);
  }
  return runs;
}

// "c", "x", "ox" of a delta; Marlin's "yz" lies across from x. Empty: none of them.
std::string OfDelta(const std::string& name) {
  constexpr std::array kSame = {std::pair{"yz", "ox"},
                                std::pair{"zx", "oy"},
                                std::pair{"xz", "oy"},
                                std::pair{"xy", "oz"}};
  for (const auto& [marlin, own] : kSame) {
    if (name == marlin) return own;
  }
  for (const char* known : {"c", "x", "y", "z", "ox", "oy", "oz"}) {
    if (name == known) return known;
  }
  return "";
}

bool IsDelta(const Run& run) {
  std::set<std::string> names;
  for (const Named& one : run.all) names.insert(OfDelta(one.name));
  constexpr std::size_t kAll = 7;
  return run.all.size() == kAll && names.size() == kAll && !names.contains("");
}

// "front_left" of "FrontL", "Front left", "FL"; empty: no corner.
std::string CornerOf(const std::string& name) {
  std::string end, side;
  for (std::string token : TokensOf(name)) {
    for (const std::string_view word : {"front", "back", "rear"}) {
      // "frontr": both in one word.
      if (!token.starts_with(word)) continue;
      end = word == "front" ? "front" : "back";
      token.erase(0, word.size());
    }
    if (token == "l" || token == "left") side = "left";
    if (token == "r" || token == "right") side = "right";
    if (token == "fl" || token == "lf") return "front_left";
    if (token == "fr" || token == "rf") return "front_right";
    if (token == "bl" || token == "lb") return "back_left";
    if (token == "br" || token == "rb") return "back_right";
  }
  return end.empty() || side.empty() ? "" : end + "_" + side;
}

bool AreCorners(const Run& run) {
  constexpr std::size_t kFewest = 3, kMost = 4;
  std::set<std::string> corners;
  for (const Named& one : run.all) corners.insert(CornerOf(one.name));
  return !corners.contains("") && corners.size() == run.all.size() &&
         corners.size() >= kFewest && corners.size() <= kMost;
}

// Towers at 210, 330 and 90 degrees.
std::array<double, 2> PlaceOnDelta(const std::string& name) {
  if (name == "c") return {0, 0};
  const double tower_deg = name.back() == 'x' ? 210 : name.back() == 'y' ? 330 : 90;
  const double angle =
      (tower_deg + (name.size() == 2 ? 180 : 0)) * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle)};
}

// Heights of a bed, by what the line above says and how large they are; temperatures,
// weights and inches are none.
bool AreHeights(const Run& run) {
  constexpr double kMost_mm = 20;
  constexpr std::array<std::string_view, 14> kOthers = {"temp",
                                                        "temperature",
                                                        "temperatures",
                                                        "c",
                                                        "degrees",
                                                        "kg",
                                                        "g",
                                                        "weight",
                                                        "inch",
                                                        "inches",
                                                        "thou",
                                                        "thousandths",
                                                        "mil",
                                                        "mils"};
  const std::vector<std::string> tokens = TokensOf(run.title);
  return std::ranges::all_of(
             run.all,
             [](const Named& one) { return std::abs(one.height_mm) < kMost_mm; }) &&
         std::ranges::none_of(kOthers, [&](std::string_view other) {
           return std::ranges::find(tokens, other) != tokens.end();
         });
}

bool IsNamed(const Run& run) {
  return AreHeights(run) && (IsDelta(run) || AreCorners(run));
}

}  // namespace

// They are what the file is about: most of its lines of figures.
bool HasNamedHeights(const std::string& text) {
  std::size_t num_named = 0, num_lines = 0;
  for (const Run& run : RunsOf(text)) num_named += IsNamed(run) ? run.all.size() : 0;
  for (const TextLine& line : LinesOf(text)) {
    const char last = line.text.back();
    num_lines += last >= '0' && last <= '9' ? 1 : 0;
  }
  return num_named > 0 && 2 * num_named > num_lines;
}

Imported ReadNamedHeights(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options) {
  Imported imported;
  std::size_t num_runs = 0;
  for (const Run& run : RunsOf(text)) {
    if (!IsNamed(run)) continue;
    const bool is_delta = IsDelta(run);
    const std::string campaign = options.campaign.empty()
                                     ? CampaignNamed(run.title, ++num_runs)
                                     : options.campaign;
    for (const Named& one : run.all) {
      const std::string known = is_delta ? OfDelta(one.name) : CornerOf(one.name);
      const std::array<double, 2> at =
          is_delta ? PlaceOnDelta(known)
                   : std::array{known.ends_with("right") ? 1.0 : 0.0,
                                known.starts_with("back") ? 1.0 : 0.0};
      Row row = BedTouchRow(campaign,
                            at[0],
                            at[1],
                            one.height_mm,
                            {.file = name, .line = one.line, .column = 1});
      row.feature = (is_delta ? "delta." : "corner.") + known;
      imported.table.rows.push_back(std::move(row));
    }
  }
  if (imported.table.rows.empty()) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no heights with names of places stand here",
                     "c, x, y, z, ox, oy, oz of a delta, or front left ... of a bed");
  }
  imported.recognised = {fmt::format("heights of places that have names: {} readings",
                                     imported.table.rows.size())};
  imported.assumed = {"+ is up, lengths are in mm: nothing says otherwise"};
  imported.has_places = false;
  imported.has_unit = true;
  return imported;
}

}  // namespace caltwin
