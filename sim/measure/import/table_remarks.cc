#include "sim/measure/import/table_remarks.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/table_derived.h"

namespace caltwin {
namespace {

bool HasAnyOf(const std::string& lower, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words, [&](std::string_view word) {
    return lower.find(word) != std::string::npos;
  });
}

// "Everything in inches", and no word of millimetres.
bool SaysInches(const std::string& lower) {
  constexpr std::array<std::string_view, 8> kWords = {"thing in inch",
                                                      "all in inch",
                                                      "values in inch",
                                                      "numbers in inch",
                                                      "readings in inch",
                                                      "units are inch",
                                                      "unit: inch",
                                                      "units: inch"};
  const std::vector<std::string> tokens = TokensOf(lower);
  constexpr std::array<std::string_view, 6> kMetric = {
      "mm", "metric", "millimetre", "millimetres", "millimeter", "millimeters"};
  const bool is_metric = std::ranges::any_of(kMetric, [&](std::string_view word) {
    return std::ranges::find(tokens, word) != tokens.end();
  });
  const bool is_of_another = lower.find("other machine") != std::string::npos;
  return !is_metric && !is_of_another &&
         std::ranges::any_of(kWords, [&](std::string_view words) {
           return lower.find(words) != std::string::npos;
         });
}

// "lost motion = from plus less from minus": words behind it, and no figure.
bool DefinesLostMotion(const std::string& lower) {
  for (const std::string_view words : {"lost motion =", "lost motion:", "backlash ="}) {
    const std::size_t at = lower.find(words);
    if (at == std::string::npos) continue;
    const std::size_t next = lower.find_first_not_of(" \t", at + words.size());
    const bool is_word =
        next != std::string::npos && lower[next] >= 'a' && lower[next] <= 'z';
    if (is_word) return true;
  }
  return false;
}

}  // namespace

TableRemarks RemarksIn(const std::string& text) {
  const std::string lower = Lowered(text);
  return {.step_mm = CountedStep_mm(text),
          .is_homed = HasAnyOf(lower,
                               {"x g28",
                                "after g28",
                                "after each g28",
                                "after every g28",
                                "after each homing",
                                "after every homing",
                                "homed before each"}),
          .are_distances = HasAnyOf(lower, {"distance"}),
          .define_lost_motion = DefinesLostMotion(lower),
          .are_in_inches = SaysInches(lower)};
}

}  // namespace caltwin
