#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/diagnosis_text.h"
#include "calibration/diagnosis/pictures_data.h"

namespace caltwin {

/// What a report of a diagnosis says beside it.
struct DiagnosisReportNotes {
  std::string data{};     ///< The file of rows, as given.
  std::string text{};     ///< DiagnosisText, as the terminal shows it.
  TextNotes words{};      ///< What its summary needs.
  std::string command{};  ///< Without `--report`; printed under every picture.
  std::string folder{};   ///< As given to `--report`.
  std::string version{};
  std::uint64_t seed = 1;
};

/// The report as one HTML document that loads nothing. The same diagnosis gives the
/// same bytes. Everything that comes from files is escaped.
std::string DiagnosisReportHtml(const Diagnosis& diagnosis,
                                const PicturesData& data,
                                const DiagnosisReportNotes& notes);

/// Writes `folder/index.html`, each picture as `folder/NAME.svg`, and every number
/// drawn as `folder/pictures.json`. Throws InputError where that cannot be done.
void WriteDiagnosisReport(const Diagnosis& diagnosis,
                          const PicturesData& data,
                          const DiagnosisReportNotes& notes,
                          const std::filesystem::path& folder);

}  // namespace caltwin
