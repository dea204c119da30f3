#pragma once

#include <span>
#include <string_view>

namespace caltwin {

/// A word of scenario files and results and what it means: what `caltwin explain` says
/// of units, keys and outcomes.
struct Word {
  std::string_view name;
  std::string_view meaning;
};

std::span<const Word> ScenarioKeys();  ///< Dotted, as they nest.
std::span<const Word> StudyKeys();     ///< Of study files.
std::span<const Word> OutcomeWords();
std::span<const Word> UnitWords();
std::span<const Word> UncertaintyWords();  ///< How sure a result is (JCGM 100).

}  // namespace caltwin
