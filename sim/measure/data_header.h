#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/yaml.h"
#include "sim/measure/instrument.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Firmware settings in force while rows were measured; by axis, tower or screw.
struct SettingsInForce {
  /// What a setting may be, in every file that states one.
  static constexpr Bounds kSteps_per_mm{1e-3, 1e7};
  static constexpr Bounds kBacklash_mm{0, 10};

  std::map<std::string, double> steps_per_mm{};
  std::map<std::string, double> backlash_mm{};
  std::map<std::string, double> probe_deflection_mm{};
  std::optional<double> tip_radius_mm{};
  std::optional<double> switch_offset_mm{};  ///< Of Klipper's [z_calibration].
};

/// What is known of one campaign: its instrument, and the plan it followed.
struct CampaignHeader {
  std::string instrument{};  ///< Id in `instruments`; empty: not said.
  std::string plan{};        ///< Kind of the plan ("iso230"); empty: not said.
  /// The plan's options as written ("axis" -> "x", "dwell_s" -> "2").
  std::map<std::string, std::string> options{};
};

/// What was touched or gauged, as certified.
struct CertifiedArtefact {
  std::string type{};
  std::vector<double> sizes_mm{};
  double u_um = 0;  ///< Standard uncertainty of each size.
  std::optional<double> expansion_per_k{};
};

/// What drives an axis: the periods that errors may have.
struct Transmission {
  std::optional<double> lead_mm{};
  std::optional<double> pulley_mm_per_rev{};
  std::optional<double> full_steps_per_mm{};
};

/// The file that explains a file of rows: DATA.yaml beside DATA.csv. Every key is
/// optional.
struct DataHeader {
  std::string machine{};  ///< A name or a path, as written.
  std::map<std::string, SettingsInForce> settings{};
  Instruments instruments{};
  std::map<std::string, CampaignHeader> campaigns{};
  std::map<std::string, CertifiedArtefact> artefacts{};
  std::map<std::string, Transmission> transmission{};
  std::optional<double> tip_radius_mm{};  ///< The configured one.
  /// Free words nobody here knows (kinds of instruments, plans, artefacts), and what
  /// the rows name and the header does not: told, never refused.
  std::vector<std::string> remarks{};
};

/// Reads a header; throws InputError with every fault.
DataHeader ReadDataHeader(const std::filesystem::path& file);
DataHeader ParseDataHeader(const std::string& text, const std::string& name);

/// The header of a file of rows: that of the same name ending in .yaml, empty where
/// there is none.
DataHeader HeaderOf(const std::filesystem::path& rows_file);

/// The header as a file's text; ParseDataHeader of it gives the same.
std::string DataHeaderText(const DataHeader& header);
void WriteDataHeader(const std::filesystem::path& file, const DataHeader& header);

/// What the rows name and the header does not explain, one sentence each. Nothing where
/// the header says nothing of that sort at all.
std::vector<std::string> Unexplained(const RowTable& table, const DataHeader& header);

}  // namespace caltwin
