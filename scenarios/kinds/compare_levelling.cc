#include "scenarios/kinds/compare_levelling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/interrupt.h"
#include "scenarios/kinds/triple_z_wire.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

TripleZResult PublishedExample(TripleZPrinter* printer) {
  return RunBedTilt(
      printer,
      {.is_as_published = true, .rule = OffsetRule::kExample, .largest_mm = 250});
}

TripleZResult PublishedFormula(TripleZPrinter* printer) {
  return RunBedTilt(
      printer,
      {.is_as_published = true, .rule = OffsetRule::kFormula, .largest_mm = 250});
}

template <int side>
TripleZResult Corrected(TripleZPrinter* printer) {
  return RunBedTilt(printer, {.columns = side, .rows = side});
}

TripleZResult Iterated(TripleZPrinter* printer) {
  return RunBedTilt(printer, {.iterates = true, .rounds = 5, .target_mm = 0.005});
}

TripleZResult Rrf(TripleZPrinter* printer) {
  return RunRrfLevelling(printer,
                         {.is_as_published = true, .rounds = 2, .target_mm = 0});
}

// What the project proposes: screws first, then two rounds by what they said.
TripleZResult FoundScrews(TripleZPrinter* printer) {
  const TripleZResult found = RunPivotsAndWiring(printer, {.test_mm = 3});
  TripleZResult levelled = RunRrfLevelling(
      printer,
      {.is_as_published = true, .columns = 5, .rows = 5, .rounds = 2, .target_mm = 0});
  levelled.result.touches += found.result.touches;
  levelled.response = found.response;
  return levelled;
}

constexpr std::array kRivals = {
    LevellingRival{"published_example",
                   "bed tilt by the published example's sign",
                   PublishedExample},
    LevellingRival{
        "published_formula", "bed tilt by the published formula", PublishedFormula},
    LevellingRival{"bed_tilt_3x3", "corrected, one round", Corrected<3>},
    LevellingRival{"bed_tilt_5x5", "corrected, one round", Corrected<5>},
    LevellingRival{"bed_tilt_iterated", "corrected, up to five rounds", Iterated},
    LevellingRival{"rrf_levelling", "G30 P .. S3, two rounds", Rrf},
    LevellingRival{
        "found_screws", "pivots and wiring, then two rounds of 5x5", FoundScrews}};

/// One rival on one machine.
struct Trial {
  bool failed = false, refused = false;
  double touches = 0, mean_um = 0, worst_um = 0, machine_s = 0;
};

BuiltTripleZ BuiltNumber(const Machine& machine, std::uint64_t seed, int number) {
  return {.machine = machine,
          .effects = RandomTripleZ(seed, number),
          .scatter_mm = kLevellingSigma_mm};
}

Machine Drawn() {
  return ReadMachine(ShareFolder() / "models/triple_z_printer/machine.yaml");
}

// Against its own mean height: a probe's offset says where that is.
struct Flatness {
  double mean_um = 0, worst_um = 0, rms_mm = 0;
};

Flatness FlatnessOf(const BuiltTripleZ& built, const Vec3<double>& raised_mm) {
  const TrueLevel at_nought = TrueLevelOf(built, raised_mm, 0);
  const double middle_mm = TrueBedHeight_mm(built, raised_mm, {117.5, 117.5});
  const TrueLevel level = TrueLevelOf(built, raised_mm, middle_mm);
  return {UmFromMm(level.mean_mm), UmFromMm(level.max_mm), at_nought.flat_rms_mm};
}

Trial Try(const LevellingRival& rival,
          const BuiltTripleZ& built,
          std::uint64_t seed,
          int number,
          TripleZResult* result) {
  TripleZTwinPlant plant(
      built, /*is_physics=*/false, seed, static_cast<std::uint64_t>(number));
  Firmware firmware(built.machine,
                    built.machine.settings,
                    FirmwareOnScrews(TripleZOf(built.machine).pivots_mm()),
                    &plant);
  EmulatedLink wire(&firmware);
  TripleZPrinter printer(BenchOf(built.machine, &wire, kLevellingSigma_mm));
  const Flatness before = FlatnessOf(built, Vec3<double>::Zero());
  *result = rival.level(&printer);
  const Flatness after = FlatnessOf(built, firmware.raised_mm());
  const Ending ending = result->result.ending;
  return {.failed = ending != Ending::kDone || after.rms_mm > before.rms_mm,
          .refused = ending == Ending::kRefused,
          .touches = static_cast<double>(firmware.probed().size()),
          .mean_um = after.mean_um,
          .worst_um = after.worst_um,
          .machine_s = firmware.machine_time_s()};
}

LevellingStanding StandingOf(const LevellingRival& rival,
                             const std::vector<Trial>& trials) {
  LevellingStanding standing{.name = rival.name};
  std::vector<double> mean_um, worst_um, machine_s;
  for (const Trial& trial : trials) {
    standing.touches += trial.touches / static_cast<double>(trials.size());
    standing.failures += trial.failed ? 1 : 0;
    standing.refusals += trial.refused ? 1 : 0;
    mean_um.push_back(trial.mean_um);
    worst_um.push_back(trial.worst_um);
    machine_s.push_back(trial.machine_s);
  }
  standing.mean_um = SpreadOf(mean_um);
  standing.worst_um = SpreadOf(worst_um);
  standing.machine_s = SpreadOf(machine_s).median;
  return standing;
}

// What was said of the screws against how they stand.
void CountForetelling(const BuiltTripleZ& built,
                      const TripleZResult& iterated,
                      const TripleZResult& found,
                      Foretelling* foretelling,
                      std::vector<double>* off_mm) {
  const Pivots<double> standing_mm = BuiltPivots_mm(built.machine, built.effects);
  std::array<int, kNumScrews> driver = {0, 1, 2};
  bool is_swapped = false, is_ring = false;
  for (const Injected& effect : built.effects) {
    if (effect.effect != EffectIndex<MotorsSwapped>()) continue;
    driver = MotorsSwapped::ScrewsTurned(effect.axis);
    is_swapped = true;
    is_ring = std::ranges::none_of(std::array{0, 1, 2}, [&](int i) {
      return driver[static_cast<std::size_t>(i)] == i;
    });
  }
  Pivots<double> by_driver_mm;
  for (std::size_t i = 0; i < driver.size(); ++i) {
    by_driver_mm[i] = standing_mm[static_cast<std::size_t>(driver[i])];
  }
  const double truly =
      SpectralRadius(LevellingGain(by_driver_mm, TripleZOf(built.machine).pivots_mm()));
  const bool says = iterated.predicted_factor.value_or(0) >= 1;
  foretelling->diverging += truly >= 1 ? 1 : 0;
  foretelling->foretold += truly >= 1 && says ? 1 : 0;
  foretelling->false_alarms += truly < 1 && says ? 1 : 0;
  foretelling->swapped += is_swapped ? 1 : 0;
  foretelling->rings += is_ring ? 1 : 0;
  if (!found.response) return;
  const bool is_right = found.response->screw_of == driver;
  foretelling->swaps_named += is_swapped && is_right ? 1 : 0;
  foretelling->rings_named += is_ring && is_right ? 1 : 0;
  foretelling->swaps_invented += !is_swapped && !is_right ? 1 : 0;
  for (std::size_t i = 0; i < driver.size(); ++i) {
    off_mm->push_back((found.response->at_mm[i] - by_driver_mm[i]).norm());
  }
}

nlohmann::ordered_json SpreadJson(const Spread& of) {
  return {{"median", of.median}, {"p95", of.p95}, {"ci95", {of.low, of.high}}};
}

}  // namespace

std::span<const LevellingRival> LevellingRivals() {
  return kRivals;
}

std::vector<Injected> RandomTripleZ(std::uint64_t seed, int machine) {
  Rng rng(seed, static_cast<std::uint64_t>(machine), "compare.levelling");
  std::vector<Injected> effects = {
      {.effect = EffectIndex<BedTilt>(),
       .axis = "",
       .values = {4 * rng.Normal(), 4 * rng.Normal()}},
      {.effect = EffectIndex<BedBowl>(), .axis = "", .values = {30 * rng.Normal()}},
      {.effect = EffectIndex<BedTwist>(), .axis = "", .values = {30 * rng.Normal()}}};
  const bool is_far = rng.Uniform() < 0.25;
  const bool is_swapped = rng.Uniform() < 0.2;
  const auto which = static_cast<std::size_t>(3 * rng.Uniform());
  for (std::size_t i = 0; i < kScrewAxes.size(); ++i) {
    const double wide_mm = is_far && i == which ? 28 : 3;
    effects.push_back({.effect = EffectIndex<PivotPosition>(),
                       .axis = std::string(kScrewAxes[i]),
                       .values = {wide_mm * rng.Normal(), wide_mm * rng.Normal()}});
  }
  const auto wiring =
      static_cast<std::size_t>(MotorsSwapped::kWirings.size() * rng.Uniform());
  if (is_swapped) {
    effects.push_back({.effect = EffectIndex<MotorsSwapped>(),
                       .axis = std::string(MotorsSwapped::kWirings[wiring]),
                       .values = {1}});
  }
  return effects;
}

LevellingComparison CompareLevelling(int machines,
                                     std::uint64_t seed,
                                     const std::function<void(int)>& progress) {
  LevellingComparison comparison{.seed = seed};
  const Machine machine = Drawn();
  std::vector<std::vector<Trial>> trials(kRivals.size());
  std::vector<double> off_mm;
  for (int number = 0; number < machines && !InterruptRequested(); ++number) {
    progress(number);
    const BuiltTripleZ built = BuiltNumber(machine, seed, number);
    std::vector<TripleZResult> results(kRivals.size());
    for (std::size_t k = 0; k < kRivals.size(); ++k) {
      trials[k].push_back(Try(kRivals[k], built, seed, number, &results[k]));
    }
    const auto named = [&](std::string_view name) -> const TripleZResult& {
      const auto rival = std::ranges::find(kRivals, name, &LevellingRival::name);
      return results[static_cast<std::size_t>(rival - kRivals.begin())];
    };
    CountForetelling(built,
                     named("bed_tilt_iterated"),
                     named("found_screws"),
                     &comparison.foretelling,
                     &off_mm);
    ++comparison.machines;
  }
  comparison.is_interrupted = comparison.machines < machines;
  if (comparison.machines == 0) return comparison;
  comparison.foretelling.pivot_mm = SpreadOf(off_mm);
  for (std::size_t k = 0; k < kRivals.size(); ++k) {
    comparison.engines.push_back(StandingOf(kRivals[k], trials[k]));
  }
  return comparison;
}

std::vector<Contender> ContendersOf(const LevellingComparison& comparison) {
  return Contenders(comparison, LevellingRivals(), &LevellingStanding::mean_um);
}

std::string LevellingComparisonText(const LevellingComparison& comparison) {
  std::string text = fmt::format(
      "{} random printers, seed {}; touches scatter by {:.0f} um; judged on 121 "
      "places, "
      "the height in the middle apart\n\n{:<18} {:>8} {:>6} {:>8} {:>30} {:>22} "
      "{:>8}\n",
      comparison.machines,
      comparison.seed,
      UmFromMm(kLevellingSigma_mm),
      "engine",
      "touches",
      "failed",
      "refused",
      "mean error um: median [95 %] p95",
      "worst um: median p95",
      "machine");
  for (const LevellingStanding& engine : comparison.engines) {
    text += fmt::format(
        "{:<18} {:>8.1f} {:>6} {:>8} {:>30} {:>22} {:>6.0f} s\n",
        engine.name,
        engine.touches,
        engine.failures,
        engine.refusals,
        fmt::format("{:.1f} [{:.1f}, {:.1f}] {:.1f}",
                    engine.mean_um.median,
                    engine.mean_um.low,
                    engine.mean_um.high,
                    engine.mean_um.p95),
        fmt::format("{:.1f} {:.1f}", engine.worst_um.median, engine.worst_um.p95),
        engine.machine_s);
  }
  const Foretelling& f = comparison.foretelling;
  return text +
         fmt::format(
             "\nOf {} loops that diverge {} were foretold before anything was "
             "levelled, "
             "{} of the others too.\nOf {} printers with motors swapped {} were named "
             "({} of {} rings of three), {} invented. Screws were found to {:.2f} mm "
             "(median), {:.2f} (p95).\n",
             f.diverging,
             f.foretold,
             f.false_alarms,
             f.swapped,
             f.swaps_named,
             f.rings_named,
             f.rings,
             f.swaps_invented,
             f.pivot_mm.median,
             f.pivot_mm.p95);
}

nlohmann::ordered_json LevellingComparisonJson(const LevellingComparison& comparison) {
  nlohmann::ordered_json engines = nlohmann::ordered_json::array();
  for (const LevellingStanding& engine : comparison.engines) {
    engines.push_back({{"name", engine.name},
                       {"touches", engine.touches},
                       {"failures", engine.failures},
                       {"refusals", engine.refusals},
                       {"mean_error_um", SpreadJson(engine.mean_um)},
                       {"worst_error_um", SpreadJson(engine.worst_um)},
                       {"time_s", engine.machine_s}});
  }
  const Foretelling& f = comparison.foretelling;
  return {{"format", 1},
          {"kind", "levelling"},
          {"machines", comparison.machines},
          {"seed", comparison.seed},
          {"engines", engines},
          {"foretelling",
           {{"diverging", f.diverging},
            {"foretold", f.foretold},
            {"false_alarms", f.false_alarms},
            {"swapped", f.swapped},
            {"swaps_named", f.swaps_named},
            {"swaps_invented", f.swaps_invented},
            {"rings", f.rings},
            {"rings_named", f.rings_named},
            {"pivot_error_mm", SpreadJson(f.pivot_mm)}}}};
}

}  // namespace caltwin
