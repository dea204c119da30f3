#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace caltwin {

/// A public fault and its cure, on one machine.
struct Exhibit {
  std::string fault{};
  std::string source{};
  std::filesystem::path as_published{}, cured{};  ///< Scenarios.
  /// What is compared: `judged`, the figure that its kind of machine is calibrated for
  /// (RunResult::figure_after), or a parameter's error.
  std::string figure = "judged";
  /// A key of the scenarios that the cure itself is, such as a clean nozzle; else what
  /// the machine is stands alike in both.
  std::string cure_changes{};
  std::string needs{};  ///< klipper or linuxcnc: a program that runs it; empty: none.
};

/// Reads scenarios/museum/exhibits.yaml. Throws InputError.
std::vector<Exhibit> ReadExhibits(const std::filesystem::path& file);

/// What one of the two left.
struct ShownRun {
  std::string outcome{};
  std::optional<double> before{}, after{};  ///< Magnitudes, in `unit`.
  bool passed = false;                      ///< It met what the scenario expects of it.
};

struct ExhibitShown {
  Exhibit exhibit{};
  std::string unit = "mm";
  ShownRun fault{}, cure{};
  std::string not_run{};  ///< Why not; empty: it was.
};

/// Runs all of them; `progress` hears what is on. Ends early where
/// InterruptRequested().
std::vector<ExhibitShown> RunMuseum(
    const std::vector<Exhibit>& exhibits,
    const std::function<void(const std::string&)>& progress);

std::string MuseumText(const std::vector<ExhibitShown>& shown);
nlohmann::ordered_json MuseumJson(const std::vector<ExhibitShown>& shown);
/// Whether each that ran met what its two scenarios expect.
bool MuseumPassed(const std::vector<ExhibitShown>& shown);

}  // namespace caltwin
