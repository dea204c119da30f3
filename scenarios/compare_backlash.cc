#include "scenarios/compare_backlash.h"

#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "scenarios/interrupt.h"
#include "scenarios/runner.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::array kRivals = {
    BacklashRival{"cluster_as_published",
                  "NeXT 3.5 as printed: both sides of one face",
                  "next_cluster_backlash: {axis: x, variant: as_published}"},
    BacklashRival{"cluster_corrected",
                  "clusters of triggers and releases at one face",
                  "next_cluster_backlash: {axis: x, variant: corrected, repeats: 10}"},
    BacklashRival{
        "release_as_published",
        "trigger against release, M425 added",
        "trigger_release_backlash: {axis: x, variant: as_published, repeats: 10}"},
    BacklashRival{
        "release_corrected",
        "the same, by what is left beside M425",
        "trigger_release_backlash: {axis: x, variant: corrected, repeats: 10}"},
    BacklashRival{
        "dial", "a dial: preload, zero, on, back", "dial_backlash: {axis: x}"},
    BacklashRival{"same_side",
                  "a public successor's replacement",
                  "same_side_backlash: {axis: x, variant: as_published}"},
    BacklashRival{"away_return",
                  "another, a dial's usual form",
                  "away_return_backlash: {axis: x, variant: as_published}"}};

constexpr const char* kGap = "backlash.x";
constexpr double kSure95 = 1.96;

/// One rival on one machine.
struct Trial {
  std::string outcome{};
  std::optional<double> error_mm{}, sd_mm{};
  double touches = 0, machine_s = 0;
};

Trial Try(const Scenario& scenario, std::uint64_t seed, int machine) {
  const RunResult run = RunScenario(scenario,
                                    {.fidelity = Fidelity::kFast,
                                     .seed = seed,
                                     .sample = static_cast<std::uint64_t>(machine)});
  Trial trial{.outcome = run.outcome,
              .touches = static_cast<double>(run.touches),
              .machine_s = run.machine_time_s};
  for (const ParameterResult& parameter : run.parameters) {
    if (parameter.name != kGap || !parameter.recovered) continue;
    trial.error_mm = parameter.error;
    trial.sd_mm = parameter.sd;
  }
  return trial;
}

BacklashStanding StandingOf(const BacklashRival& rival,
                            const std::vector<Trial>& trials) {
  BacklashStanding standing{.name = rival.name};
  std::vector<double> size_um, machine_s;
  for (const Trial& trial : trials) {
    standing.touches += trial.touches / static_cast<double>(trials.size());
    ++standing.outcomes[trial.outcome];
    machine_s.push_back(trial.machine_s);
    if (!trial.error_mm) {
      ++standing.failures;
      continue;
    }
    size_um.push_back(UmFromMm(std::abs(*trial.error_mm)));
    standing.bias_um += UmFromMm(*trial.error_mm);
    if (!trial.sd_mm || *trial.sd_mm <= 0) continue;
    ++standing.intervals;
    standing.covered += std::abs(*trial.error_mm) <= kSure95 * *trial.sd_mm ? 1 : 0;
  }
  standing.machine_s = SpreadOf(machine_s).median;
  if (size_um.empty()) return standing;
  standing.bias_um /= static_cast<double>(size_um.size());
  standing.error_um = SpreadOf(size_um);
  return standing;
}

std::string Outcomes(const BacklashStanding& standing) {
  std::vector<std::string> words;
  for (const auto& [outcome, count] : standing.outcomes) {
    words.push_back(fmt::format("{} {}", outcome, count));
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

bool IsTold(const BacklashStanding& standing, int machines) {
  return standing.failures < machines;
}

}  // namespace

std::span<const BacklashRival> BacklashRivals() {
  return kRivals;
}

std::string BacklashScenarioText(const BacklashRival& rival) {
  return fmt::format(R"(about: "{}"
machine: gantry_router
fidelity: fast
effects:
  backlash.x: {{gap_mm: {{lognormal: {{median: 0.05, factor: 2}}}}}}
  steps_per_mm.x: {{true_steps_per_mm: {{normal: {{mean: 800, sd: 2}}}}}}
  probe_pretravel.x: {{pretravel_mm: {{normal: {{mean: 0.02, sd: 0.003}}}}}}
settings: {{backlash_mm: {{x: {{uniform: {{min: 0, max: 0.05}}}}}}}}
instruments: {{probe: {{sigma_um: 1}}, dial: {{sigma_um: 1, resolution_um: 1}}}}
artefacts: {{block: {{type: block123, at_mm: [150, 150, 0], side: x}}}}
calibrate:
  - {}
)",
                     rival.about,
                     rival.step);
}

BacklashComparison CompareBacklash(int machines,
                                   std::uint64_t seed,
                                   const std::function<void(int)>& progress) {
  BacklashComparison comparison{.seed = seed};
  std::vector<Scenario> scenarios;
  for (const BacklashRival& rival : kRivals) {
    scenarios.push_back(
        ReadScenarioText(BacklashScenarioText(rival), "compare_backlash.yaml"));
  }
  std::vector<std::vector<Trial>> trials(kRivals.size());
  for (int machine = 0; machine < machines && !InterruptRequested(); ++machine) {
    progress(machine);
    for (std::size_t k = 0; k < kRivals.size(); ++k) {
      trials[k].push_back(Try(scenarios[k], seed, machine));
    }
    ++comparison.machines;
  }
  comparison.is_interrupted = comparison.machines < machines;
  if (comparison.machines == 0) return comparison;
  for (std::size_t k = 0; k < kRivals.size(); ++k) {
    comparison.engines.push_back(StandingOf(kRivals[k], trials[k]));
  }
  return comparison;
}

std::vector<Contender> ContendersOf(const BacklashComparison& comparison) {
  return Contenders(comparison, BacklashRivals(), &BacklashStanding::error_um);
}

std::string BacklashComparisonText(const BacklashComparison& comparison) {
  std::string text = fmt::format(
      "{} random routers, seed {}: gaps of 50 um by a factor of 2, M425 somewhere from "
      "0 "
      "to 50 um, probe and dial of 1 um\n\n{:<22} {:>8} {:>9} {:>32} {:>9} {:>8} {:>9} "
      " "
      "{}\n",
      comparison.machines,
      comparison.seed,
      "procedure",
      "touches",
      "not told",
      "|error| um: median [95 %] p95",
      "bias um",
      "held",
      "machine",
      "ended as");
  for (const BacklashStanding& engine : comparison.engines) {
    const bool is_told = IsTold(engine, comparison.machines);
    const std::string error = is_told ? fmt::format("{:.1f} [{:.1f}, {:.1f}] {:.1f}",
                                                    engine.error_um.median,
                                                    engine.error_um.low,
                                                    engine.error_um.high,
                                                    engine.error_um.p95)
                                      : "-";
    const std::string held =
        engine.intervals > 0
            ? fmt::format("{:.1f} %", 100.0 * engine.covered / engine.intervals)
            : "-";
    text += fmt::format("{:<22} {:>8.1f} {:>9} {:>32} {:>9} {:>8} {:>7.0f} s  {}\n",
                        engine.name,
                        engine.touches,
                        engine.failures,
                        error,
                        is_told ? fmt::format("{:+.1f}", engine.bias_um) : "-",
                        held,
                        engine.machine_s,
                        Outcomes(engine));
  }
  return text + "\nheld: how many of the stated 95 % intervals hold the built gap.\n";
}

nlohmann::ordered_json BacklashComparisonJson(const BacklashComparison& comparison) {
  nlohmann::ordered_json engines = nlohmann::ordered_json::array();
  for (const BacklashStanding& engine : comparison.engines) {
    nlohmann::ordered_json one = {{"name", engine.name},
                                  {"touches", engine.touches},
                                  {"failures", engine.failures},
                                  {"outcomes", engine.outcomes},
                                  {"error_um", nullptr},
                                  {"bias_um", nullptr},
                                  {"coverage95", nullptr},
                                  {"time_s", engine.machine_s}};
    if (IsTold(engine, comparison.machines)) {
      one["error_um"] = {{"median", engine.error_um.median},
                         {"p95", engine.error_um.p95},
                         {"ci95", {engine.error_um.low, engine.error_um.high}}};
      one["bias_um"] = engine.bias_um;
    }
    if (engine.intervals > 0) {
      one["coverage95"] =
          static_cast<double>(engine.covered) / static_cast<double>(engine.intervals);
    }
    engines.push_back(one);
  }
  return {{"format", 1},
          {"kind", "backlash"},
          {"machines", comparison.machines},
          {"seed", comparison.seed},
          {"engines", engines}};
}

}  // namespace caltwin
