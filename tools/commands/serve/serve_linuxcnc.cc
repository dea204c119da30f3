#include "tools/commands/serve/serve_linuxcnc.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/controllers/linuxcnc/plant_page.h"

namespace caltwin {
namespace {

// A name and no path: the page is a file for everybody on this computer.
void RequireName(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  const bool is_name = !name.empty() && name.size() <= kLongest &&
                       std::ranges::all_of(name, [](unsigned char letter) {
                         return std::isalnum(letter) != 0 || letter == '_';
                       });
  if (is_name) return;
  throw InputError({.file = "--linuxcnc"},
                   fmt::format("'{}' is no name for a page", name),
                   "letters, digits and _ only, as in loadrt caltwin page=NAME");
}

}  // namespace

void ServeLinuxCnc(Board* board,
                   const std::string& name,
                   const std::atomic<bool>* stop,
                   const std::function<void()>& ready) {
  RequireName(name);
  // LinuxCNC takes a machine that is silent for so long for dead.
  constexpr std::chrono::milliseconds kPatience(5000), kGlance(200);
  linuxcnc::Joints joints(board);
  linuxcnc::PlantPage page(
      std::filesystem::path("/dev/shm") / name, &joints, kPatience);
  if (ready) ready();
  while (!*stop) page.Turn(kGlance);
}

}  // namespace caltwin
