#pragma once

#include <string>

#include "sim/machine/machine.h"

namespace caltwin {

/// A machine file with a comment at every key, filled with the sizes of `like`. Reading
/// it gives `like` again, but for name and model (none: a plain one is built from the
/// file).
std::string StarterText(const Machine& like, const std::string& name);

/// The same of any other kind: the file of such a machine, with its comments, under
/// another name and without a model of its own.
std::string StarterLike(const std::string& text, const std::string& name);

}  // namespace caltwin
