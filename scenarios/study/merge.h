#pragma once

#include <filesystem>
#include <vector>

#include "scenarios/study/store.h"

namespace caltwin {

/// Copies what the parts of a study (`--shard I/N`) hold into `whole`. Trials that two
/// parts hold are the same and copied once. Throws InputError where a folder holds no
/// part of this study or parts are missing: then nothing was copied.
void MergeParts(const Study& study,
                const std::vector<std::filesystem::path>& folders,
                StudyStore* whole);

}  // namespace caltwin
