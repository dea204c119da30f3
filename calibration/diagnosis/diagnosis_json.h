#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// Where a diagnosis came from, so that its figures can be made again.
struct Provenance {
  std::string data_sha256{};
  std::string machine_sha256{};  ///< Empty: assumed from the columns.
  std::string version{};
  std::uint64_t seed = 1;
  std::string command{};
};

/// `diagnose --json`, docs/data-format.md. `extended_model`: the file's name, empty
/// where none was written.
nlohmann::ordered_json ToJson(const Diagnosis& diagnosis,
                              const std::string& extended_model,
                              const Provenance& provenance);

}  // namespace caltwin
