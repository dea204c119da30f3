#include "calibration/procedures/dial_backlash.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/procedures/gap_reading.h"
#include "calibration/procedures/plan_model.h"

namespace caltwin {

Expected<void> RunDial(Session* session, const DialOptions& o) {
  const CommonOptions& c = o.common;
  const std::string id = o.instrument + "." + Name(c.axis);
  PlanModel plan(session);
  const double middle_mm = session->bench().machine.axis(c.axis).mid_mm();
  for (const int sense : {+1, -1}) plan.AddReading(c.axis, middle_mm, sense, 0.001);
  plan.AddKnown(NameOf(Setting::kStepsPerMm, c.axis), 0.1);
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
  const auto left_mm = ReadGapLeft(session, c.axis, id, c.repeats);
  if (!left_mm) return tl::unexpected(left_mm.error());
  const std::string name = NameOf(Setting::kBacklash, c.axis);
  const double before_mm = session->Believed(Setting::kBacklash, c.axis);
  Uncertain gap_mm = *left_mm;
  gap_mm.value += before_mm;
  const Proposal proposal{
      .setting = Setting::kBacklash,
      .axis = c.axis,
      .after = std::max(0.0, gap_mm.value),
      .sd = gap_mm.sd,
      .why = fmt::format("The {} reads {:+.4f} mm of lost motion beside the {:.4f} mm "
                         "compensated.",
                         o.instrument,
                         left_mm->value,
                         before_mm)};
  const auto applied = session->Apply(proposal);
  if (!applied) return tl::unexpected(applied.error());
  bool kept = *applied;
  if (!*applied && session->rules().apply) session->End(Ending::kRefused);
  if (*applied && c.verify) {
    const auto after_mm = ReadGapLeft(session, c.axis, id, c.repeats);
    if (!after_mm) return tl::unexpected(after_mm.error());
    const auto good = session->KeepOrRollBack(proposal,
                                              before_mm,
                                              {.error_before = left_mm->value,
                                               .error_after = after_mm->value,
                                               .sd = after_mm->sd});
    if (!good) return tl::unexpected(good.error());
    kept = *good;
  }
  session->Conclude(name, "mm", gap_mm, kept);
  return {};
}

DialOptions ReadDialOptions(YamlMap* map, const CommonOptions& defaults) {
  DialOptions o;
  o.common = ReadCommon(map, defaults);
  o.instrument = map->WordOr("instrument", "dial", {"dial", "laser"});
  return o;
}

namespace {

PreparedProcedure PrepareDialBacklash(YamlMap map, const Machine& /*drawing*/) {
  const DialOptions o = ReadDialOptions(&map, {});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "dial_backlash", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunDial(&session, o));
  };
}

}  // namespace

constinit const Procedure kDialBacklash{
    .name = "dial_backlash",
    .about = "Backlash by a dial indicator: lead in, zero, on, come back.",
    .source = "Workshop practice; the reversal value B of ISO 230-2 at one position.",
    .published =
        "Preload the axis in one direction, zero the dial, move on in the same "
        "direction, come back to the same command: the dial shows the backlash.",
    .physics =
        "Right: moving in + the carriage lags by b / 2, moving in - it leads, so "
        "the two approaches to one command lie b apart. With compensation on it "
        "reads what is left, since every move is longer than the ten gaps over "
        "which RepRapFirmware spreads its correction.",
    .has_variants = false,
    .prepare = PrepareDialBacklash};

}  // namespace caltwin
