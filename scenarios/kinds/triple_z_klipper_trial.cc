#include "scenarios/kinds/triple_z_klipper_trial.h"

#include <limits>
#include <utility>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/kinds/triple_z/klipper.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

// By how much each screw stands higher than the mean of the three, by its motor's steps
// as the board counts them.
Vec3<double> RaisedBy(const Machine& machine, const Motors& steps) {
  const Vec3<double> at_mm =
      -InPlant(WiringOfTripleZ(machine), steps).tail<kNumScrews>() /
      machine.settings.steps_per_mm[2];
  return at_mm.array() - at_mm.mean();
}

}  // namespace

TripleZKlipperTrial::TripleZKlipperTrial(const BuiltTripleZ& built,
                                         std::unique_ptr<Board> board,
                                         KlipperHostOptions options,
                                         const Chance& chance)
    : KlipperTrial(built.machine, std::move(board), std::move(options), chance),
      built_(built),
      flat_before_mm_(TrueLevelOf(built, Vec3<double>::Zero(), 0).flat_rms_mm) {}

std::optional<double> TripleZKlipperTrial::NozzleOverBed_mm(const Motors& steps) {
  const TripleZTwinPlant plant(built_, /*is_physics=*/false, /*seed=*/1, /*sample=*/0);
  return plant.NozzleOverBed_mm(InPlant(WiringOfTripleZ(built_.machine), steps));
}

void TripleZKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  if (const auto steps = host()->MotorsNow()) {
    raised_mm_ = RaisedBy(built_.machine, *steps);
  }
  result->position_error_before_p95_mm =
      TripleZPositionP95_mm(built_, Vec3<double>::Zero());
  result->position_error_after_p95_mm = TripleZPositionP95_mm(built_, raised_mm_);
}

TrueEnd TripleZKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                 RunResult* result) {
  const double flat_mm = TrueLevelOf(built_, raised_mm_, 0).flat_rms_mm;
  result->messages.push_back(fmt::format(
      "the bed truly lies {:.1f} um rms from flat; {:.1f} with all screws alike",
      UmFromMm(flat_mm),
      UmFromMm(flat_before_mm_)));
  return {.figure = Flattened(flat_before_mm_, flat_mm)};
}

double TripleZKlipperTrial::Figure(const std::string& name, const RunResult& result) {
  if (name == "flatness_mm.rms") return TrueLevelOf(built_, raised_mm_, 0).flat_rms_mm;
  if (name == "position_error_mm.p95") return result.position_error_after_p95_mm;
  return std::numeric_limits<double>::quiet_NaN();
}

std::unique_ptr<KindTrial> BeginTripleZUnderKlipper(const TripleZScenario& triple_z,
                                                    const Scenario& scenario,
                                                    const Chance& chance) {
  BuiltTripleZ built =
      DrawTripleZ(triple_z, scenario.machine.machine, chance.seed, chance.sample);
  // The motors' own; what the firmware believes of them stands in its printer.cfg.
  const double believed_steps_per_mm =
      std::exchange(built.machine.settings.steps_per_mm[2],
                    TripleZOf(built.machine).screws[0].steps_per_mm());
  auto board = std::make_unique<PlantBoard>(
      WiringOfTripleZ(built.machine),
      std::make_unique<TripleZTwinPlant>(
          built, chance.fidelity == Fidelity::kPhysics, chance.seed, chance.sample));
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) {
    Machine believed = built.machine;
    for (std::size_t i = 0; i < kNumScrews; ++i) {
      ScrewDrawing& screw = TripleZOf(believed).screws[i];
      screw.at_mm = triple_z.believed_mm[i];
      screw.lead_mm =
          screw.full_steps_per_rev * screw.microsteps / believed_steps_per_mm;
    }
    options.config = PrinterCfgOfTripleZ(believed, "-");
  }
  return std::make_unique<TripleZKlipperTrial>(
      built, std::move(board), std::move(options), chance);
}

}  // namespace caltwin
