#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/grbl/controller.h"
#include "tests/firmware/rigid_plant.h"

// A grbl that hears anything: it answers each line once, in text, and stands somewhere.

namespace {

using namespace caltwin;

void Require(bool holds) {
  if (!holds) std::abort();
}

bool EndsLine(const std::string& said) {
  return said == "ok" || said.starts_with("error:");
}

void CheckAnswer(const std::vector<std::string>& said) {
  // None: only a reset helps. Behind an ok may stand the greeting.
  Require(std::ranges::count_if(said, EndsLine) <= 1);
  for (const std::string& line : said) {
    Require(line.find('\n') == std::string::npos &&
            line.find("nan") == std::string::npos);
  }
}

// M0 waits for another thread.
bool Pauses(std::string_view line) {
  std::string text = grbl::Stripped(line);
  if (text.starts_with("$N"))
    text.erase(0, std::min(text.find('='), text.size() - 1) + 1);
  try {
    return grbl::ReadBlock(text, {}).program == 0;
  } catch (const grbl::LineError&) {
    return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Machine machine = TestMachine();
  RigidPlant plant(machine);
  Pace pace;
  PacedPlant paced(&plant, &pace);
  grbl::Controller controller(
      machine, machine.settings, &paced, &pace, Motors::Zero(3));
  std::string_view left(reinterpret_cast<const char*>(data), size);
  constexpr int kMostLines = 40;
  for (int i = 0; i < kMostLines && !left.empty(); ++i) {
    const std::size_t end = std::min(left.find('\n'), left.size());
    const std::string_view line = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    if (Pauses(line)) continue;
    if (!line.empty() && line.front() == '\x18') {
      pace.Stop();
      CheckAnswer(controller.Reset(controller.InMotion()));
      continue;
    }
    const auto said = controller.Execute(line);
    CheckAnswer(said);
    if (pace.is_held()) pace.Resume();
    plant.segments.clear();
    const std::string status = controller.Status(128);
    Require(status.empty() || (status.front() == '<' && status.back() == '>'));
    Require(controller.machine_mm().allFinite());
  }
  return 0;
}
