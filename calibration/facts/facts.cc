#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "calibration/facts/advice.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/fact.h"
#include "calibration/facts/groups.h"
#include "calibration/facts/levelling.h"
#include "calibration/facts/map_change.h"
#include "calibration/facts/motion.h"
#include "calibration/facts/one_size.h"
#include "calibration/facts/repeats.h"
#include "calibration/facts/scale.h"
#include "calibration/facts/series.h"
#include "calibration/facts/stretch.h"
#include "calibration/facts/surface.h"
#include "calibration/facts/temperature.h"
#include "calibration/facts/tower_heights.h"
#include "calibration/facts/turn.h"
#include "calibration/facts/waves.h"

namespace caltwin {

namespace {

// What many places show is told once, where it is largest.
void KeepLargest(const std::string& id, Facts* facts) {
  const Fact* largest = nullptr;
  for (const Fact& fact : facts->all) {
    if (fact.id != id) continue;
    const bool is_larger =
        largest == nullptr ||
        std::abs(fact.figures[0].value) > std::abs(largest->figures[0].value);
    if (is_larger) largest = &fact;
  }
  if (largest == nullptr) return;
  const Fact kept = *largest;
  bool is_kept = false;
  std::erase_if(facts->all, [&](const Fact& fact) {
    if (fact.id != id) return false;
    const bool is_it = !is_kept && fact.sentence == kept.sentence;
    is_kept |= is_it;
    return !is_it;
  });
}

}  // namespace

const Fact* Facts::Find(const std::string& id) const {
  const auto found = std::ranges::find(all, id, &Fact::id);
  return found == all.end() ? nullptr : &*found;
}

Facts FactsOf(const RowTable& table,
              const DataHeader& header,
              const LevellingLog& levelling,
              bool has_places) {
  Facts facts;
  const std::vector<const Row*> rows = RowsInOrder(table);
  if (rows.empty()) return facts;
  Repeats repeats = FactsOfRepeats(rows, header, &facts);
  FactsOfMeshes(rows, &repeats, &facts);
  const std::set<std::int64_t> far = FactsOfSurface(rows, repeats, has_places, &facts);
  repeats.outliers.insert(far.begin(), far.end());
  FactsOfArrival(rows, &facts);
  FactsOfMotion(rows, repeats, header, &facts);
  FactsOfStretch(rows, repeats, &facts);
  FactsOfLengths(rows, header, &facts);
  FactsOfTemperature(rows, repeats, &facts);
  facts.is_one_place =
      CellsOf(rows, kAnyHome | kAnyCampaign | kAnyFeed | kAnySense).size() <= 3;
  FactsOfTurn(rows, &facts);
  FactsOfWaves(rows, repeats, &facts);
  FactsOfSeries(rows, repeats, &facts);
  FactsOfMapChange(rows, repeats, &facts);
  FactsOfTowerHeights(rows, &facts);
  FactsOfProbeOffset(rows, &facts);
  FactsOfSetting(rows, &facts);
  FactsOfGroups(rows, repeats, header, &facts);
  FactsOfInstruments(rows, repeats, header, &facts);
  FactsOfHistory(rows, &facts);
  FactsOfLevelling(rows, repeats, levelling, &facts);
  FactsOfOneSize(rows, &facts);
  TellBadProbe(rows, repeats, &facts);
  // Several switches have each their own.
  const Fact* homing = facts.Find("homing_scatter");
  if (homing != nullptr && homing->word.empty()) KeepLargest("homing_scatter", &facts);
  KeepSurestScales(&facts);
  KeepLargest("drift", &facts);
  KeepLargest("jump", &facts);
  std::ranges::stable_sort(facts.all, std::ranges::greater{}, &Fact::is_answer);
  // Who hands in two maps asks what changed.
  std::ranges::stable_partition(
      facts.all, [](const Fact& fact) { return fact.id == "map_change"; });
  AddAdvice(rows, repeats, &facts);
  return facts;
}

}  // namespace caltwin
