#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "scenarios/study/run.h"
#include "scenarios/study/study.h"
#include "scenarios/study/trials_csv.h"
#include "tests/base/temp_folder.h"

namespace caltwin {

/// A study of one calibration of a gap. Its files in a folder of its own, empty at the
/// beginning.
class StudyTest : public ::testing::Test {
 protected:
  StudyTest() {
    Write("gap.yaml",
          "machine: gantry_router\n"
          "fidelity: fast\n"
          "effects: {backlash.x: {gap_mm: 0.05}}\n"
          "instruments: {probe: {sigma_um: 1}}\n"
          "artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: x}}\n"
          "calibrate:\n"
          "  - next_cluster_backlash: {axis: x, variant: corrected, repeats: 3}\n");
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  Study Read(const std::string& keys) const {
    Write("study.yaml", "study:\n  scenarios: [gap.yaml]\n" + keys);
    return ReadStudy(folder_ / "study.yaml");
  }
  std::string FaultOf(const std::string& keys) const {
    try {
      Read(keys);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  TempFolder folder_{};
};

inline constexpr const char* kVaried =
    "  vary: {backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 2}}}\n"
    "  trials: 12\n";

inline std::string CsvOf(const Study& study,
                         const std::filesystem::path& folder,
                         int workers) {
  StudyStore store(folder, study, /*may_resume=*/false);
  RunStudy(study, {.workers = workers}, &store);
  return TrialsCsv(study, store);
}

}  // namespace caltwin
