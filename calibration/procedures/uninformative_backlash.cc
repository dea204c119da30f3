#include "calibration/procedures/uninformative_backlash.h"

#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "calibration/estimate/backlash.h"
#include "calibration/procedures/dial_backlash.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/release_backlash.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Both say the same of what they read.
void Say(Session* session, const CommonOptions& c, const Uninformative& read) {
  constexpr double kSigmas = 3;
  const std::string name = NameOf(Setting::kBacklash, c.axis);
  const double before_mm = session->Believed(Setting::kBacklash, c.axis);
  const bool is_zero = std::abs(read.value_mm) <= kSigmas * read.sd_mm;
  session->Measured(name,
                    before_mm,
                    fmt::format("Reads {:.4f} mm (sd {:.4f}); not applied: {}",
                                read.value_mm,
                                read.sd_mm,
                                read.statement));
  session->Tell(read.statement);
  session->Conclude(name, "mm", {});
  session->End(is_zero ? Ending::kReadsZero : Ending::kConfounded);
}

Expected<void> RunSameSide(Session* session, const CommonOptions& c) {
  const Artefact* artefact =
      FindArtefact(&session->bench(),
                   c.artefact,
                   {ArtefactType::kBlock123, ArtefactType::kWeb, ArtefactType::kPocket},
                   c.place);
  const Face face = FacesForSpan(*artefact, {.axis = c.axis, .place = c.place}).front();
  PlanModel plan(session);
  plan.AddTouch(face, c.repeats, artefact->id);
  plan.AddTouch(face, c.repeats, artefact->id);
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
  std::vector<Touched> both;
  for (int i = 0; i < 2; ++i) {
    // Away and back between the two: Touch comes down from above each time.
    const auto touched = session->probing().Touch(
        face, {.repeats = c.repeats, .campaign = "same_side." + Name(c.axis)});
    if (!touched) return tl::unexpected(touched.error());
    both.push_back(*touched);
  }
  TouchNoise noise = session->probing().Noise(c.axis);
  noise.sigma_mm = std::max(noise.sigma_mm, Scatter(both[0].trigger_mm));
  Say(session, c, SameSideBacklash(both[0].trigger_mm, both[1].trigger_mm, noise));
  return {};
}

Expected<void> RunAwayReturn(Session* session, const DialOptions& o) {
  const CommonOptions& c = o.common;
  const AxisDrawing& drawing = session->bench().machine.axis(c.axis);
  const std::string id = o.instrument + "." + Name(c.axis);
  PlanModel plan(session);
  plan.AddReading(c.axis, drawing.mid_mm(), +1, 0.001);
  plan.AddReading(c.axis, drawing.mid_mm(), +1, 0.001);
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
  const double way_mm = session->probing().LeadIn_mm(Unit(c.axis)) + 5;
  Vec3<double> at_mm = session->controller().position_mm();
  const double high_mm = drawing.max_mm - way_mm - 1;
  at_mm[Index(c.axis)] = c.axis == Axis::kZ ? high_mm : drawing.mid_mm();
  const auto go = [&](double by_mm) {
    Vec3<double> target_mm = at_mm;
    target_mm[Index(c.axis)] += by_mm;
    return session->controller().MoveTo(target_mm, drawing.max_feed_mm_s / 4);
  };
  for (const double by_mm : {-way_mm, 0.0}) {
    if (const auto gone = go(by_mm); !gone) return gone;
  }
  const auto zero_mm = session->bench().gauge->Read_mm(id);
  if (!zero_mm) return tl::unexpected(zero_mm.error());
  std::vector<double> readings_mm;
  for (int i = 0; i < c.repeats; ++i) {
    for (const double by_mm : {-way_mm, 0.0}) {
      if (const auto gone = go(by_mm); !gone) return gone;
    }
    const auto reading = session->bench().gauge->Read_mm(id);
    if (!reading) return tl::unexpected(reading.error());
    readings_mm.push_back(*reading - *zero_mm);
  }
  double sd_mm = std::max(session->probing().Noise(c.axis).step_mm / std::sqrt(12.0),
                          Scatter(readings_mm));
  const auto dial = session->bench().instruments.find(o.instrument);
  if (dial != session->bench().instruments.end()) {
    sd_mm = std::hypot(sd_mm,
                       MmFromUm(dial->second.sigma_um),
                       MmFromUm(dial->second.resolution_um) / std::sqrt(12.0));
  }
  Say(session, c, AwayReturnBacklash(readings_mm, sd_mm));
  return {};
}

PreparedProcedure PrepareSameSide(YamlMap map, const Machine& /*drawing*/) {
  const ReleaseOptions o = ReadReleaseOptions(&map, {.as_published = true});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "same_side_backlash", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(o.common.as_published ? RunSameSide(&session, o.common)
                                                : RunRelease(&session, o));
  };
}

PreparedProcedure PrepareAwayReturn(YamlMap map, const Machine& /*drawing*/) {
  const DialOptions o = ReadDialOptions(&map, {.as_published = true});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "away_return_backlash", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(o.common.as_published ? RunAwayReturn(&session, o)
                                                : RunDial(&session, o));
  };
}

}  // namespace

constinit const Procedure kSameSideBacklash{
    .name = "same_side_backlash",
    .about = "A public replacement for phase 3: touch, away, touch again the same way.",
    .source = "A public successor of the NeXT guide.",
    .published =
        "Touch a face, move away, touch it again in the same sense: the "
        "difference is the backlash.",
    .physics =
        "Both touches end moving in the same sense, so two reversals cancel: "
        "the difference is 0 for every gap and reads 0.000 with 0, 0.05 and "
        "0.20 mm. Corrected: trigger against release "
        "(trigger_release_backlash).",
    .has_variants = true,
    .prepare = PrepareSameSide};

constinit const Procedure kAwayReturnBacklash{
    .name = "away_return_backlash",
    .about = "A public replacement for phase 3: zero a dial, away, return.",
    .source = "A public successor of the NeXT guide.",
    .published =
        "Zero the dial, move away and return to the same place: what the dial "
        "shows is the backlash.",
    .physics =
        "The return ends in the sense in which the dial was zeroed, so two "
        "reversals cancel: it shows 0 for every gap. Corrected: lead in, zero, "
        "go on in the same sense, come back (dial_backlash).",
    .has_variants = true,
    .prepare = PrepareAwayReturn};

}  // namespace caltwin
