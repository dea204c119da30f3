#pragma once

#include <string>
#include <vector>

#include "renders/document.h"
#include "scenarios/contender.h"

namespace caltwin {

/// What a report of a comparison says beside the standings.
struct CompareNotes {
  std::string kind{};     ///< What is calibrated: "delta".
  std::string text{};     ///< The standings as the terminal shows them.
  std::string command{};  ///< Makes this report again.
};

/// The comparison as a document: which procedure leaves least in a sentence, the error
/// of each with its interval, the table as printed.
Document CompareDocument(const std::vector<Contender>& contenders,
                         const CompareNotes& notes);

}  // namespace caltwin
