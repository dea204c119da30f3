#include "sim/measure/import/told_stories.h"

#include <array>

namespace caltwin {

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
