// What is wrong at a printer's station, found in what Klipper's commands recorded. The
// truth is that of ZStationTwin, which knows nothing of the effect library.
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "scenarios/runner.h"
#include "scenarios/scenario.h"
#include "sim/base/rng.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

// But where it is what is hidden, the nozzle does not grow.
const std::string kRigidNozzle = "nozzle_mm_per_k: 0";

struct Hidden {
  std::string name{};     ///< Of the finding, with its axis.
  std::string station{};  ///< Keys of the station that make it.
  std::string act{};      ///< What an operator changes half way.
  double size_um = 0;     ///< Of the finding's first parameter.
};

// Calibrations at temperatures in no order, the gap measured after every second one.
std::string ScenarioText(const Hidden& hidden, const std::string& variant, Rng* rng) {
  constexpr int kRounds = 16, kCold_c = 20;
  constexpr std::array kNozzle_c = {25, 80, 140, 200, 220, 240};
  constexpr std::array kBed_c = {25, 60, 100};
  constexpr std::array kChamber_c = {25, 40, 55};
  const auto one_of = [&](const auto& list) {
    const auto size = static_cast<double>(list.size());
    return list[static_cast<std::size_t>(rng->Uniform() * size)];
  };
  std::string text = fmt::format(
      "machine: z_station\nfidelity: fast\nstation: {{{}}}\n"
      "settings: {{samples: 3}}\ncalibrate:\n",
      hidden.station.empty() ? kRigidNozzle : hidden.station);
  for (int round = 0; round < kRounds; ++round) {
    // The first one cold: what grows is counted from there.
    text += fmt::format("  - gcode: {{lines: [M104 S{}, M140 S{}, M141 S{}, G28]}}\n",
                        round == 0 ? kCold_c : one_of(kNozzle_c),
                        round == 0 ? kCold_c : one_of(kBed_c),
                        round == 0 ? kCold_c : one_of(kChamber_c));
    text += "  - z_calibration\n";
    if (round % 2 == 0) {
      text += "  - switch_offset: {apply: false, variant: " + variant + "}\n";
    }
    if (2 * round == kRounds && !hidden.act.empty()) {
      text += fmt::format("  - change: {{{}}}\n", hidden.act);
    }
  }
  return text;
}

Diagnosis DiagnosisOf(const Hidden& hidden,
                      std::uint64_t seed,
                      const std::string& variant = "corrected") {
  const TempFolder folder;
  Rng rng(seed, 0, "z_station_blind");
  const auto file = folder / "hidden.yaml";
  std::ofstream(file) << ScenarioText(hidden, variant, &rng);
  const Scenario scenario = ReadScenario(file);
  const RunResult result = RunScenario(scenario, {.seed = seed});
  const Machine machine =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml");
  return Diagnose(Observed(result.rows, result.header, machine, {}), {});
}

std::string NameOf(const Finding& finding) {
  return finding.axis.empty() ? finding.cause : finding.cause + "." + finding.axis;
}

// Whether it is named, alone, and as large as it is.
bool IsFound(const Hidden& hidden, const Diagnosis& diagnosis) {
  constexpr double kWithin_sd = 4;
  constexpr double kWithin_share = 0.05;
  if (diagnosis.findings.size() != 1) return false;
  const Finding& finding = diagnosis.findings[0];
  if (NameOf(finding) != hidden.name) return false;
  const FindingParameter& size = finding.parameters.at(0);
  return std::abs(size.value - hidden.size_um) <
         kWithin_sd * size.sd + kWithin_share * std::abs(hidden.size_um);
}

std::string WhatWasSaid(const Diagnosis& diagnosis) {
  std::string said = ToString(diagnosis.verdict);
  for (const Finding& finding : diagnosis.findings) {
    said += " " + NameOf(finding);
    if (!finding.parameters.empty()) {
      said += fmt::format(" {:.3g}", finding.parameters[0].value);
    }
  }
  return said;
}

// From three times what these rows are just uncertain by.
std::vector<Hidden> Causes(std::uint64_t seed) {
  Rng rng(seed, 0, "z_station_blind.sizes");
  const double ooze_um = 20 + 200 * rng.Uniform();
  const double growth = 0.1 + 0.5 * rng.Uniform();
  const double bed = 0.3 + rng.Uniform();
  const double trigger = 0.8 + 2 * rng.Uniform();
  const double offset_um = 30 + 100 * rng.Uniform();
  const double nozzle_um = 40 + 200 * rng.Uniform();
  const double plate_um = 200 + 2000 * rng.Uniform();
  const auto of_um = [](const char* key, double um) {
    const bool is_growth = std::string(key) == "nozzle_mm_per_k";
    return fmt::format(
        "{}{}: {:.6f}", is_growth ? "" : kRigidNozzle + ", ", key, um * 1e-3);
  };
  return {{"ooze", of_um("ooze_mm", ooze_um) + ", ooze_flows_c: 170", "", ooze_um},
          {"nozzle_temperature", of_um("nozzle_mm_per_k", growth), "", growth},
          {"frame_temperature.bed", of_um("surface_mm_per_k", bed), "", bed},
          {"probe_temperature", of_um("trigger_mm_per_k", trigger), "", -trigger},
          {"switch_offset", of_um("trigger_mm", 500 + offset_um), "", offset_um},
          {"station_change.nozzle",
           "",
           fmt::format("nozzle_mm: {:.6f}", nozzle_um * 1e-3),
           nozzle_um},
          {"station_change.plate",
           "",
           fmt::format("plate_mm: {:.6f}", plate_um * 1e-3),
           plate_um}};
}

TEST(ZStationBlind, WhatIsHiddenIsNamedAndSized) {
  constexpr std::uint64_t kSeeds = 10;
  constexpr double kMust = 0.9;
  int found = 0, asked = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const Hidden& hidden : Causes(seed)) {
      const Diagnosis diagnosis = DiagnosisOf(hidden, seed);
      const bool is_found = IsFound(hidden, diagnosis);
      found += is_found ? 1 : 0;
      ++asked;
      if (is_found) continue;
      std::cout << fmt::format("seed {}: {} of {:.3g} was said to be: {}\n",
                               seed,
                               hidden.name,
                               hidden.size_um,
                               WhatWasSaid(diagnosis));
    }
  }
  RecordProperty("found", found);
  EXPECT_GE(found, kMust * asked) << found << " of " << asked;
}

// Plastic that hangs there at any temperature and a wrong switch_offset leave the same
// gap: without a wiped nozzle neither is named alone, and wiping is asked for.
TEST(ZStationBlind, OozeAtAnyTemperatureIsNotTakenForTheSwitchOffset) {
  constexpr std::uint64_t kSeeds = 10;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Hidden hidden{.station = kRigidNozzle + ", ooze_mm: 0.12"};
    const Diagnosis unwiped = DiagnosisOf(hidden, seed, "as_published");
    const Diagnosis wiped = DiagnosisOf(hidden, seed, "corrected");

    EXPECT_EQ(unwiped.verdict, DiagnosisVerdict::kAmbiguous) << WhatWasSaid(unwiped);
    ASSERT_EQ(unwiped.findings.size(), 1U) << seed;
    const auto& candidates = unwiped.findings[0].candidates;
    for (const char* cause : {"ooze", "switch_offset"}) {
      EXPECT_NE(std::ranges::find(candidates, cause, &FindingCandidate::cause),
                candidates.end())
          << cause;
    }
    ASSERT_TRUE(unwiped.next_campaign) << seed;
    EXPECT_EQ(unwiped.next_campaign->options.at("wiped"), "true");
    ASSERT_EQ(wiped.findings.size(), 1U) << WhatWasSaid(wiped);
    EXPECT_EQ(NameOf(wiped.findings[0]), "ooze") << seed;
  }
}

// What a mesh touches has a height at each place, and no cause.
TEST(ZStationBlind, AMeshIsNoFinding) {
  const Scenario scenario =
      ReadScenario(CALTWIN_SOURCE_DIR "/scenarios/z_offset_mesh_reference.yaml");
  const RunResult result = RunScenario(scenario, {.fidelity = Fidelity::kFast});
  const Machine machine =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml");

  const Diagnosis diagnosis =
      Diagnose(Observed(result.rows, result.header, machine, {}), {});

  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone) << WhatWasSaid(diagnosis);
}

TEST(ZStationBlind, WhereNothingIsWrongNothingIsNamed) {
  constexpr std::uint64_t kSeeds = 20;
  int named = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Diagnosis diagnosis = DiagnosisOf({}, seed);
    if (diagnosis.findings.empty()) continue;
    ++named;
    std::cout << fmt::format("seed {}: {}\n", seed, WhatWasSaid(diagnosis));
  }
  EXPECT_LE(named, 1);
}

}  // namespace
}  // namespace caltwin
