#include "tools/commands/kinds/calibrate_z_offset.h"

#include <algorithm>
#include <iostream>
#include <memory>

#include <fmt/format.h>

#include "calibration/kinds/z_station/switch_offset.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/kinds/z_station_words.h"
#include "sim/link/open_link.h"
#include "sim/link/transcript.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "tools/commands/kinds/simulated_station.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

std::vector<ZStationStep> StepsAsked(const CalibrateOptions& options) {
  if (!options.axis.empty()) {
    throw InputError({.file = "--axis"}, "a nozzle's height is along z alone");
  }
  RefuseScenarioSteps(options);
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options), "--procedure", &faults);
  auto steps = ReadZStationSteps(*map.Required("calibrate"));
  faults.ThrowIfAny();
  for (const ZStationStep& step : steps) {
    if (step.name != "change") continue;
    throw InputError({.file = "--procedure"},
                     step.name + " is a step of scenarios only",
                     "write a scenario and `caltwin run` it");
  }
  return steps;
}

void RefuseUnheeded(const CalibrateOptions& options) {
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "calibrating a nozzle's height writes no rows",
                     "`caltwin run --record` of a scenario does; --transcript keeps "
                     "each line");
  }
  if (!options.bench.empty()) {
    throw InputError({.file = "--bench"}, "a nozzle's height needs no artefacts");
  }
  if (IsTwin(options) && !options.readings.empty()) {
    throw InputError({.file = "--reading"}, "a twin has a feeler gauge of its own");
  }
  if (!IsTwin(options)) return;
  const auto file = MachineToCalibrate(options);
  if (file && file->machine.Own<ZStationDrawing>() != nullptr) return;
  throw InputError({.file = options.link},
                   "this twin has no endstop switch and magnetic probe",
                   "twin:z_station has; a scenario with `station:` puts one under any "
                   "printer");
}

// A printer, the person in front of it, and a feeler gauge.
class StationAtHand {
 public:
  explicit StationAtHand(const CalibrateOptions& options)
      : person_(PersonAtHand(options)), gauge_(ReadingsOf(options.readings)) {
    const auto file = MachineToCalibrate(options);
    if (file && file->machine.Own<ZStationDrawing>() != nullptr) {
      bed_at_mm_ = ZStationOf(file->machine).bed_at_mm;
    }
    if (IsTwin(options)) {
      twin_ = std::make_unique<SimulatedStation>(TwinOptionsOf(options.link));
    } else {
      wire_ = OpenLink(options.link);
    }
    link_ = std::make_unique<InterruptibleLink>(wire_ ? wire_.get() : &twin_->link());
    if (options.transcript.empty()) return;
    recorder_ = std::make_unique<RecordingLink>(link_.get(), options.transcript);
  }

  Link* link() { return recorder_ ? static_cast<Link*>(recorder_.get()) : link_.get(); }
  void Save() const {
    if (recorder_) recorder_->Save();
  }
  bool MayApply(const std::string& what) {
    return person_->Do({.kind = Act::Kind::kConfirm, .text = what}).has_value();
  }
  /// Where the bed is probed, by the machine file; a wire's is that of z_station unless
  /// --machine says another.
  const Eigen::Vector2d& bed_at_mm() const { return bed_at_mm_; }
  bool Wipe() {
    if (twin_) {
      twin_->Wipe();
      return true;
    }
    const auto done =
        person_->Do({.text = "Wipe the nozzle: nothing may hang under its tip."});
    if (!done) std::cerr << done.error().reply << "\n";
    return done.has_value();
  }
  std::optional<double> Gap_mm(double height_mm, ZStationClient* client) {
    if (twin_) return twin_->Gap_mm(client);
    const auto read_mm = gauge_.Read_mm(fmt::format("feeler.{:g}", height_mm));
    if (!read_mm) std::cerr << read_mm.error().reply << "\n";
    return read_mm ? std::optional(*read_mm) : std::nullopt;
  }

 private:
  std::unique_ptr<TerminalOperator> person_;
  TerminalGauge gauge_;
  Eigen::Vector2d bed_at_mm_ = ZStationDrawing{}.bed_at_mm;
  std::unique_ptr<SimulatedStation> twin_{};
  std::unique_ptr<Link> wire_{};
  std::unique_ptr<InterruptibleLink> link_{};
  std::unique_ptr<RecordingLink> recorder_{};
};

/// The G-code offset of before any step, and whether a new one is to stay.
struct OffsetBefore {
  std::optional<double> mm{};
  bool is_replaced = false;
};

// CALIBRATE_Z sets the offset by itself. Who does not want it gets the old one back,
// but at the end: a descent goes by the new one.
ProcedureResult Calibrate(StationAtHand* at_hand,
                          ZStationClient* client,
                          OffsetBefore* before) {
  ProcedureResult result = RunZCalibration(client, std::nullopt);
  if (result.ending != Ending::kDone || !before->mm) return result;
  result.steps.back().before = *before->mm;
  if (at_hand->MayApply("z_calibration: keep this offset?")) {
    before->is_replaced = true;
    return result;
  }
  result.steps.back().verdict = Verdict::kMeasured;
  result.messages.push_back(
      fmt::format("the offset of before, {:.6f}, is put back at the end", *before->mm));
  return result;
}

ProcedureResult PerformStep(const ZStationStep& step,
                            StationAtHand* at_hand,
                            ZStationClient* client,
                            OffsetBefore* before) {
  if (step.name == "z_calibration") return Calibrate(at_hand, client, before);
  if (step.name == "probe_accuracy") {
    return RunProbeAccuracy(client, step.is_endstop, step.samples);
  }
  ProcedureResult result = RunSwitchOffset(
      client,
      {.is_as_published = step.is_as_published, .at_mm = at_hand->bed_at_mm()},
      {.gap_mm = [&](double height_mm) { return at_hand->Gap_mm(height_mm, client); },
       .wipe = [&] { return at_hand->Wipe(); },
       .say =
           [](const std::string& why) {
             std::cerr << why << "\n";
           }});
  // Made with a wrong switch_offset, this one is not kept.
  for (Step& done : result.steps) done.verdict = Verdict::kMeasured;
  if (!result.steps.empty()) before->is_replaced = false;
  if (!result.estimates.empty() && result.estimates.back().value >= 0) {
    result.messages.push_back(fmt::format(
        "write `switch_offset: {:.3f}` under [z_calibration] of printer.cfg, "
        "restart, and calibrate again: no G-code sets it",
        result.estimates.back().value));
  }
  return result;
}

void SetOffset(double offset_mm, ZStationClient* client) {
  const auto set = client->Say(fmt::format("SET_GCODE_OFFSET Z={:.6f}", offset_mm));
  if (set) return;
  std::cerr << fmt::format("the offset of before, {:.6f}, could not be put back: {}\n",
                           offset_mm,
                           set.error().reply);
}

}  // namespace

bool IsZStation(const CalibrateOptions& options) {
  if (options.procedures.empty()) return false;
  const std::string_view first = options.procedures.front();
  const std::string_view name = first.substr(0, first.find(':'));
  return std::ranges::any_of(ZStationProcedureWords(),
                             [&](const Word& word) { return word.name == name; });
}

int CalibrateZStationAtHand(const CalibrateOptions& options) {
  const std::vector<ZStationStep> steps = StepsAsked(options);
  RefuseUnheeded(options);
  RefuseOverwritten(options);
  StationAtHand at_hand(options);
  ZStationClient client(at_hand.link());
  std::vector<ProcedureResult> results;
  results.push_back(client.Home());
  OffsetBefore before{.mm = client.GcodeBase_mm()};
  for (const ZStationStep& step : steps) {
    if (results.back().ending != Ending::kDone || InterruptRequested()) break;
    results.push_back(PerformStep(step, &at_hand, &client, &before));
    PrintResult(step.name, results.back());
  }
  if (results.size() == 1) PrintResult("G28", results.back());
  if (client.has_tried() && !before.is_replaced && before.mm) {
    SetOffset(*before.mm, &client);
  }
  at_hand.Save();
  if (!options.apply) std::cout << "Nothing was applied: --apply does that.\n";
  return WorstOf(options, results);
}

}  // namespace caltwin
