#include "calibration/diagnosis/controller.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

struct Named {
  std::string_view word, full;
  ControllerKind controller;
};
constexpr std::array kControllers = {
    Named{"rrf", "RepRapFirmware", ControllerKind::kRrf},
    Named{"klipper", "Klipper", ControllerKind::kKlipper},
    Named{"marlin", "Marlin", ControllerKind::kMarlin},
    Named{"linuxcnc", "LinuxCNC", ControllerKind::kLinuxCnc}};

}  // namespace

std::string_view FullName(ControllerKind controller) {
  return kControllers[static_cast<std::size_t>(controller)].full;
}

bool IsSetByGcode(ControllerKind controller) {
  return controller == ControllerKind::kRrf || controller == ControllerKind::kMarlin;
}

ControllerKind ControllerNamed(std::string_view word) {
  const auto found = std::ranges::find(kControllers, word, &Named::word);
  if (found != kControllers.end()) return found->controller;
  throw InputError({.file = "--for"},
                   fmt::format("'{}' is no controller known here", word),
                   "rrf, klipper, marlin or linuxcnc");
}

}  // namespace caltwin
