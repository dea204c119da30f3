#include "calibration/facts/temperature.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

struct Thermometer {
  const char* id = nullptr;
  const char* words = nullptr;
  double Row::*member = nullptr;
};
constexpr std::array kSensors = {
    Thermometer{"frame", "the frame", &Row::temp_frame_c},
    Thermometer{"bed", "the bed", &Row::temp_bed_c},
    Thermometer{"chamber", "the chamber", &Row::temp_chamber_c},
    Thermometer{"nozzle", "the nozzle", &Row::temp_nozzle_c},
    Thermometer{"probe", "the probe or screw", &Row::temp_screw_c},
    Thermometer{"ambient", "the room", &Row::temp_ambient_c}};

/// A line of readings against one temperature.
struct Warmth {
  double slope_mm_per_k = 0, sd = 0, left_mm = 0, spread_mm = 0, range_k = 0;
  bool goes_both_ways = false;
};

bool Fit(const std::vector<const Row*>& rows,
         const Thermometer& sensor,
         Warmth* warmth) {
  constexpr double kLeastRange_k = 3;
  double n = 0, t = 0, z = 0, tt = 0, tz = 0, zz = 0;
  double least_c = HUGE_VAL, most_c = -HUGE_VAL, before_c = kUnknown;
  bool rises = false, falls = false;
  for (const Row* row : rows) {
    const double at_c = row->*sensor.member;
    if (!Known(at_c)) return false;
    n += 1;
    t += at_c;
    z += row->value_mm;
    tt += at_c * at_c;
    tz += at_c * row->value_mm;
    zz += row->value_mm * row->value_mm;
    least_c = std::min(least_c, at_c);
    most_c = std::max(most_c, at_c);
    rises |= at_c > before_c + 0.5;
    falls |= at_c < before_c - 0.5;
    before_c = at_c;
  }
  const double stt = tt - t * t / n, stz = tz - t * z / n, szz = zz - z * z / n;
  if (most_c - least_c < kLeastRange_k || stt <= 0 || szz <= 0) return false;
  warmth->slope_mm_per_k = stz / stt;
  const double left_mm2 = std::max(szz - stz * stz / stt, 0.0);
  warmth->left_mm = std::sqrt(left_mm2 / (n - 2));
  warmth->spread_mm = std::sqrt(szz / (n - 1));
  warmth->sd = warmth->left_mm / std::sqrt(stt);
  warmth->range_k = most_c - least_c;
  warmth->goes_both_ways = rises && falls;
  return true;
}

}  // namespace

void FactsOfTemperature(const std::vector<const Row*>& rows, Facts* facts) {
  constexpr std::size_t kFewest = 6;
  constexpr double kMostLeft = 0.25;
  const Cells cells = CellsOf(rows, kAnyHome | kAnyCampaign);
  if (cells.size() != 1 || rows.size() < kFewest) return;
  const Thermometer* best = nullptr;
  Warmth least{.left_mm = HUGE_VAL};
  for (const Thermometer& sensor : kSensors) {
    Warmth warmth;
    if (!Fit(rows, sensor, &warmth) || warmth.left_mm > least.left_mm) continue;
    least = warmth;
    best = &sensor;
  }
  if (best == nullptr || least.left_mm > kMostLeft * least.spread_mm) return;
  // It explains a drift or levels that were told of the same rows.
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "drift" || fact.id == "jump" || fact.id == "homing_scatter";
  });
  facts->all.push_back(
      {.id = "temperature",
       .word = best->id,
       .figures = {{"um_per_k", UmFromMm(least.slope_mm_per_k), UmFromMm(least.sd)},
                   {"left_um", UmFromMm(least.left_mm)}},
       .sigmas = std::abs(least.slope_mm_per_k) / std::max(least.sd, 1e-15),
       .sentence = fmt::format(
           "The reading follows the temperature of {} by {} over {:.3g} K, and leaves "
           "{} um "
           "about that line{}. Read at one temperature, or correct by this figure",
           best->words,
           WithSd(UmFromMm(least.slope_mm_per_k), UmFromMm(least.sd), "um/K"),
           least.range_k,
           TwoDigits(UmFromMm(least.left_mm)),
           least.goes_both_ways ? ", warming and cooling alike: no wear, no loose "
                                  "mount, no drift with time"
                                : "; it was only ever warmed (or cooled), so time "
                                  "would explain it as well"),
       .is_answer = true});
}

}  // namespace caltwin
