#include "sim/controllers/linuxcnc/own_ini.h"
#include "tests/fuzz/fuzz.h"

// A person's INI file of LinuxCNC: the machine that it is for, and the same file with
// caltwin for a card, in which one HAL file is left.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) {
    linuxcnc::MachineFileOfIni(text, "m.ini", "m");
    linuxcnc::MachineText drawn{.name = "m", .coordinates = "XYZY"};
    for (int motor = 0; motor < 4; ++motor) drawn.joints.push_back({.motor = motor});
    const linuxcnc::OwnIni own = linuxcnc::WithTwin(text, drawn);
    if (linuxcnc::IniValue(own.ini, "HAL", "HALFILE") != "machine.hal") std::abort();
    if (linuxcnc::IniKeys(own.ini, "HAL").size() != 1) std::abort();
  });
}
