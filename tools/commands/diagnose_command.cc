#include <iostream>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/diagnosis_json.h"
#include "scenarios/machine_file.h"
#include "sim/base/text_file.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

constexpr int kJsonIndent = 2;

struct Options {
  std::string file{};
  std::string machine{};
  std::string json{};
  std::string extend{};
  double min_effect_um = 0;
  std::uint64_t seed = 1;
};

int Run(const Options& options) {
  RowTable table = ReadRows(options.file);
  DataHeader header = HeaderOf(options.file);
  MachineFile file;
  if (!options.machine.empty()) {
    file = ReadMachineFile(FindMachine(options.machine, "", {.file = options.machine}));
  }
  const Observed observed(std::move(table),
                          std::move(header),
                          file.machine,
                          DrawEffects(file.effects, options.seed, 0));
  const Diagnosis diagnosis = Diagnose(
      observed,
      {.search = {.min_effect_um = options.min_effect_um, .seed = options.seed}});
  const std::string json =
      ToJson(
          diagnosis, options.extend, {.version = CALTWIN_VERSION, .seed = options.seed})
          .dump(kJsonIndent) +
      "\n";
  if (options.json == "-") {
    std::cout << json;
  } else if (!options.json.empty()) {
    WriteTextFile(options.json, json);
  }
  return kPassed;
}

}  // namespace

Action DeclareDiagnose(CLI::App* app) {
  const auto options = std::make_shared<Options>();
  app->add_option("data", options->file, "measured rows, DATA.csv")->required();
  app->add_option(
      "--machine", options->machine, "a name, a machine file, or an extension");
  app->add_option(
      "--json", options->json, "write the diagnosis as JSON; - for stdout alone");
  app->add_option("--extend", options->extend, "write the extended machine");
  app->add_option("--min-effect-um",
                  options->min_effect_um,
                  "smaller effects are of no interest")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--seed", options->seed, "of the bootstrap");
  return [options] {
    return Run(*options);
  };
}

}  // namespace caltwin
