#include <memory>
#include <optional>

#include "calibration/kinds/triple_z/printer.h"
#include "scenarios/kinds/triple_z_trial.h"
#include "sim/base/input_error.h"
#include "tools/commands/kinds/desks.h"
#include "tools/commands/kinds/simulated_printer.h"

namespace caltwin {
namespace {

// Without --apply levelling procedures only touch the bed and say what they would
// raise; pivots are found (each screw raised and put back) and not written.
class TripleZDesk final : public Desk {
 public:
  TripleZDesk(const CalibrateOptions& options,
              const TwinOptions& papers,
              const MachineFile& file)
      : Desk(options, papers), sigma_mm_(ProbeSigma_mm(papers.instruments)) {
    bench_.machine = file.machine;
    if (!is_twin()) return;
    TwinOptions named = TwinOptionsOf(options.link);
    named.instruments = papers.instruments;
    const auto twin = std::make_shared<SimulatedPrinter>(named);
    Desk::Take(twin, &twin->link());
  }

  void Connect(Link* link) override {
    auto* const printer =
        bench_.kept.Put(TripleZPrinter(BenchOf(bench_.machine, link, sigma_mm_)));
    heard_.emplace(link, printer);
    bench_.link = &*heard_;
  }

 private:
  double sigma_mm_;
  std::optional<HeardByPrinter> heard_{};
};

void RefuseTripleZDesk(const CalibrateOptions& options,
                       const TwinOptions& papers,
                       const std::optional<MachineFile>& /*file*/) {
  if (!options.axis.empty()) {
    throw InputError({.file = "--axis"}, "a triple-Z printer is levelled as a whole");
  }
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "levelling writes no rows",
                     "`caltwin simulate` measures a printer; --transcript keeps each "
                     "line");
  }
  if (!options.readings.empty()) {
    throw InputError({.file = "--reading"}, "levelling asks for no gauge");
  }
  if (!papers.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a printer's bench has no artefacts",
                     "it knows instruments: probe");
  }
}

std::unique_ptr<Desk> MakeTripleZDesk(const CalibrateOptions& options,
                                      const TwinOptions& papers,
                                      const std::optional<MachineFile>& file) {
  return std::make_unique<TripleZDesk>(options, papers, *file);
}

}  // namespace

constinit const DeskKind kTripleZDesk{
    .kind = "triple_z", .refuse = RefuseTripleZDesk, .make = MakeTripleZDesk};

}  // namespace caltwin
