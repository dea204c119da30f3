#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// A line of a table: its words, and what was told and read.
struct Length {
  std::string name{};
  double told_mm = 0, read_mm = 0;
};

/// Mean and standard deviation.
struct Mean {
  double mean = 0, sd = 0;
};

std::optional<Length> LengthIn(const TextLine& line) {
  constexpr std::string_view kBetween = "|,;\t";
  std::string plain = Lowered(line.text);
  std::ranges::replace_if(
      plain, [&](char c) { return kBetween.find(c) != std::string_view::npos; }, ' ');
  std::vector<std::string> words;
  for (const TextLine& part : LinesOf(plain)) {
    for (const CsvField& word : part.words) words.push_back(word.text);
  }
  if (words.size() < 3) return std::nullopt;
  const auto told_mm = NumberOf(words[words.size() - 2]);
  const auto read_mm = NumberOf(words.back());
  if (!told_mm || !read_mm || *told_mm <= 0 || *read_mm <= 0) return std::nullopt;
  Length length{.told_mm = *told_mm, .read_mm = *read_mm};
  for (std::size_t i = 0; i + 2 < words.size(); ++i) length.name += words[i] + " ";
  return length;
}

bool Has(const Length& length, std::initializer_list<const char*> words) {
  return std::ranges::any_of(words, [&](const char* word) {
    return length.name.find(word) != std::string::npos;
  });
}

bool IsWidth(const Length& length) {
  return Has(length, {"width", "thickness", "wide "}) &&
         !Has(length, {"distance", "overall"});
}

// Over both faces of two parts: +1; between their near faces: -1; else 0.
int SenseOf(const Length& length) {
  if (!Has(length, {"distance", "spacing"})) return 0;
  if (Has(length, {"outside", "outer", "over "})) return 1;
  return Has(length, {"inside", "inner", "between", "gap"}) ? -1 : 0;
}

Mean MeanOf(const std::vector<double>& values) {
  const auto num = static_cast<double>(values.size());
  Mean mean;
  for (const double value : values) mean.mean += value / num;
  for (const double value : values) mean.sd += std::pow(value - mean.mean, 2);
  mean.sd = std::sqrt(mean.sd / std::max(1.0, num - 1));
  return mean;
}

/// What is wide and how far apart it stands, in one object.
struct Object {
  std::vector<Length> widths{}, distances{};
};

Object ObjectIn(const std::string& text) {
  Object object;
  for (const TextLine& line : LinesOf(text)) {
    const auto length = LengthIn(line);
    if (!length) continue;
    if (IsWidth(*length)) object.widths.push_back(*length);
    if (SenseOf(*length) != 0) object.distances.push_back(*length);
  }
  const auto is_as_wide = [&](const Length& width) {
    return width.told_mm == object.widths[0].told_mm;
  };
  // Of parts of several widths nobody says which one a distance is over.
  if (!std::ranges::all_of(object.widths, is_as_wide)) object.widths.clear();
  return object;
}

FileNote NoteOf(double wide_mm, const Mean& factor, double sd, std::size_t num) {
  const std::string moved = fmt::format(
      "With one width taken off, the {} distances are {:.4f} +- {:.4f} times as long "
      "as "
      "designed",
      num,
      factor.mean,
      sd);
  FileNote note{.fact = "scale",
                .axis = "x",
                .word = "distances",
                .figures = {{"factor", factor.mean, sd}}};
  constexpr double kRight = 0.003;
  const bool is_right = std::abs(factor.mean - 1) < std::max(kRight, 2 * sd);
  if (is_right) {
    note.kind = FileNote::Kind::kElsewhere;
    note.what = "slicer";
    note.sentence =
        moved +
        fmt::format(
            ": the machine moves right. What is off is the width of what is laid down, "
            "{:+.2f} mm over both faces together: extrusion or line width. Put it "
            "right in "
            "the slicer; do not turn at steps/mm, rods or towers for it",
            wide_mm);
  } else {
    note.kind = FileNote::Kind::kFact;
    note.sentence =
        moved +
        fmt::format(
            ", and the parts are {:+.2f} mm wide of the mark besides: two things are "
            "off. "
            "The distances are the machine's, or the material's shrinkage; the width "
            "is the "
            "line's, for the slicer. A move measured on the head parts machine and "
            "material",
            wide_mm);
  }
  return note;
}

}  // namespace

std::optional<Imported> WidthsAndDistancesIn(const std::string& text) {
  constexpr double kLeast_mm = 0.1;
  const Object object = ObjectIn(text);
  if (object.widths.size() < 2 || object.distances.size() < 2) return std::nullopt;
  std::vector<double> over_mm, factors;
  for (const Length& width : object.widths)
    over_mm.push_back(width.read_mm - width.told_mm);
  const Mean wide = MeanOf(over_mm);
  if (std::abs(wide.mean) < kLeast_mm) return std::nullopt;
  const double told_width_mm = object.widths[0].told_mm;
  double shortest_mm = object.distances[0].told_mm;
  for (const Length& length : object.distances) {
    const int sense = SenseOf(length);
    const double told_mm = length.told_mm - sense * told_width_mm;
    if (told_mm <= 0) return std::nullopt;
    shortest_mm = std::min(shortest_mm, told_mm);
    factors.push_back((length.read_mm - sense * (told_width_mm + wide.mean)) / told_mm);
  }
  const Mean factor = MeanOf(factors);
  const double sd = std::hypot(
      factor.sd / std::sqrt(static_cast<double>(factors.size())),
      wide.sd / std::sqrt(static_cast<double>(over_mm.size())) / shortest_mm);
  Imported imported{
      .recognised = {fmt::format("{} widths of an object and {} distances over them",
                                 over_mm.size(),
                                 factors.size())}};
  imported.notes.push_back(NoteOf(wide.mean, factor, sd, factors.size()));
  return imported;
}

}  // namespace caltwin
