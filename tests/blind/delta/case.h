#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/blind/delta/session.h"
#include "tests/blind/printer_score.h"

namespace blind {

using DeltaRequest = PrinterRequest;

/// A cause that a delta's truth may have.
struct DeltaCause {
  std::string name{};
  std::vector<std::string> axes{};
  double typical = 0.1;  ///< In the parameter's unit.
  /// Puts it into a truth, by `size`; a second number where it has two.
  void (*put)(const std::string& axis,
              double size,
              double second,
              DeltaTruth* truth) = nullptr;
  std::string parameter{}, second{};  ///< As reports call them.
  std::vector<std::string> covariates{};
  bool is_outside = false;
};

const std::vector<DeltaCause>& DeltaCauses();

/// Rows, the machine as drawn, and what is true.
struct DeltaCase {
  DeltaRequest request{};
  DeltaPaper paper{};
  std::vector<DeltaStop> stops{};
  std::vector<double> values_mm{};
  double sigma_mm = 0.005;
  double stated = 1;  ///< Stated over true sigma.
  nlohmann::json truth{};
};

DeltaCase MakeDeltaCase(const DeltaRequest& request);

/// DATA.csv, machine.yaml and TRUTH.json.
void WriteDeltaCase(const DeltaCase& made, const std::string& folder);

}  // namespace blind
