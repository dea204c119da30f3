#include "scenarios/kinds/delta_klipper_trial.h"

#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/kinds/delta/klipper_descent.h"
#include "scenarios/kinds/delta_shipped.h"
#include "sim/kinds/delta/klipper.h"
#include "sim/machine/kinds/delta/drawing.h"

namespace caltwin {
namespace {

Vec3<double> TowerSteps(const Machine& machine) {
  return Vec3<double>(TowerStepsPerMm(machine).data());
}

}  // namespace

DeltaKlipperTrial::DeltaKlipperTrial(const Machine& machine,
                                     const BuiltDelta& built,
                                     std::unique_ptr<Board> board,
                                     KlipperHostOptions options,
                                     const Chance& chance,
                                     double calliper_sigma_mm)
    : KlipperTrial(machine, std::move(board), std::move(options), chance),
      machine_(machine),
      built_(built),
      truth_{.machine = machine_, .built = built_},
      calliper_(built.build, calliper_sigma_mm, chance.seed, chance.sample) {
  truth_.before = DeltaBelievedBy(config_before());
}

Expected<std::vector<std::string>> DeltaKlipperTrial::PersonDoes(std::string_view act) {
  if (act == kMeasuredPrint) {
    // What is not homed cannot print.
    if (const auto refusal = Typed({"G1 X0 Y0 Z10 F3000"}); !refusal) return refusal;
    const auto lines = PrintAsMeasured();
    if (lines) return Typed(*lines);
    return tl::unexpected(MachineFault{MachineFault::Kind::kRefused,
                                       "it does not reach where the print would be"});
  }
  return KlipperTrial::PersonDoes(act);
}

std::optional<double> DeltaKlipperTrial::NozzleOverBed_mm(const Motors& steps) {
  const Vec3<double> motors_mm =
      InPlant(WiringOfDelta(machine_), steps).cwiseQuotient(TowerSteps(machine_));
  const auto nozzle_mm =
      NozzleOfDelta(machine_, built_, motors_mm, /*motor_dir=*/Vec3<double>::Ones());
  if (!nozzle_mm) return std::nullopt;
  return (*nozzle_mm)[2] - built_.bed.Height_mm((*nozzle_mm)[0], (*nozzle_mm)[1]);
}

// A pillar's width is read like any distance, and taken off again by the host.
std::optional<std::vector<std::string>> DeltaKlipperTrial::PrintAsMeasured() {
  constexpr double kPillar_mm = 9;
  constexpr std::size_t kSpokes = 6, kCentreWidths = 3;
  const DeltaModel<double> believed = DeltaBelievedBy(host()->Config());
  const Vec3<double> steps_per_mm = TowerSteps(machine_);
  // Drawn by whole steps.
  const auto motors_at = [&](const Eigen::Vector2d& at_mm) {
    const Vec3<double> motors_mm = DeltaMotors_mm(believed, {at_mm[0], at_mm[1], 0});
    const Vec3<double> steps = motors_mm.cwiseProduct(steps_per_mm).array().round();
    return Vec3<double>(steps.cwiseQuotient(steps_per_mm));
  };
  const auto read = [](double mm) {
    return fmt::format("{:.2f}", mm);
  };
  std::vector<std::string> dists;
  for (const KlipperRidge& ridge : KlipperPrint()) {
    const auto mm =
        calliper_.Between_mm(motors_at(ridge.first_mm), motors_at(ridge.second_mm));
    if (!mm) return std::nullopt;
    dists.push_back(read(*mm + kPillar_mm));
  }
  const auto widths = [&](std::size_t num) {
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < num; ++i) {
      texts.push_back(read(calliper_.Read_mm(kPillar_mm)));
    }
    return texts;
  };
  const std::span<const std::string> all(dists);
  return std::vector{
      fmt::format("DELTA_ANALYZE CENTER_DISTS={}", fmt::join(all.first(kSpokes), ",")),
      fmt::format("DELTA_ANALYZE CENTER_PILLAR_WIDTHS={}",
                  fmt::join(widths(kCentreWidths), ",")),
      fmt::format("DELTA_ANALYZE OUTER_DISTS={}", fmt::join(all.subspan(kSpokes), ",")),
      fmt::format("DELTA_ANALYZE OUTER_PILLAR_WIDTHS={}",
                  fmt::join(widths(kSpokes), ","))};
}

void DeltaKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  truth_.after = DeltaBelievedBy(host()->Config());
  truth_.after_first = truth_.after;
  result->position_error_before_p95_mm = DeltaPositionP95_mm(truth_, truth_.before, {});
  result->position_error_after_p95_mm = DeltaPositionP95_mm(truth_, truth_.after, {});
}

void DeltaKlipperTrial::AddParameters(const Expectation& /*expect*/,
                                      const std::vector<ProcedureResult>& /*results*/,
                                      RunResult* result) {
  AddDeltaTable(truth_, result);
}

TrueEnd DeltaKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                               RunResult* result) {
  return EndOfDelta(truth_, result);
}

double DeltaKlipperTrial::Figure(const std::string& name, const RunResult& result) {
  return FigureOfDelta(truth_, name, result);
}

std::unique_ptr<KindTrial> BeginDeltaUnderKlipper(const DeltaScenario& delta,
                                                  const Scenario& scenario,
                                                  const Chance& chance) {
  Machine machine = scenario.machine.machine;
  DeltaOf(machine).settings = delta.settings;
  const BuiltDelta built = DrawDelta(delta, machine, chance.seed, chance.sample);
  auto board = std::make_unique<PlantBoard>(
      WiringOfDelta(machine),
      std::make_unique<SteppedDelta>(
          machine, built, chance.fidelity == Fidelity::kPhysics, chance.seed));
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) options.config = PrinterCfgOfDelta(machine, "-");
  return std::make_unique<DeltaKlipperTrial>(machine,
                                             built,
                                             std::move(board),
                                             std::move(options),
                                             chance,
                                             delta.calliper_sigma_mm);
}

}  // namespace caltwin
