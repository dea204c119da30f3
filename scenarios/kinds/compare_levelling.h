#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calibration/kinds/triple_z/procedures.h"
#include "scenarios/contender.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// One way to level a bed on three screws. A rival more is one line more in
/// LevellingRivals().
struct LevellingRival {
  std::string_view name{};
  std::string_view about{};
  TripleZResult (*level)(TripleZPrinter* printer) = nullptr;
};
std::span<const LevellingRival> LevellingRivals();

/// How the trigger scatters on all of them.
inline constexpr double kLevellingSigma_mm = 0.01;

/// The n-th random printer of a seed, the same for every rival: the bed's slopes normal
/// within 4 mrad, bowl and twist within 30 um, each screw 3 mm off along x and y, one
/// in four with a screw 40 mm off, one in five with motors swapped: two of them or all
/// three in a ring.
std::vector<Injected> RandomTripleZ(std::uint64_t seed, int machine);

/// How one rival did.
struct LevellingStanding {
  std::string_view name{};
  double touches = 0;    ///< Mean over machines.
  int failures = 0;      ///< It refused, stopped, or left the bed worse than it was.
  int refusals = 0;      ///< Of these, those that it said beforehand.
  Spread mean_um{};      ///< Mean error of the bed, against its own mean height.
  Spread worst_um{};     ///< Largest.
  double machine_s = 0;  ///< Median of the printer's time.
};

/// What single screws told, over all machines.
struct Foretelling {
  int diverging = 0;  ///< Machines whose true gain is above 1.
  int foretold = 0;   ///< Of these, said so before anything was levelled.
  int false_alarms = 0;
  int swapped = 0, swaps_named = 0, swaps_invented = 0;  ///< Pairs and rings.
  int rings = 0, rings_named = 0;                        ///< Of these, rings.
  Spread pivot_mm{};  ///< Of the screws' places, as found.
};

struct LevellingComparison {
  int machines = 0;
  std::uint64_t seed = 0;
  bool is_interrupted = false;
  std::vector<LevellingStanding> engines{};
  Foretelling foretelling{};
};

/// Runs every rival on every machine, in closed form.
LevellingComparison CompareLevelling(int machines,
                                     std::uint64_t seed,
                                     const std::function<void(int)>& progress);

/// By the mean error of the bed.
std::vector<Contender> ContendersOf(const LevellingComparison& comparison);
std::string LevellingComparisonText(const LevellingComparison& comparison);
nlohmann::ordered_json LevellingComparisonJson(const LevellingComparison& comparison);

}  // namespace caltwin
