// blind_generate: writes one case of hidden truth.

#include <cstdint>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tests/blind/case.h"
#include "tests/blind/physics_case.h"

namespace {

void List() {
  for (const auto* list : {&blind::LibraryCauses(), &blind::OutsideCauses()}) {
    for (const blind::Cause& cause : *list) {
      for (const std::string& axis : cause.axes) {
        std::cout << fmt::format("{} {}\n", cause.name, axis.empty() ? "-" : axis);
      }
    }
  }
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Hides a cause in measured rows: writes DATA.csv, DATA.yaml, machine.yaml and "
      "the "
      "sealed TRUTH.json.");
  blind::CaseRequest request;
  std::vector<std::string> causes;
  std::vector<std::string> axes;
  std::vector<double> sigmas;
  std::string folder;
  blind::Simulator simulator;
  bool list = false;
  app.add_option("--kind", request.kind, "null, single, pair, outside or loop")
      ->check(CLI::IsMember({"null", "single", "pair", "outside", "loop"}));
  app.add_option(
      "--cause", causes, "what to hide; drawn if left out; twice for a pair");
  app.add_option("--axis", axes, "on which axis, '-' where it has none, or any");
  app.add_option("--sigma", sigmas, "how large it shall show [sigma of one reading]");
  app.add_option("--seed", request.seed, "everything else is drawn from it");
  app.add_option("--out", folder, "folder to write");
  app.add_option("--max-rows", request.max_rows, "no other campaigns beyond this");
  app.add_flag("--clean", request.clean, "no outliers, wander, missing columns ...");
  app.add_flag("--physics", request.physics, "MuJoCo performs an edited model");
  app.add_option("--binary", simulator.binary, "the caltwin that does so");
  app.add_flag(
      "--keep-built", simulator.keep_built, "leaves the machine as built there");
  app.add_option("--model", simulator.model, "the model.xml to edit");
  app.add_flag("--list", list, "lists causes and axes");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    List();
    return 0;
  }
  if (folder.empty()) throw std::invalid_argument("--out FOLDER is needed");
  if (!sigmas.empty()) request.sigma = sigmas.front();
  for (std::size_t i = 0; i < causes.size(); ++i) {
    const std::string axis = i < axes.size() ? axes[i] : "any";
    request.hidden.push_back({causes[i],
                              axis == "-" ? "" : axis,
                              i < sigmas.size() ? sigmas[i] : request.sigma});
  }
  blind::Case made;
  if (request.physics) {
    if (simulator.binary.empty())
      throw std::invalid_argument("--physics needs --binary");
    simulator.folder = folder;
    blind::MakePhysicsCase(simulator, request, &made);
  } else {
    blind::MakeCase(request, &made);
  }
  blind::WriteCase(made, folder);
  blind::WriteTruth(made, folder);
  std::cout << fmt::format("{}: {} rows\n", folder, made.readings.size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "blind_generate: " << error.what() << "\n";
    return 2;
  }
}
