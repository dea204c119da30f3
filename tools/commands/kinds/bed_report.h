#pragma once

#include <string>

#include "tools/commands/kinds/bed_store.h"

namespace caltwin {

/// What is known of a bed, as a page that loads nothing.
std::string BedReportHtml(const std::string& machine,
                          const BedStore& store,
                          const Pivots<double>& pivots_mm);

}  // namespace caltwin
