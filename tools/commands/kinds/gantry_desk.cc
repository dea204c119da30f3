#include <string>

#include "tools/commands/kinds/desks.h"

namespace caltwin {
namespace {

// A gantry, or another machine with a probe that is led like one.
class GantryDesk final : public Desk {
 public:
  GantryDesk(const CalibrateOptions& options, const TwinOptions& papers)
      : Desk(options, papers) {
    bench_.record = &rows_;
    if (is_twin()) {
      TakeTwin(options, papers);
      return;
    }
    const std::string machine =
        options.machine.empty() ? TwinOptions{}.machine : options.machine;
    bench_.machine =
        ReadMachineFile(FindMachine(machine, "", {.file = "--machine"})).machine;
    bench_.artefacts =
        papers.artefacts.empty() ? UsualArtefacts(bench_.machine) : papers.artefacts;
  }

 private:
  // A twin's hands are its own; only applying is asked of the person, and that only
  // where one is there.
  void TakeTwin(const CalibrateOptions& options, const TwinOptions& papers) {
    TwinOptions named = TwinOptionsOf(options.link);
    named.artefacts = papers.artefacts;
    named.instruments = papers.instruments;
    const TwinConfig config = MakeTwinConfig(named);
    const auto twin = std::make_shared<Twin>(config);
    Desk::Take(twin, &twin->link());
    Desk::SetHands(&twin->person());
    Desk::Take(
        std::make_unique<ConfirmingOperator>(AnswersFor(options), &twin->person()));
    bench_.gauge = &twin->gauge();
    bench_.machine = config.machine;
    bench_.artefacts = config.artefacts;
    bench_.instruments = config.instruments;
  }

  RowTable rows_{};
};

void HeedAll(const CalibrateOptions& /*options*/,
             const TwinOptions& /*papers*/,
             const std::optional<MachineFile>& /*file*/) {}

std::unique_ptr<Desk> MakeGantryDesk(const CalibrateOptions& options,
                                     const TwinOptions& papers,
                                     const std::optional<MachineFile>& /*file*/) {
  return std::make_unique<GantryDesk>(options, papers);
}

}  // namespace

constinit const DeskKind kGantryDesk{
    .kind = "", .refuse = HeedAll, .make = MakeGantryDesk};

}  // namespace caltwin
