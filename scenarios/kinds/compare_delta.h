#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calibration/kinds/delta/bench.h"
#include "scenarios/contender.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// A delta to calibrate; its drawing is that of SymmetricDelta(300, 130, 250).
struct DeltaCase {
  DeltaBuild<double> build{};
  DeltaBed<double> bed{};
};

/// One engine that calibrates a delta by touches: a re-implementation by a function, a
/// shipped program by a machine of its own. A rival more is one line more in
/// DeltaRivals().
struct DeltaRival {
  std::string_view name{};
  std::string_view about{};
  DeltaOutcome (*calibrate)(const DeltaProbe& probe,
                            const DeltaModel<double>& start) = nullptr;
  /// In place of that. Throws HostLost; InputError where the program is not installed.
  DeltaOutcome (*calibrate_shipped)(const DeltaCase& machine,
                                    std::uint64_t seed) = nullptr;
};
std::span<const DeltaRival> DeltaRivals();
/// Their names, with commas between them.
std::string DeltaRivalNames();

/// How the trigger scatters on all of them.
inline constexpr double kCompareTouchSigma_mm = 0.01;
/// Heights and places are judged, and touches taken, within it.
inline constexpr double kCompareRadius_mm = 100;

/// The n-th random machine of a seed, the same for every engine: endstops and radius
/// uniform within 1 mm of the drawing, angles of towers a and b within 0.5 deg, each of
/// six rods within 0.3 mm, the bed's slopes in x and y within 3 mrad.
DeltaCase RandomDelta(std::uint64_t seed, int machine);

/// How one engine did.
struct DeltaStanding {
  std::string_view name{};
  double touches = 0;  ///< Mean over machines.
  /// It said that it failed, or left heights worse than it found them.
  int failures = 0;
  Spread z_rms_um{};  ///< Nozzle over bed at unseen points, its mean included.
  Spread xy_scale_um_per_mm{};  ///< Magnitude.
  double time_s = 0;  ///< Of the processor, the simulated touches included; median.
};

struct DeltaComparison {
  int machines = 0;
  std::uint64_t seed = 0;
  bool is_interrupted = false;  ///< `machines` are those that were done.
  std::vector<DeltaStanding> engines{};
};

/// Runs the rivals of those names, none: all but shipped programs, on every machine.
/// `progress` hears how many machines are done. Ends early where InterruptRequested().
/// Throws InputError at a name that none has.
DeltaComparison CompareDelta(int machines,
                             std::uint64_t seed,
                             const std::function<void(int)>& progress,
                             const std::vector<std::string>& engines = {});

/// By the nozzle's height over the bed at unseen points.
std::vector<Contender> ContendersOf(const DeltaComparison& comparison);
std::string DeltaComparisonText(const DeltaComparison& comparison);
nlohmann::ordered_json DeltaComparisonJson(const DeltaComparison& comparison);

}  // namespace caltwin
