#pragma once

#include <filesystem>
#include <string>

#include "scenarios/study/store.h"

namespace caltwin {

/// `trials.csv`: a line a trial and contender, in their order; the same bytes whoever
/// ran them in whatever order.
std::string TrialsCsv(const Study& study, const StudyStore& store);

/// Writes it beside its final name, line by line, and renames. Throws InputError where
/// that cannot be done, on a full disk too.
void WriteTrialsCsv(const Study& study,
                    const StudyStore& store,
                    const std::filesystem::path& file);

}  // namespace caltwin
