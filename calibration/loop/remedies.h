#pragma once

#include <string>

namespace caltwin {

/// The four troubles of the NeXT guide, section 4.4.
enum class Trouble { kNoTrigger, kInconsistent, kUnreasonable, kWorse };

/// What the guide advises, as one message for a person: the trouble, then its remedies.
std::string RemedyFor(Trouble trouble);

}  // namespace caltwin
