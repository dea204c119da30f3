#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/blind/printer_score.h"
#include "tests/blind/triple_z/session.h"

namespace blind {

/// A cause that a triple-Z printer's truth may have.
struct TzCause {
  std::string name{};
  std::vector<std::string> axes{};
  double typical = 0.1;  ///< In the parameter's unit.
  /// Puts it into a truth, by `size`; `second` shapes it, or is a second number.
  void (*put)(const std::string& axis,
              double size,
              double second,
              TzTruth* truth) = nullptr;
  std::string parameter{}, second{};  ///< As reports call them.
  bool is_whole = false;              ///< There or not there: no size.
  bool is_positive = false;
  bool is_outside = false;
  std::vector<std::string> covariates{"x", "y", "z", "motor_a", "motor_b", "motor_c"};
};

const std::vector<TzCause>& TzCauses();

/// Rows, the printer as drawn, and what is true.
struct TzCase {
  PrinterRequest request{};
  TzPaper paper{};
  std::vector<TzStop> stops{};
  std::vector<double> values_mm{};
  double sigma_mm = 0.005;
  double stated = 1;  ///< Stated over true sigma.
  nlohmann::json truth{};
};

TzCase MakeTzCase(const PrinterRequest& request);

/// DATA.csv, machine.yaml and TRUTH.json.
void WriteTzCase(const TzCase& made, const std::string& folder);

}  // namespace blind
