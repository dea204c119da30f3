#include "tools/commands/kinds/served.h"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/delta_g33.h"
#include "sim/base/input_error.h"
#include "sim/kinds/cartesian/corners.h"
#include "sim/kinds/cartesian/klipper.h"
#include "sim/kinds/cartesian/linuxcnc.h"
#include "sim/kinds/delta/klipper.h"
#include "sim/kinds/delta/linuxcnc.h"
#include "sim/kinds/delta/twin.h"
#include "sim/kinds/triple_z/klipper.h"
#include "sim/kinds/z_station/klipper.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/motor_stage/drawing.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"
#include "sim/twin/twin.h"
#include "tools/commands/kinds/simulated_delta.h"
#include "tools/commands/kinds/simulated_printer.h"
#include "tools/commands/kinds/simulated_stage.h"
#include "tools/commands/kinds/simulated_station.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

Served Gantry(const fs::path&, const TwinOptions& options, const std::string&) {
  const auto twin = std::make_shared<Twin>(MakeTwinConfig(options));
  return {.about = fmt::format("{}, {}, RepRapFirmware's dialect",
                               twin->config().machine.name,
                               ToString(twin->config().fidelity)),
          .machine = twin,
          .link = &twin->link()};
}

std::unique_ptr<Board> GantryBoard(const fs::path&, const TwinOptions& options) {
  const TwinConfig config = MakeTwinConfig(options);
  // Its table is empty: nobody tells the host of a block to keep clear of.
  Built built{.machine = config.machine,
              .effects = config.effects,
              .probe_sigma_mm = ProbeSigma_mm(options.instruments)};
  built.Prepare();
  return BoardOfGantry(built, config.fidelity == Fidelity::kPhysics, config.seed).board;
}

Served Delta(const fs::path& file,
             const TwinOptions& options,
             const std::string& bench) {
  if (!options.artefacts.empty()) {
    throw InputError({.file = bench},
                     "a delta's bench has no artefacts",
                     "it knows instruments: probe and calliper");
  }
  const MachineFile read = ReadAnyMachineFile(file);
  const auto twin = std::make_shared<DeltaTwin>(MakeDeltaTwinConfig(read, options));
  twin->SetG33(
      MarlinG33(G33Variant::kCorrected, DeltaOf(read.machine).print_radius_mm));
  return {.about = fmt::format("{}, {}, Marlin's dialect",
                               read.machine.name,
                               ToString(twin->config().fidelity)),
          .machine = twin,
          .link = &twin->link()};
}

std::unique_ptr<Board> DeltaBoard(const fs::path& file, const TwinOptions& options) {
  const DeltaTwinConfig config = MakeDeltaTwinConfig(ReadAnyMachineFile(file), options);
  return std::make_unique<PlantBoard>(
      WiringOfDelta(config.machine),
      std::make_unique<SteppedDelta>(config.machine,
                                     config.built,
                                     config.fidelity == Fidelity::kPhysics,
                                     config.seed));
}

Served Printer(const fs::path&, const TwinOptions& options, const std::string& bench) {
  if (!options.artefacts.empty()) {
    throw InputError({.file = bench},
                     "a printer's bench has no artefacts",
                     "it knows instruments: probe");
  }
  const auto printer = std::make_shared<SimulatedPrinter>(options);
  return {.about = fmt::format("{}, {}, RepRapFirmware's dialect",
                               printer->machine().name,
                               options.fidelity),
          .machine = printer,
          .link = &printer->link()};
}

std::unique_ptr<Board> PrinterBoard(const fs::path&, const TwinOptions& options) {
  const BuiltTripleZ built = BuiltPrinter(options);
  return std::make_unique<PlantBoard>(
      WiringOfTripleZ(built.machine),
      std::make_unique<TripleZTwinPlant>(
          built, options.fidelity == "physics", options.seed, /*sample=*/0));
}

Served Station(const fs::path&, const TwinOptions& options, const std::string& bench) {
  if (!bench.empty()) {
    throw InputError({.file = bench}, "a printer's station has no bench");
  }
  const auto station = std::make_shared<SimulatedStation>(options);
  return {
      .about = fmt::format("z_station, {}, Klipper's z_calibration", options.fidelity),
      .machine = station,
      .link = &station->link()};
}

std::unique_ptr<Board> StationBoard(const fs::path& file, const TwinOptions& options) {
  const Machine machine = ReadAnyMachineFile(file).machine;
  return std::make_unique<PlantBoard>(
      WiringOfStation(machine),
      std::make_unique<SteppedStation>(
          machine, BuiltStation(options), options.fidelity == "physics", options.seed));
}

Served Motors(const fs::path& file,
              const TwinOptions& options,
              const std::string& bench) {
  if (!bench.empty()) {
    throw InputError({.file = bench},
                     "a motor stage on a wire has no bench",
                     "nobody at the other end reads its gauges");
  }
  const MotorStageDrawing drawing = MotorStageOf(ReadAnyMachineFile(file).machine);
  const auto stage = std::make_shared<SimulatedStage>(drawing,
                                                      options,
                                                      /*sigma_unit=*/0);
  return {
      .about = fmt::format(
          "{}, {}, the dialect of docs/motor-axes.md", drawing.name, options.fidelity),
      .machine = stage,
      .link = &stage->link()};
}

constexpr std::array kKinds = {
    ServedKind{
        "cartesian", "rrf", Gantry, GantryBoard, PrinterCfgOfGantry, LinuxCncOfGantry},
    ServedKind{
        "delta", "marlin", Delta, DeltaBoard, PrinterCfgOfDelta, LinuxCncOfDelta},
    ServedKind{"triple_z", "rrf", Printer, PrinterBoard, PrinterCfgOfTripleZ},
    ServedKind{"z_station", "klipper", Station, StationBoard, PrinterCfgOfStation},
    ServedKind{"motor_stage", "motor", Motors}};

}  // namespace

const ServedKind& ServedKindOf(const fs::path& file) {
  const Machine machine = ReadAnyMachineFile(file).machine;
  const bool is_on_screws = machine.Own<TripleZDrawing>() != nullptr;
  const std::string_view name = is_on_screws ? "triple_z" : machine.kind->name();
  for (const ServedKind& one : kKinds) {
    if (one.kind == name) return one;
  }
  return kKinds[0];
}

namespace {

// The machine's kind where `can` says that it is able; else throws InputError with
// those that are.
template <typename Can>
const ServedKind& ServedTo(std::string_view controller,
                           const fs::path& machine,
                           const std::string& place,
                           const Can& can) {
  const ServedKind& kind = ServedKindOf(machine);
  if (can(kind)) return kind;
  std::string able;
  for (const ServedKind& one : kKinds) {
    if (!can(one)) continue;
    able += fmt::format("{}{}", able.empty() ? "" : ", ", one.kind);
  }
  throw InputError(
      {.file = place},
      fmt::format(
          "a machine of kind {} cannot yet be driven by {}", kind.kind, controller),
      fmt::format("kinds that can: {}", able));
}

}  // namespace

const ServedKind& ServedToKlipper(const fs::path& machine, const std::string& place) {
  return ServedTo("Klipper", machine, place, [](const ServedKind& kind) {
    return kind.board != nullptr;
  });
}

const ServedKind& ServedToLinuxCnc(const fs::path& machine, const std::string& place) {
  return ServedTo("LinuxCNC", machine, place, [](const ServedKind& kind) {
    return kind.linuxcnc != nullptr;
  });
}

}  // namespace caltwin
