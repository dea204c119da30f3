#pragma once

#include <string>

#include "sim/measure/data_header.h"

namespace caltwin {

/// Whether the header knows how large an artefact is: one without sizes, a `post` or
/// `datums` has faces that nobody measured; each has a place of its own.
inline bool IsDrawn(const DataHeader& header, const std::string& artefact) {
  const auto found = header.artefacts.find(artefact);
  return found != header.artefacts.end() && !found->second.sizes_mm.empty() &&
         found->second.type != "post" && found->second.type != "datums";
}

}  // namespace caltwin
