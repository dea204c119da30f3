#include "tools/commands/twin_options.h"

#include <charconv>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "scenarios/machine_file.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::string_view kScheme = "twin:";

void ReadOption(const std::string& url, std::string_view option, TwinOptions* options) {
  const std::size_t equals = option.find('=');
  const std::string key(option.substr(0, equals));
  const std::string value(equals == std::string_view::npos ? ""
                                                           : option.substr(equals + 1));
  if (key == "truth" && !value.empty()) {
    options->truth = value;
    return;
  }
  if (key == "fidelity" && (value == "fast" || value == "physics")) {
    options->fidelity = value;
    return;
  }
  const auto [end, error] =
      std::from_chars(value.data(), value.data() + value.size(), options->seed);
  if (key == "seed" && error == std::errc() && end == value.data() + value.size()) {
    return;
  }
  throw InputError({},
                   fmt::format("'{}': '{}' is not understood", url, option),
                   "a twin is twin:MACHINE.yaml, with ?truth=FILE, fidelity=fast or "
                   "physics, seed=NUMBER behind it, joined by &");
}

}  // namespace

TwinConfig MakeTwinConfig(const TwinOptions& options, bool only_measures) {
  const std::filesystem::path file =
      FindMachine(options.machine, "", {.file = options.machine});
  MachineFile read = ReadMachineWithTip(file);
  const bool only_by_rows =
      !read.machine.kind->axes_are_drives() && read.machine.kind->moves_along_axes();
  if (!only_measures || !only_by_rows) read = ReadMachineFile(file);
  std::vector<InjectedSpec> effects = read.effects;
  std::vector<SettingSpec> settings;
  if (!options.truth.empty()) {
    const TruthFile truth = ReadTruthFile(options.truth, read.machine);
    effects.insert(effects.end(), truth.effects.begin(), truth.effects.end());
    settings = truth.settings;
  }
  return {.machine = read.machine,
          .effects = DrawEffects(effects, options.seed, 0),
          .settings = DrawSettings(read.machine.settings, settings, options.seed, 0),
          .artefacts = options.artefacts.empty() ? UsualArtefacts(read.machine)
                                                 : options.artefacts,
          .instruments = options.instruments,
          .fidelity = options.fidelity == "fast" ? Fidelity::kFast : Fidelity::kPhysics,
          .seed = options.seed};
}

double ProbeSigma_mm(const Instruments& instruments) {
  const auto probe = instruments.find("probe");
  return probe == instruments.end() ? 0 : MmFromUm(probe->second.sigma_um);
}

TwinOptions TwinOptionsOf(const std::string& url) {
  std::string_view rest(url);
  rest.remove_prefix(kScheme.size());
  TwinOptions options;
  const std::size_t question = rest.find('?');
  options.machine = std::string(rest.substr(0, question));
  if (options.machine.empty()) ReadOption(url, "no machine", &options);
  if (question == std::string_view::npos) return options;
  rest.remove_prefix(question + 1);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    ReadOption(url, rest.substr(0, end), &options);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return options;
}

void ReadBenchFile(const std::string& file, TwinOptions* options) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  if (const auto artefacts = map.Optional("artefacts")) {
    options->artefacts = ReadArtefacts(artefacts->Map());
  }
  if (const auto instruments = map.Optional("instruments")) {
    options->instruments = ReadInstruments(instruments->Map());
  }
  map.NoMoreKeys();
  faults.ThrowIfAny();
}

std::vector<Artefact> UsualArtefacts(const Machine& machine) {
  return {
      {.id = "block",
       .type = ArtefactType::kBlock123,
       .at_mm = {machine.axis(Axis::kX).mid_mm(), machine.axis(Axis::kY).mid_mm(), 0},
       .size_mm = BlockLying(Axis::kX, kBlockSizes_mm[2])}};
}

}  // namespace caltwin
