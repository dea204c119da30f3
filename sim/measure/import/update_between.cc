#include "sim/measure/import/update_between.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

using Map = std::map<std::pair<double, double>, double>;

/// A map less another at the places that both have.
struct Shift {
  double mean_mm = 0, sd_mm = 0, least_mm = 0, most_mm = 0;
  std::size_t num = 0;
};

Shift ShiftBetween(const Map& one, const Map& other) {
  std::vector<double> apart_mm;
  for (const auto& [place, height_mm] : one) {
    const auto same = other.find(place);
    if (same != other.end()) apart_mm.push_back(same->second - height_mm);
  }
  if (apart_mm.size() < 2) return {};
  const auto num = static_cast<double>(apart_mm.size());
  Shift shift{.num = apart_mm.size()};
  for (const double mm : apart_mm) shift.mean_mm += mm / num;
  double squares_mm2 = 0;
  for (const double mm : apart_mm) squares_mm2 += std::pow(mm - shift.mean_mm, 2);
  shift.sd_mm = std::sqrt(squares_mm2 / (num - 1));
  const auto [least, most] = std::ranges::minmax(apart_mm);
  shift.least_mm = least;
  shift.most_mm = most;
  return shift;
}

// In the order of the file.
std::vector<Map> MapsOf(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  std::vector<Map> maps;
  for (const Row& row : rows) {
    if (row.kind != RowKind::kTouch || !row.campaign.starts_with("mesh")) continue;
    const auto own = std::ranges::find(names, row.campaign);
    if (own == names.end()) maps.emplace_back();
    Map* map = own == names.end() ? &maps.back() : &maps[own - names.begin()];
    if (own == names.end()) names.push_back(row.campaign);
    (*map)[{row.cmd_mm[0], row.cmd_mm[1]}] = row.value_mm;
  }
  return maps;
}

}  // namespace

void UpdateBetween::Take(std::string_view line, int number) {
  constexpr std::array<std::string_view, 6> kWords = {
      "updat", "upgrad", "flash", "new firmware", "m502", "factory reset"};
  const std::string lower = Lowered(line);
  const bool says_it = std::ranges::any_of(kWords, [&](std::string_view word) {
    return lower.find(word) != std::string::npos;
  });
  if (says_it && line_ == 0) line_ = number;
}

void UpdateBetween::Tell(Imported* imported) const {
  constexpr std::size_t kFewest = 9;
  constexpr double kLeast_mm = 0.5, kSure = 8;
  const bool is_told = std::ranges::any_of(
      imported->notes, [](const FileNote& note) { return note.fact == "offset"; });
  const std::vector<Map> maps = MapsOf(imported->table.rows);
  if (line_ == 0 || maps.size() != 2 || is_told) return;
  const Shift shift = ShiftBetween(maps[0], maps[1]);
  if (shift.num < kFewest || std::abs(shift.mean_mm) < kLeast_mm ||
      std::abs(shift.mean_mm) < kSure * shift.sd_mm) {
    return;
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "The second mesh is the first moved by {:+.2f} mm ({:+.2f} to {:+.2f}, "
           "standard deviation {:.2f}): the same shape, another zero. No bed bends, "
           "tilts or warps like that, and no probe scatters so. Line {} tells of new "
           "firmware or reset settings: the probe's Z offset is another than before, "
           "or the firmware counts it once more or once less. Compare M851 and M206 of "
           "both, set the offset anew and probe again; do not level the bed for it",
           shift.mean_mm,
           shift.least_mm,
           shift.most_mm,
           shift.sd_mm,
           line_)});
}

}  // namespace caltwin
