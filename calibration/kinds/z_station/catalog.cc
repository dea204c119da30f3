#include "calibration/kinds/z_station/catalog.h"

#include <array>
#include <string>

#include <fmt/format.h>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr std::string_view kZStationKind = "z_station";

ZStationDesk* DeskOn(Bench* bench) {
  auto* const desk = bench->kept.Find<ZStationDesk>();
  Require(desk != nullptr, "whoever leads a station's procedures puts its desk there");
  return desk;
}

// CALIBRATE_Z sets the offset by itself. Who does not want it gets the old one back,
// but at the end: a descent goes by the new one.
ProcedureResult Calibrate(Bench* bench) {
  ZStationDesk* const desk = DeskOn(bench);
  ProcedureResult result = RunZCalibration(desk->client, desk->switch_offset_mm);
  if (result.ending != Ending::kDone || !desk->offset_before_mm) return result;
  const double before_mm = *desk->offset_before_mm;
  result.steps.back().before = before_mm;
  const auto kept = bench->person->Do(
      {.kind = Act::Kind::kConfirm, .text = "z_calibration: keep this offset?"});
  desk->stays = desk->stays || kept.has_value();
  if (kept) return result;
  result.steps.back().verdict = Verdict::kMeasured;
  result.messages.push_back(
      fmt::format("the offset of before, {:.6f}, is put back at the end", before_mm));
  return result;
}

struct SwitchOffsetStep {
  bool is_as_published = false;
  bool applies = true;
};

// Where somebody can write printer.cfg.
void Write(const SwitchOffsetStep& step, ZStationDesk* desk, ProcedureResult* result) {
  const double after_mm = result->estimates.back().value;
  const double before_mm = desk->switch_offset_mm.value_or(after_mm);
  const bool is_taken = desk->write(after_mm);
  if (!is_taken) result->ending = Ending::kRefused;
  result->steps.push_back(
      {.procedure = "switch_offset",
       .variant = step.is_as_published ? "as_published" : "corrected",
       .name = "switch_offset",
       .before = before_mm,
       .after = is_taken ? after_mm : before_mm,
       .verdict = is_taken ? Verdict::kApplied : Verdict::kRefused,
       .message =
           is_taken ? "from the gap under the nozzle" : "Klipper takes none below 0"});
}

// Where nobody can: an offset made with a wrong switch_offset is not kept.
void SayWhatToWrite(ZStationDesk* desk, ProcedureResult* result) {
  for (Step& done : result->steps) done.verdict = Verdict::kMeasured;
  if (!result->steps.empty()) desk->stays = false;
  if (result->estimates.empty() || result->estimates.back().value < 0) return;
  result->messages.push_back(
      {fmt::format(
           "write `switch_offset: {:.3f}` under [z_calibration] of printer.cfg, "
           "restart, and calibrate again: no G-code sets it",
           result->estimates.back().value),
       Message::Kind::kToDo});
}

ProcedureResult FindSwitchOffset(const SwitchOffsetStep& step, Bench* bench) {
  ZStationDesk* const desk = DeskOn(bench);
  ProcedureResult result = RunSwitchOffset(desk->client,
                                           {.is_as_published = step.is_as_published,
                                            .in_force_mm = desk->switch_offset_mm,
                                            .at_mm = desk->bed_at_mm},
                                           desk->hands);
  if (!desk->write) {
    SayWhatToWrite(desk, &result);
  } else if (!result.estimates.empty() && step.applies) {
    Write(step, desk, &result);
  }
  return result;
}

PreparedProcedure PrepareCalibration(YamlMap map, const Machine& /*drawing*/) {
  map.NoMoreKeys();
  return Calibrate;
}

PreparedProcedure PrepareAccuracy(YamlMap map, const Machine& /*drawing*/) {
  const int samples = static_cast<int>(map.IntegerOr("samples", 10, 1, 10'000));
  const bool is_endstop =
      map.WordOr("of", "endstop", {"endstop", "probe"}) == "endstop";
  map.NoMoreKeys();
  return [samples, is_endstop](Bench* bench) {
    return RunProbeAccuracy(DeskOn(bench)->client, is_endstop, samples);
  };
}

PreparedProcedure PrepareSwitchOffset(YamlMap map, const Machine& /*drawing*/) {
  SwitchOffsetStep step;
  if (const auto flag = map.Optional("apply")) step.applies = flag->Flag();
  step.is_as_published =
      map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
      "as_published";
  map.NoMoreKeys();
  return [step](Bench* bench) {
    return FindSwitchOffset(step, bench);
  };
}

constexpr std::array kZStationCatalog = {
    Procedure{.name = "z_calibration",
              .about =
                  "Klipper's CALIBRATE_Z: the nozzle and the probe's body on the "
                  "endstop switch, the probe on the bed; offset = probe - (switch - "
                  "nozzle + switch_offset). In scenarios with a `station:`, and by "
                  "`calibrate --link`.",
              .prepare = PrepareCalibration,
              .kind = kZStationKind},
    Procedure{.name = "probe_accuracy",
              .about =
                  "PROBE_Z_ACCURACY or PROBE_ACCURACY: maximum, minimum, range, "
                  "average, median, standard deviation, and whether a switch is worn. "
                  "Options: samples, of (endstop or probe).",
              .prepare = PrepareAccuracy,
              .kind = kZStationKind},
    Procedure{.name = "switch_offset",
              .about =
                  "The stepwise descent with a feeler gauge (Z5, 3, 1, 0.5, 0.3, 0.1):"
                  " what switch_offset should be. corrected wipes the nozzle and "
                  "calibrates first; as_published goes by the offset in force, and "
                  "takes ooze for switch_offset. Option: apply (true).",
              .has_variants = true,
              .prepare = PrepareSwitchOffset,
              .kind = kZStationKind}};

}  // namespace

std::span<const Procedure> ZStationProcedures() {
  return kZStationCatalog;
}

}  // namespace caltwin
