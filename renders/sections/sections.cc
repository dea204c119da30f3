#include "renders/sections/sections.h"

#include <array>

namespace caltwin {
namespace {

constexpr std::array<Section, 10> kSections = {{
    {"verdict", "What came out", VerdictSection},
    {"uncertainty", "How sure it is", UncertaintySection},
    {"pictures", "Before and after", PicturesSection},
    {"position", "Where the tool ends up", PositionSection},
    {"steps", "What was done, in order", StepsSection},
    {"convergence", "How the settings converged", ConvergenceSection},
    {"readings", "The readings", ReadingsSection},
    {"observability", "What could not be told apart", ObservabilitySection},
    {"messages", "Messages", MessagesSection},
    {"provenance", "How to make this report again", ProvenanceSection},
}};

}  // namespace

std::span<const Section> AllSections() {
  return kSections;
}

}  // namespace caltwin
