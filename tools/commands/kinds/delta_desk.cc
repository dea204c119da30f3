#include <iostream>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "calibration/kinds/delta/calibrate.h"
#include "calibration/kinds/delta/klipper_descent.h"
#include "calibration/kinds/delta/procedures.h"
#include "scenarios/kinds/delta_g33.h"
#include "sim/base/input_error.h"
#include "sim/kinds/delta/twin.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "tools/commands/kinds/desks.h"
#include "tools/commands/kinds/simulated_delta.h"

namespace caltwin {
namespace {

// What the person at the terminal reads, as `calliper.rod.a1` .. (by tower and rod) and
// `calliper.print.1` .. (the twelve distances in their order, as Klipper's print has
// them: centre to each pillar, then from pillar to pillar).
DeltaCalliper AskedCalliper(Gauge* gauge, double sigma_mm) {
  const auto ask = [gauge](const std::string& id) -> std::optional<double> {
    const auto read_mm = gauge->Read_mm(id);
    if (!read_mm) std::cerr << read_mm.error().reply << "\n";
    return read_mm ? std::optional(*read_mm) : std::nullopt;
  };
  const auto next = std::make_shared<std::size_t>(0);
  return {.rod_mm = [ask](int rod) { return ask("calliper.rod." + RodName(rod)); },
          .between_mm =
              [ask, next](const Vec3<double>&, const Vec3<double>&) {
                const std::size_t at = (*next)++ % KlipperPrint().size();
                return ask(fmt::format("calliper.print.{}", at + 1));
              },
          .sigma_mm = sigma_mm};
}

class DeltaDesk final : public Desk {
 public:
  DeltaDesk(const CalibrateOptions& options,
            const TwinOptions& papers,
            const MachineFile& file)
      : Desk(options, papers) {
    bench_.machine = file.machine;
    bench_.record = &record_.rows;
    DeltaBench own{.probe_sigma_mm = ProbeSigma_mm(papers.instruments),
                   .record = &record_};
    if (is_twin()) {
      TwinOptions named = TwinOptionsOf(options.link);
      named.instruments = papers.instruments;
      twin_ = std::make_shared<DeltaTwin>(MakeDeltaTwinConfig(file, named));
      Desk::Take(twin_, &twin_->link());
      own.calliper = CalliperOf(twin_.get());
    } else {
      own.calliper = AskedCalliper(bench_.gauge, CalliperSigma_mm(papers.instruments));
    }
    bench_.kept.Put(own);
  }

  // A twin's controller has the G33 that the step asks for.
  void BeforeStep(const CalibrationStep& step) override {
    if (!twin_) return;
    twin_->SetG33(
        MarlinG33(VariantOf(step.variant), DeltaOf(bench_.machine).print_radius_mm));
  }

 private:
  std::shared_ptr<DeltaTwin> twin_{};
  DeltaRecord record_{};
};

void RefuseDeltaDesk(const CalibrateOptions& options,
                     const TwinOptions& papers,
                     const std::optional<MachineFile>& /*file*/) {
  if (papers.artefacts.empty()) return;
  throw InputError({.file = options.bench},
                   "a delta's bench has no artefacts",
                   "it knows instruments: probe and calliper");
}

std::unique_ptr<Desk> MakeDeltaDesk(const CalibrateOptions& options,
                                    const TwinOptions& papers,
                                    const std::optional<MachineFile>& file) {
  return std::make_unique<DeltaDesk>(options, papers, *file);
}

}  // namespace

constinit const DeskKind kDeltaDesk{
    .kind = "delta", .refuse = RefuseDeltaDesk, .make = MakeDeltaDesk};

}  // namespace caltwin
