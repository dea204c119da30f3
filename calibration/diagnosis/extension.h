#pragma once

#include <string>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// What an extended machine stands on.
struct ExtensionBase {
  std::string extends{};  ///< As the extension writes it: a name, or a path beside it.
  std::string extends_sha256{};
  std::string data_sha256{};
};

/// What tells one finding from another: `cause.axis`, of a table with the covariates it
/// stands over, `unknown.x{x,y}`.
std::string KeyOf(const Finding& finding);

/// The findings as a machine file (docs/machine-file.md, "Extensions"): named causes
/// under `effects`, each with the standard deviation of every parameter, its
/// probability and its rivals; tables under `unknown`; what it rests on under
/// `evidence`. A machine that is an extension itself is extended: its effects stay.
std::string ExtensionText(const Diagnosis& diagnosis, const ExtensionBase& base);

}  // namespace caltwin
