#pragma once

#include <string>

#include "calibration/estimate/iso230.h"
#include "renders/document.h"

namespace caltwin {

/// What a report of an ISO 230-2 sheet says beside it.
struct Iso230Notes {
  std::string data{};     ///< The file of rows, as given.
  std::string text{};     ///< The sheet as printed.
  std::string command{};  ///< Makes this report again.
};

/// The sheet as a document: A, R and B in a sentence, the errors of both directions
/// over the travel, every symbol with its U.
Document Iso230Document(const Iso230Sheet& sheet, const Iso230Notes& notes);

}  // namespace caltwin
