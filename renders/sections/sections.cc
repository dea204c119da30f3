#include "renders/sections/sections.h"

#include <array>

namespace caltwin {
namespace {

constexpr std::array<Section, 10> kSections = {{
    {"results", "Results", VerdictSection},
    {"meaning", "What it means", MeaningSection},
    {"pictures", "Before and after", PicturesSection},
    {"playback", "The run, played back", PlaybackSection},
    {"position", "Where the tool ends up", PositionSection},
    {"uncertainty", "How sure it is", UncertaintySection},
    {"steps", "What was done, in order", StepsSection},
    {"convergence", "How the settings converged", ConvergenceSection},
    {"readings", "The readings", ReadingsSection},
    {"provenance", "How to make this report again", ProvenanceSection},
}};

}  // namespace

std::span<const Section> AllSections() {
  return kSections;
}

}  // namespace caltwin
