#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/scenario.h"
#include "sim/base/yaml.h"
#include "sim/firmware/kinds/z_station/klipper.h"
#include "sim/kinds/z_station/station.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One number of a station that a scenario gives, perhaps still to be drawn.
struct StationSpec {
  std::string key{};
  Distribution value = 0.0;
};

/// What a scenario of a nozzle's height has of its own (`station:`).
class ZStationScenario : public KindScenario {
 public:
  std::vector<StationSpec> station{};
  ZCalibrationConfig settings{};

  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<ZStationScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  Procedures KnownProcedures() const override { return ProceduresOf("z_station"); }
  std::string_view Owner() const override { return "a printer's station"; }
  std::vector<Word> ScenarioSteps() const override;
  std::span<const Word> OwnKeys() const override;
  CalibrationStep ReadScenarioStep(const std::string& name,
                                   YamlMap options) const override;
  Expectable CanExpect() const override;
  std::vector<std::string> EffectNames() const override { return {"station"}; }
  void Vary(const std::string& effect,
            const std::string& parameter,
            const YamlValue& value,
            Scenario* scenario) override;
  std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                   const Chance& chance) const override;
  bool CanBeUnderKlipper() const override { return true; }
  std::unique_ptr<KindTrial> BeginUnderKlipper(const Scenario& scenario,
                                               const Chance& chance) const override;
};

/// Reads `station: {KEY: number or distribution}`.
std::vector<StationSpec> ReadStation(YamlMap map);

/// Sets what the specs say, each drawn from its own stream.
void SetStation(const std::vector<StationSpec>& specs,
                std::uint64_t seed,
                std::uint64_t sample,
                ZStation* station);

}  // namespace caltwin
