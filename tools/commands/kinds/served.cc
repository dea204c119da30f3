#include "tools/commands/kinds/served.h"

#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/delta_g33.h"
#include "sim/base/input_error.h"
#include "sim/firmware/grbl/controller.h"
#include "sim/firmware/pace.h"
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
#include "tools/commands/serve/grbl_port.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

Served Gantry(const fs::path&, const ServeOptions& options) {
  const auto twin = std::make_shared<Twin>(MakeTwinConfig(options.twin));
  return {.about = fmt::format("{}, {}, RepRapFirmware's dialect",
                               twin->config().machine.name,
                               ToString(twin->config().fidelity)),
          .machine = twin,
          .link = &twin->link(),
          .time_s = [twin = twin.get()] {
            return twin->machine_time_s();
          }};
}

/// A gantry behind grbl, and what they share.
struct GrblGantry {
  GrblGantry(const TwinConfig& config, double speed)
      : plant(MakeTwinPlant(config)),
        pace(speed),
        paced(plant.get(), &pace),
        controller(config.machine, config.settings, &paced, &pace, plant->steps()),
        machine(&controller, &pace) {}

  std::unique_ptr<TwinPlant> plant;
  Pace pace;
  PacedPlant paced;
  grbl::Controller controller;
  GrblMachine machine;
};

Served GantryWithGrbl(const fs::path& file, const ServeOptions& options) {
  const TwinConfig config = MakeTwinConfig(options.twin);
  if (config.machine.kind->drive_map() != nullptr) {
    throw InputError(
        {.file = file.string()},
        "grbl drives each axis by a motor of its own, this machine's drives "
        "move two together",
        "--dialect rrf");
  }
  const auto gantry = std::make_shared<GrblGantry>(config, options.speed);
  return {.about = fmt::format(
              "{}, {}, grbl 1.1h", config.machine.name, ToString(config.fidelity)),
          .machine = gantry,
          .open_port = gantry->machine.ports()};
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

Served Delta(const fs::path& file, const ServeOptions& asked) {
  const TwinOptions& options = asked.twin;
  if (!options.artefacts.empty()) {
    throw InputError({.file = asked.bench},
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
          .link = &twin->link(),
          .time_s = [twin = twin.get()] {
            return twin->machine_time_s();
          }};
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

Served Printer(const fs::path&, const ServeOptions& asked) {
  const TwinOptions& options = asked.twin;
  if (!options.artefacts.empty()) {
    throw InputError({.file = asked.bench},
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

Served Station(const fs::path&, const ServeOptions& asked) {
  const TwinOptions& options = asked.twin;
  if (!asked.bench.empty()) {
    throw InputError({.file = asked.bench}, "a printer's station has no bench");
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

Served Motors(const fs::path& file, const ServeOptions& asked) {
  const TwinOptions& options = asked.twin;
  if (!asked.bench.empty()) {
    throw InputError({.file = asked.bench},
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

const std::vector<ServedKind>& Kinds() {
  static const std::vector<ServedKind> kinds = {
      {.kind = "cartesian",
       .dialects = {{.name = "rrf", .make = Gantry, .keeps_pace = true},
                    {.name = "grbl", .make = GantryWithGrbl, .keeps_pace = true}},
       .board = GantryBoard,
       .printer_cfg = PrinterCfgOfGantry,
       .linuxcnc = LinuxCncOfGantry},
      {.kind = "delta",
       .dialects =
           {{.name = "marlin", .make = Delta, .keeps_pace = true, .says_busy = true}},
       .board = DeltaBoard,
       .printer_cfg = PrinterCfgOfDelta,
       .linuxcnc = LinuxCncOfDelta},
      {.kind = "triple_z",
       .dialects = {{"rrf", Printer}},
       .board = PrinterBoard,
       .printer_cfg = PrinterCfgOfTripleZ},
      {.kind = "z_station",
       .dialects = {{"klipper", Station}},
       .board = StationBoard,
       .printer_cfg = PrinterCfgOfStation},
      {.kind = "motor_stage", .dialects = {{"motor", Motors}}}};
  return kinds;
}

}  // namespace

const ServedKind& ServedKindOf(const fs::path& file) {
  const Machine machine = ReadAnyMachineFile(file).machine;
  const bool is_on_screws = machine.Own<TripleZDrawing>() != nullptr;
  const std::string_view name = is_on_screws ? "triple_z" : machine.kind->name();
  for (const ServedKind& one : Kinds()) {
    if (one.kind == name) return one;
  }
  return Kinds().front();
}

const ServedDialect& DialectOf(const ServedKind& kind, const std::string& name) {
  if (name.empty()) return kind.dialects.front();
  std::string spoken;
  for (const ServedDialect& dialect : kind.dialects) {
    if (dialect.name == name) return dialect;
    spoken += fmt::format("{}{}", spoken.empty() ? "" : ", ", dialect.name);
  }
  throw InputError(
      {.file = "--dialect"},
      fmt::format("'{}' is not what this machine's controller speaks", name),
      fmt::format("it speaks {}: leave the option away for the first", spoken));
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
  for (const ServedKind& one : Kinds()) {
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
