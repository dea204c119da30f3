#include "scenarios/record.h"

#include <string>
#include <vector>

#include "sim/measure/in_force.h"

namespace caltwin {
namespace {

std::vector<double> CertifiedSizes_mm(const Artefact& artefact) {
  const Vec3<double>& size_mm = artefact.size_mm;
  switch (artefact.type) {
    case ArtefactType::kBlock123:
      return {size_mm[0], size_mm[1], size_mm[2]};
    case ArtefactType::kPlate:
      return {size_mm[0], size_mm[1]};
    case ArtefactType::kWeb:
      return {size_mm[Index(artefact.side)]};
    case ArtefactType::kLedge:
      return {size_mm[2]};
    case ArtefactType::kRing:
    case ArtefactType::kPocket:
      break;
  }
  return {size_mm[0]};
}

}  // namespace

DataHeader HeaderOfRun(const Bench& bench) {
  DataHeader header{.machine = bench.machine.name, .instruments = bench.instruments};
  for (const auto& [id, settings] : bench.ledger.settings) {
    header.settings[id] = AsHeader(settings, *bench.machine.kind);
  }
  for (const Artefact& artefact : bench.artefacts) {
    header.artefacts[artefact.id] = {.type = ToString(artefact.type),
                                     .sizes_mm = CertifiedSizes_mm(artefact),
                                     .u_um = artefact.u_um};
  }
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = bench.machine.axis(axis);
    Transmission& transmission = header.transmission[Name(axis)];
    (drawing.is_belt ? transmission.pulley_mm_per_rev : transmission.lead_mm) =
        drawing.lead_mm;
    transmission.full_steps_per_mm = drawing.full_steps_per_rev / drawing.lead_mm;
  }
  header.tip_radius_mm = bench.machine.settings.tip_radius_mm;
  return header;
}

}  // namespace caltwin
