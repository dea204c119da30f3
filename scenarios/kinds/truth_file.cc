#include "scenarios/kinds/truth_file.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "scenarios/kinds/motor_stage_effects.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/machine_file.h"
#include "sim/effects/catalog.h"
#include "sim/kinds/delta/effects.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

/// What a kind of machine knows by name, and how its truth files are read.
struct TruthKind {
  const char* model;
  bool (*knows)(const std::string& cause, const std::string& axis);
  void (*read)(const fs::path& file, const fs::path& machine);
};

bool HasAxis(const std::string& cause,
             const std::string& axis,
             const MachineKind* kind) {
  const auto effect = FindEffect(cause);
  if (!effect) return false;
  const auto axes = AxesOn(EffectAt(*effect), kind);
  return std::ranges::find(axes, axis) != axes.end();
}

template <const MachineKind* (*kind)()>
bool KnowsInCatalog(const std::string& cause, const std::string& axis) {
  return HasAxis(cause, axis, kind());
}

bool KnowsOfDelta(const std::string& cause, const std::string& /*axis*/) {
  const auto names = DeltaEffectNames();
  return std::ranges::find(names, cause) != names.end();
}

bool KnowsOfMotors(const std::string& cause, const std::string& axis) {
  const auto names = MotorEffectNames();
  return std::ranges::find(names, cause) != names.end() && MotorAxisNamed(axis);
}

void ReadOfCatalog(const fs::path& file, const fs::path& machine) {
  ReadTruthFile(file, ReadMachine(machine));
}

constexpr std::array kKinds = {
    TruthKind{"gantry_router", KnowsInCatalog<CartesianKind>, ReadOfCatalog},
    TruthKind{"delta_printer",
              KnowsOfDelta,
              [](const fs::path& file, const fs::path& machine) {
                ReadDeltaTruthFile(file, ReadMachine(machine));
              }},
    TruthKind{"triple_z_printer", KnowsInCatalog<TripleZKind>, ReadOfCatalog},
    TruthKind{"z_station", KnowsInCatalog<ZStationKind>, ReadOfCatalog},
    TruthKind{"motor_stage",
              KnowsOfMotors,
              [](const fs::path& file, const fs::path& machine) {
                ReadMotorTruthFile(file, MotorStageOf(ReadMachine(machine)));
              }}};

// How many of the file's effects the kind knows, each with the axis that it has there.
int KnownTo(const TruthKind& kind, const std::vector<std::string>& names) {
  return static_cast<int>(std::ranges::count_if(names, [&](const std::string& name) {
    const std::size_t dot = name.find('.');
    return kind.knows(name.substr(0, dot),
                      dot == std::string::npos ? "" : name.substr(dot + 1));
  }));
}

std::vector<std::string> EffectsIn(const fs::path& file) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  std::vector<std::string> names;
  const auto effects = map.Optional("effects");
  if (!effects || !effects->is_map()) return names;
  for (const auto& [name, value] : effects->Map().Entries()) names.push_back(name);
  return names;
}

// The faults of reading it so; nullopt: none.
std::optional<InputError> FaultsAs(const TruthKind& kind, const fs::path& file) {
  try {
    kind.read(file, ShareFolder() / "models" / kind.model / "machine.yaml");
  } catch (const InputError& error) {
    return error;
  }
  return std::nullopt;
}

}  // namespace

void CheckTruthFile(const fs::path& file) {
  const std::vector<std::string> names = EffectsIn(file);
  std::optional<InputError> nearest;
  int most = -1;
  for (const TruthKind& kind : kKinds) {
    const auto error = FaultsAs(kind, file);
    if (!error) return;
    const int known = KnownTo(kind, names);
    const bool is_nearer =
        known > most ||
        (known == most && error->faults().size() < nearest->faults().size());
    if (!is_nearer) continue;
    nearest = error;
    most = known;
  }
  throw InputError(std::move(*nearest));
}

}  // namespace caltwin
