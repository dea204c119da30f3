#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/diagnosis/closed_loop.h"
#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/diagnosis_text.h"
#include "calibration/diagnosis/replay.h"
#include "calibration/diagnosis/volumetric.h"
#include "tools/commands/believed_machine.h"
#include "tools/commands/measured_data.h"

namespace caltwin {

/// What `caltwin diagnose` was asked.
struct DiagnoseAsked {
  std::string file{};
  std::string machine{};
  std::string json{};
  std::string report{};
  std::string extend{};
  std::string correction{};
  std::string controller{};
  std::string before{};
  std::string closed_loop{};
  std::string record{};
  std::string replay = "physics";
  bool must_replay = false;  ///< The person said so, however many rows there are.
  double min_effect_um = 0;
  std::uint64_t seed = 1;
  ImportOptions import{};  ///< Of a file that is no rows yet.
  double step_mm = 0;
};

/// Rows held against a machine, and the answer.
struct Judged {
  Observed observed;
  Diagnosis diagnosis{};
  Replay replay{};
  std::optional<VolumetricGain> volumetric{};
  std::vector<LoopRound> rounds{};  ///< Of a closed loop.
};

/// Empty where there is no file.
std::string Sha256OfFile(const std::filesystem::path& file);

/// The command that gives the same answer again.
std::string CommandOf(const DiagnoseAsked& options);

/// Where the machine goes that nobody described and that is to be extended: beside the
/// extension, "x.machine.yaml" of "x.ext.yaml". Empty where no extension is asked for.
std::filesystem::path FileOfAssumed(const DiagnoseAsked& options);

/// Writes the extended machine where something was found; the name of what was written.
std::string WriteExtension(const DiagnoseAsked& options,
                           const Believed& believed,
                           const Diagnosis& diagnosis);

/// @name What was asked for, and nothing where it was not
void WriteCorrection(const DiagnoseAsked& options, const Judged& judged);
void WriteJson(const DiagnoseAsked& options,
               const Believed& believed,
               const Judged& judged,
               const TextNotes& text_notes,
               const std::string& extended);
void WriteReportOf(const DiagnoseAsked& options,
                   const Judged& judged,
                   const TextNotes& text_notes);

}  // namespace caltwin
