#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/measure/instrument.h"
#include "tests/fuzz/fuzz.h"

// A machine file, and the parts of a scenario that lower layers read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) {
    Faults faults;
    YamlMap map = ReadYamlText(text, "m.yaml", &faults);
    if (const auto artefacts = map.Optional("artefacts")) {
      ReadArtefacts(artefacts->Map());
    }
    if (const auto instruments = map.Optional("instruments")) {
      ReadInstruments(instruments->Map());
    }
    if (const auto number = map.Optional("number")) number->NumberOrDistribution();
    ReadMachine(&map);
    faults.ThrowIfAny();
  });
}
