#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "renders/document.h"
#include "renders/iso230_report.h"
#include "sim/base/text_file.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"
#include "tools/commands/iso230_text.h"
#include "tools/commands/spare_files.h"

namespace caltwin {
namespace {

constexpr double kLargestU_um = 1e5;

struct Iso230Asked {
  std::string file{};
  std::string axis{};
  std::string campaign{};
  std::string json{};
  std::string report{};
  Iso230Budget budget{};
};

/// The one measurement that file and options name. Throws InputError where they name
/// none or several.
Iso230Choice Choose(const RowTable& table, const Iso230Asked& options) {
  const std::vector<Iso230Choice> all = Iso230Choices(table);
  std::vector<Iso230Choice> chosen;
  std::vector<std::string> offered;
  for (const Iso230Choice& choice : all) {
    offered.push_back(
        fmt::format("--axis {} --campaign {}", Name(choice.axis), choice.campaign));
    const bool is_meant =
        (options.axis.empty() || options.axis == Name(choice.axis)) &&
        (options.campaign.empty() || options.campaign == choice.campaign);
    if (is_meant) chosen.push_back(choice);
  }
  if (chosen.size() == 1) return chosen.front();
  const Place place{.file = options.file};
  if (all.empty()) {
    throw InputError(
        place,
        "no positioning measurement stands here",
        "it takes rows of the kind position, measured along an axis at two "
        "or more of its positions");
  }
  throw InputError(
      place,
      chosen.empty()
          ? "no measurement here is the one chosen"
          : fmt::format("{} measurements stand here: choose one", chosen.size()),
      fmt::format("{}", fmt::join(offered, "; ")));
}

std::string CommandOf(const Iso230Asked& options, const Iso230Choice& choice) {
  std::string command = fmt::format("caltwin iso230 {} --axis {} --campaign {}",
                                    options.file,
                                    Name(choice.axis),
                                    choice.campaign);
  const auto add = [&](const char* name, double u_um) {
    if (u_um > 0) command += fmt::format(" {} {:g}", name, u_um);
  };
  add("--u-alignment-um", options.budget.alignment_u_um);
  add("--u-temperature-um", options.budget.temperature_u_um);
  add("--u-environment-um", options.budget.environment_u_um);
  return command + " --report " + options.report;
}

int RunIso230(const Iso230Asked& options) {
  RefuseOverwriting(RowsAndHeader("the data", options.file),
                    {{"--json", options.json}});
  const RowTable table = ReadRows(options.file);
  const DataHeader header = HeaderOf(options.file);
  const Iso230Choice choice = Choose(table, options);
  for (const auto& remarks :
       {table.remarks, header.remarks, Unexplained(table, header)}) {
    for (const std::string& remark : remarks) std::cerr << "note: " << remark << "\n";
  }
  const Iso230Report report = MakeIso230Report(table, header, choice, options.budget);
  if (options.json != "-") std::cout << Iso230Text(report);
  if (!options.report.empty()) {
    WriteDocument(Iso230Document(report.sheet,
                                 {.data = options.file,
                                  .text = Iso230Text(report),
                                  .command = CommandOf(options, choice)}),
                  options.report);
    if (options.json != "-") {
      std::cout << "\nreport: " << options.report << "/index.html\n";
    }
  }
  if (options.json.empty()) return kPassed;
  const std::string json = Iso230Json(report).dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << json;
  } else {
    WriteTextFile(options.json, json);
  }
  return kPassed;
}

}  // namespace

Action DeclareIso230(CLI::App* app) {
  const auto options = std::make_shared<Iso230Asked>();
  app->add_option("data", options->file, "measured rows, DATA.csv")->required();
  app->add_option("--axis", options->axis, "which axis, where there are several")
      ->check(CLI::IsMember({"x", "y", "z"}));
  app->add_option("--campaign", options->campaign, "which campaign");
  app->add_option(
      "--json", options->json, "write the sheet as JSON; - for stdout alone");
  app->add_option("--report", options->report, "write an HTML report to this folder");
  const auto add_uncertainty = [app](const char* name, double* u_um, const char* what) {
    app->add_option(name, *u_um, what)->check(CLI::Range(0.0, kLargestU_um));
  };
  add_uncertainty("--u-alignment-um",
                  &options->budget.alignment_u_um,
                  "standard uncertainty from the alignment, over the travel");
  add_uncertainty("--u-temperature-um",
                  &options->budget.temperature_u_um,
                  "the same from expansion not corrected for");
  add_uncertainty("--u-environment-um",
                  &options->budget.environment_u_um,
                  "standard uncertainty of a reading from drift of the surroundings");
  return [options] {
    return RunIso230(*options);
  };
}

}  // namespace caltwin
