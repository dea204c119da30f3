#include "sim/measure/import/told_stories.h"

#include <array>
#include <utility>

namespace caltwin {

Imported ToldOf(std::string recognised,
                std::string open,
                std::string instrument,
                std::string next) {
  Imported told{.recognised = {std::move(recognised)},
                .next_instrument = std::move(instrument),
                .next_sentence = std::move(next)};
  told.notes.push_back(
      {.kind = FileNote::Kind::kOpen, .what = "cause", .sentence = std::move(open)});
  return told;
}

std::optional<Imported> ToldStoryIn(const std::string& text) {
  constexpr std::array kStories = {TemperatureTablesIn,
                                   StalledFitIn,
                                   SizesByRunIn,
                                   SpeedsByPulsesIn,
                                   TwoSidesIn,
                                   RodTrimsIn,
                                   WidthsAndDistancesIn,
                                   FadedConstantIn,
                                   LeastThereAndBackIn};
  for (const auto story : kStories) {
    if (auto told = story(text)) return told;
  }
  return std::nullopt;
}

}  // namespace caltwin
