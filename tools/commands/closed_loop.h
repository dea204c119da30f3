#pragma once

#include <filesystem>
#include <string>

#include "calibration/diagnosis/closed_loop.h"
#include "sim/kinds/perform.h"

namespace caltwin {

/// A machine at the end of a url that can measure campaigns, and what it tells of
/// itself. The rest (how it is truly built) stays inside.
struct MachineUnderTest {
  std::string machine{};  ///< Name or file of the machine as drawn.
  SettingsInForce settings{};
  Measurer measure{};
};

/// Of `twin:M.yaml?truth=T.yaml&fidelity=fast&seed=7`. A real machine is refused: no
/// controller can lay a plate on its table or read a laser. Throws InputError.
MachineUnderTest MachineAt(const std::string& url);

/// Throws InputError unless there are rows or a machine to measure them, and what is
/// measured can be recorded there.
void CheckLoop(const std::string& data,
               const std::string& url,
               const std::string& record);

/// The header with what a twin's instruments are like where nobody says: they scatter
/// by 1 um, the laser shows 0.1 um.
DataHeader WithUsualInstruments(DataHeader header);

/// Writes the rows, and their header beside them, which names the machine's file as its
/// folder has to.
void Record(const std::filesystem::path& file,
            const std::filesystem::path& machine,
            const MeasuredSession& session);

}  // namespace caltwin
