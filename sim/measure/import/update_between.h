#pragma once

#include <string_view>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Two maps of the same places and of the same shape, one a constant higher: their zero
/// differs, and no bed. Told where the text says that the firmware was updated or its
/// settings reset: then it was that.
class UpdateBetween {
 public:
  void Take(std::string_view line, int number);
  void Tell(Imported* imported) const;

 private:
  int line_ = 0;  ///< That tells of an update or of settings reset; 0: none does.
};

}  // namespace caltwin
