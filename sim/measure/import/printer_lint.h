#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a Klipper configuration that measures nothing, for what in it contradicts
/// itself: towers of a delta that step differently, a z_offset of the wrong sign under
/// a saved calibration, motors of one axis with other microsteps.
Imported ReadPrinterCfg(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);

/// The same notes of any printer.cfg.
std::vector<FileNote> NotesOfPrinterCfg(const std::string& text,
                                        const std::string& name);

/// Reads the lengths of a square in a Configuration.h of Marlin: XY_DIAG_AC,
/// XY_DIAG_BD, XY_SIDE_AD and their like, as lengths; what overrides or spoils them is
/// a note.
Imported ReadMarlinConfig(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

}  // namespace caltwin
