#include <memory>

#include "calibration/kinds/motor_stage/motor_axes.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/motor_stage/drawing.h"
#include "tools/commands/kinds/desks.h"
#include "tools/commands/kinds/simulated_stage.h"

namespace caltwin {
namespace {

constexpr double kLaserSigma_um = 0.5;  // Where the bench does not say.

// Procedures of motor axes home, move and store by nature: a machine wants --apply,
// which asks before each; a twin is gone afterwards anyway.
class MotorDesk final : public Desk {
 public:
  MotorDesk(const CalibrateOptions& options,
            const TwinOptions& papers,
            const MachineFile& file)
      : Desk(options, papers) {
    bench_.machine = file.machine;
    const auto laser = papers.instruments.find("laser");
    sigma_unit_ = MmFromUm(laser == papers.instruments.end() ? kLaserSigma_um
                                                             : laser->second.sigma_um);
    if (!is_twin()) return;
    const auto twin = std::make_shared<SimulatedStage>(
        MotorStageOf(file.machine), TwinOptionsOf(options.link), sigma_unit_);
    Desk::Take(twin, &twin->link());
    bench_.gauge = &twin->gauge();
    if (options.apply) return;
    Desk::Take(std::make_unique<TerminalOperator>(
        TerminalOperator::Options{.apply = true, .yes = true}));
  }

  void Connect(Link* link) override {
    bench_.link = link;
    bench_.kept.Put(MotorAxes({.link = link,
                               .gauge = bench_.gauge,
                               .drawing = MotorStageOf(bench_.machine),
                               .gauge_sigma_unit = sigma_unit_}));
  }

  std::string Farewell() const override {
    return is_twin() ? "The twin, and what it stored, is gone." : "";
  }

 private:
  double sigma_unit_ = 0;
};

void RefuseMotorDesk(const CalibrateOptions& options,
                     const TwinOptions& papers,
                     const std::optional<MachineFile>& /*file*/) {
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "motors touch nothing: there are no rows",
                     "--transcript keeps each line");
  }
  if (!papers.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a motor stage's bench has no artefacts",
                     "it knows instruments: laser");
  }
  if (!options.readings.empty()) {
    throw InputError({.file = "--reading"},
                     "a carriage is read at every approach, each time anew",
                     "they are asked for at the terminal; a twin has its laser");
  }
  if (IsTwin(options) || options.apply) return;
  throw InputError({.file = "--procedure"},
                   "procedures of motor axes home, move and store",
                   "--apply does that, asking before each; on a twin nothing stays");
}

std::unique_ptr<Desk> MakeMotorDesk(const CalibrateOptions& options,
                                    const TwinOptions& papers,
                                    const std::optional<MachineFile>& file) {
  return std::make_unique<MotorDesk>(options, papers, *file);
}

}  // namespace

constinit const DeskKind kMotorDesk{
    .kind = "motor_stage", .refuse = RefuseMotorDesk, .make = MakeMotorDesk};

}  // namespace caltwin
