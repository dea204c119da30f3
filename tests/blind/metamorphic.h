#pragma once

#include <string>
#include <vector>

#include "tests/blind/diagnosis.h"
#include "tests/blind/table.h"

namespace blind {

/// A change of the data after which the answer is known from the answer before.
enum class Change {
  kShuffleRows,      ///< Their order in the file means nothing.
  kReorderColumns,   ///< Nor does that of the columns; with comments, CRLF.
  kSwapXAndY,        ///< The machine in a mirror: x causes become y causes.
  kDropTheCampaign,  ///< That shows the cause: none, or a set that holds it.
};

/// What became of one change.
struct ChangeResult {
  std::string what{};
  bool ran = false, held = false;
};

/// The rows as a mirror shows them: x and y exchanged, turns the other way round.
TextTable Mirrored(TextTable table);

/// Names a cause's axis as the mirror shows it.
std::string MirroredAxis(const std::string& axis);

/// Examines a case of one cause along x or y, then each change of it.
std::vector<ChangeResult> ExamineChanges(const Diagnoser& diagnoser,
                                         const CaseRequest& request);

}  // namespace blind
