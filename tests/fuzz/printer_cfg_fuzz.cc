#include "sim/measure/import/kinds/printer_of_cfg.h"
#include "sim/measure/import/printer_cfg_adapted.h"
#include "sim/measure/import/printer_cfg_text.h"
#include "tests/fuzz/fuzz.h"

// A person's printer.cfg: put on the twin's pins none of its own is left at a motor
// that the twin has; and the machine that it is for.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace caltwin;
  return Try(data, size, [](const std::string& text) {
    const std::string drawn =
        "[mcu]\nserial: /tmp/x\n[stepper_x]\nstep_pin: X_STEP\n[stepper_z]\nstep_pin: "
        "Z_STEP\nposition_min: -5\n[probe]\nz_offset: 1\n";
    const PrinterCfg adapted(AdaptedToTwin(text, drawn).text, "adapted");
    for (const char* const motor : {"stepper_x", "stepper_z"}) {
      const CfgSetting* const pin = adapted.Find(motor, "step_pin");
      if (pin != nullptr && !pin->value.text.ends_with("_STEP")) std::abort();
    }
    PlaceOfComplaint(text, text, "p");
    // What is added is found again, and all else is as it was.
    std::string added = WithAdded(text, "[a]\nb: 1\n");
    if (added.find("[a]\nb: 1\n") == std::string::npos) std::abort();
    MachineFileOf(PrinterCfg(text, "p"), "m");
  });
}
