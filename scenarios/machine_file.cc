#include "scenarios/machine_file.h"

#include <array>

#include <fmt/format.h>

#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestFile_bytes = 1'000'000;

struct SettingKey {
  const char* key;
  std::array<double, 3> Settings::*values;
  Bounds bounds;
};
constexpr std::array kSettingKeys = {
    SettingKey{"steps_per_mm", &Settings::steps_per_mm, {1e-3, 1e7}},
    SettingKey{"backlash_mm", &Settings::backlash_mm, {0, 10}},
    SettingKey{"probe_deflection_mm", &Settings::probe_deflection_mm, {-10, 10}}};
constexpr const char* kTipRadius = "tip_radius_mm";
constexpr Bounds kTipRadiusBounds{0, 50};

// The effects of an extension without what only diagnosis reads. Parsed again rather
// than copied, so that the places of the remaining keys stand in messages.
YamlMap PlainEffects(const fs::path& file, Faults* faults) {
  YAML::Node root = YAML::Load(ReadTextFile(file, kLargestFile_bytes));
  YAML::Node effects = root["effects"];
  for (auto entry : effects) {
    if (!entry.second.IsMap()) continue;
    for (const char* key : {"sd", "probability", "rivals"}) entry.second.remove(key);
  }
  return {effects, file.string(), "effects", faults};
}

std::size_t CountEntries(const YamlValue& value) {
  if (value.is_list()) return value.List().size();
  return value.is_map() ? value.Map().Entries().size() : 0;
}

MachineFile ReadExtension(const fs::path& file, YamlMap* map) {
  const auto base = map->Required("extends");
  MachineFile extension =
      ReadMachineFile(FindMachine(base->Text(), file.parent_path(), base->place()));
  extension.machine.file = file;
  map->IntegerOr("format", 1, 1, 1);
  extension.machine.name = map->TextOr("name", extension.machine.name);
  map->TextOr("extends_sha256", "");
  map->Optional("evidence");
  if (const auto unknown = map->Optional("unknown")) {
    const std::size_t count = CountEntries(*unknown);
    if (count > 0) {
      extension.notes.push_back(
          fmt::format("{}: {} unknown channel(s) are not acted on by this version",
                      file.string(),
                      count));
    }
  }
  if (map->Has("effects") && map->Optional("effects")->is_map()) {
    const auto more = ReadEffects(PlainEffects(file, map->faults()), extension.machine);
    extension.effects.insert(extension.effects.end(), more.begin(), more.end());
  } else if (const auto effects = map->Optional("effects")) {
    effects->Map();
  }
  map->NoMoreKeys();
  return extension;
}

}  // namespace

MachineFile ReadMachineFile(const fs::path& file) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  MachineFile read;
  if (map.Has("extends")) {
    read = ReadExtension(file, &map);
  } else {
    read.machine = ReadMachine(&map);
  }
  faults.ThrowIfAny();
  return read;
}

std::vector<SettingSpec> ReadSettingSpecs(YamlMap map) {
  std::vector<SettingSpec> specs;
  for (const SettingKey& setting : kSettingKeys) {
    const auto value = map.Optional(setting.key);
    if (!value) continue;
    YamlMap by_axis = value->Map();
    for (const Axis axis : kAxes) {
      if (const auto number = by_axis.Optional(Name(axis))) {
        specs.push_back({.key = setting.key,
                         .axis = axis,
                         .value = number->NumberOrDistribution(setting.bounds)});
      }
    }
    by_axis.NoMoreKeys();
  }
  if (const auto radius = map.Optional(kTipRadius)) {
    specs.push_back(
        {.key = kTipRadius, .value = radius->NumberOrDistribution(kTipRadiusBounds)});
  }
  map.NoMoreKeys();
  return specs;
}

Settings DrawSettings(Settings settings,
                      const std::vector<SettingSpec>& specs,
                      std::uint64_t seed,
                      std::uint64_t sample) {
  for (const SettingSpec& spec : specs) {
    Rng rng(seed,
            sample,
            fmt::format("settings.{}.{}", spec.key, spec.axis ? Name(*spec.axis) : ""));
    const double value = Draw(spec.value, &rng);
    if (!spec.axis) {
      settings.tip_radius_mm =
          std::clamp(value, kTipRadiusBounds.min, kTipRadiusBounds.max);
      continue;
    }
    for (const SettingKey& setting : kSettingKeys) {
      if (spec.key != setting.key) continue;
      (settings.*setting.values)[Index(*spec.axis)] =
          std::clamp(value, setting.bounds.min, setting.bounds.max);
    }
  }
  return settings;
}

TruthFile ReadTruthFile(const fs::path& file, const Machine& machine) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  TruthFile truth;
  if (const auto effects = map.Optional("effects")) {
    truth.effects = ReadEffects(effects->Map(), machine);
  }
  if (const auto settings = map.Optional("settings")) {
    truth.settings = ReadSettingSpecs(settings->Map());
  }
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return truth;
}

}  // namespace caltwin
