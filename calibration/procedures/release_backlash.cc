#include "calibration/procedures/release_backlash.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "calibration/estimate/backlash.h"
#include "calibration/estimate/clusters.h"
#include "calibration/estimate/expanded.h"
#include "calibration/procedures/gap_reading.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/scale_doubt.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kHysteresisDoubt = 0.25;  // Of a hysteresis nobody has measured.

// All that the releases of one run read, along the outward normals.
struct Releases {
  std::map<double, std::vector<double>> difference_mm{};  ///< By feed, every pair.
  std::vector<double>
      trigger_mm{};  ///< At the slowest feed, each about its face's mean.
  std::vector<double> release_mm{};
  double scatter_mm = 0;                        ///< Of triggers at the slowest feed.
  std::vector<std::vector<double>> faces_mm{};  ///< Those triggers, face by face.
  double outward_mm = 0;  ///< Sum of the faces' mean triggers: the span's change.
  double outward_sd_mm = 0;
  std::size_t faces = 0;
};

std::vector<ArtefactType> Touchable() {
  return {ArtefactType::kBlock123,
          ArtefactType::kWeb,
          ArtefactType::kRing,
          ArtefactType::kPocket,
          ArtefactType::kPlate,
          ArtefactType::kLedge};
}

std::vector<Face> FacesToRelease(Session* session, const CommonOptions& c) {
  const Artefact* artefact =
      FindArtefact(&session->bench(), c.artefact, Touchable(), c.place);
  if (c.axis == Axis::kZ) {
    if (const auto top = TopOf(*artefact)) return {*top};
  }
  return FacesForSpan(*artefact, {.axis = c.axis, .place = c.place});
}

std::vector<double> Feeds(Session* session, const ReleaseOptions& o) {
  std::vector<double> feeds_mm_s = o.feeds_mm_s;
  if (feeds_mm_s.empty()) feeds_mm_s = session->bench().machine.probe.speeds_mm_s;
  std::ranges::sort(feeds_mm_s);
  // The published form touches at one feed and so takes the latency for backlash.
  if (o.common.as_published) feeds_mm_s.resize(1);
  return feeds_mm_s;
}

Given Hysteresis(Session* session, const ReleaseOptions& o) {
  const double value_mm =
      o.hysteresis_mm.value_or(session->bench().machine.probe.hysteresis_mm);
  const double u_mm =
      o.hysteresis_u_mm < 0 ? kHysteresisDoubt * value_mm : o.hysteresis_u_mm;
  return {.value = value_mm, .sd = u_mm, .source = "hysteresis"};
}

void KeepSlowest(Session* session, Axis axis, const Touched& touched, Releases* all) {
  const Uncertain trigger =
      MeanTouch_mm(touched.trigger_mm, NoiseOf(session, axis, std::span(&touched, 1)));
  for (std::size_t i = 0; i < touched.trigger_mm.size(); ++i) {
    all->trigger_mm.push_back(touched.trigger_mm[i] - trigger.value);
    all->release_mm.push_back(touched.release_mm[i] - trigger.value);
  }
  all->outward_mm += trigger.value;
  all->outward_sd_mm = std::hypot(all->outward_sd_mm, trigger.sd);
  all->faces_mm.push_back(touched.trigger_mm);
  all->scatter_mm = std::max(all->scatter_mm, Scatter(touched.trigger_mm));
}

Expected<Releases> MeasureReleaseBacklash(Session* session, const ReleaseOptions& o) {
  const CommonOptions& c = o.common;
  const std::vector<double> feeds_mm_s = Feeds(session, o);
  const double push_on_mm = c.as_published ? 0 : PushOn_mm(session, c.axis);
  Releases all;
  for (const Face& face : FacesToRelease(session, c)) {
    ++all.faces;
    for (const double feed_mm_s : feeds_mm_s) {
      const auto touched =
          session->probing().Touch(face,
                                   {.repeats = c.repeats,
                                    .feed_mm_s = feed_mm_s,
                                    .release = true,
                                    .push_on_mm = push_on_mm,
                                    .campaign = "trigger_release." + Name(c.axis)});
      if (!touched) return tl::unexpected(touched.error());
      for (std::size_t i = 0; i < touched->trigger_mm.size(); ++i) {
        // Inward, the trigger lies beyond the release by b + hysteresis.
        const double difference_mm = touched->release_mm[i] - touched->trigger_mm[i];
        all.difference_mm[feed_mm_s].push_back(difference_mm);
      }
      if (feed_mm_s == feeds_mm_s.front()) {
        KeepSlowest(session, c.axis, *touched, &all);
      }
    }
  }
  return all;
}

ReleaseFit FitReleaseBacklash(Session* session,
                              const Releases& all,
                              const ReleaseOptions& o) {
  std::vector<TriggerRelease> feeds;
  for (const auto& [feed_mm_s, differences_mm] : all.difference_mm) {
    // A difference of two readings scatters as their sum does: by sqrt(2) each.
    std::vector<double> each_mm;
    for (const double difference_mm : differences_mm) {
      each_mm.push_back(difference_mm / std::numbers::sqrt2);
    }
    const std::span<const double> group_mm(each_mm);
    const TouchNoise noise =
        NoiseSeen(session->probing().Noise(o.common.axis), std::span(&group_mm, 1));
    const double sd_mm =
        TriggerReleaseSd_mm(noise, static_cast<int>(differences_mm.size()));
    feeds.push_back(
        {.feed_mm_s = feed_mm_s,
         .difference_mm = {
             .value = Mean(differences_mm), .sd = sd_mm, .dof = noise.dof}});
  }
  const Given latency_s = feeds.size() == 1 ? Given{} : kNotGiven;
  return BacklashFromRelease(feeds, Hysteresis(session, o), latency_s);
}

void ExplainPlanOfReleaseBacklash(Session* session, const ReleaseOptions& o) {
  PlanModel plan(session);
  for (const Face& face : FacesToRelease(session, o.common)) {
    for (const double feed_mm_s : Feeds(session, o)) {
      plan.AddTouchAt(face, o.common.repeats, face.artefact, feed_mm_s);
      plan.AddRelease(face, o.common.repeats, face.artefact, feed_mm_s);
    }
  }
  plan.AddKnown(NameOf(Setting::kStepsPerMm, o.common.axis), 0.1);
  plan.AddKnown("probe_hysteresis", Hysteresis(session, o).sd + 1e-6);
  const ObservabilityReport report = plan.Report();
  session->Tell({InWords(report), Message::Kind::kOpen});
  session->Explain(report);
}

void PrintClusters(Session* session, const Releases& all, Axis axis) {
  const double step_mm = session->probing().Noise(axis).step_mm;
  const ClusterStatistics clusters =
      CompareClusters(all.trigger_mm, all.release_mm, step_mm);
  session->Tell(fmt::format(
      "{} triggers scatter by {:.2f} um, {} releases by {:.2f} um; the clusters lie "
      "{:.4f} mm apart.",
      clusters.count_plus,
      UmFromMm(clusters.scatter_plus_mm),
      clusters.count_minus,
      UmFromMm(clusters.scatter_minus_mm),
      std::abs(clusters.mean_plus_mm - clusters.mean_minus_mm)));
}

// Says why the carriage gives way, where it does.
bool HoldsItsCarriage(Session* session, Axis axis) {
  const AxisDrawing& drawing = session->bench().machine.axis(axis);
  if (FrictionHoldsCarriage(axis, drawing, session->bench().machine.probe)) return true;
  session->Tell(fmt::format(
      "Not valid on {}: its rail friction ({:.3g} N) does not exceed the stylus' force "
      "and the load that hangs on the nut, so the carriage gives way in its gap. "
      "Trigger against release then reads the switch's hysteresis alone. Use a dial or "
      "a laser.",
      Letter(axis),
      drawing.rail_friction_n));
  return false;
}

// The compensation just set, seen by touches from both sides: it must lengthen the span
// by as much as it was set to.
Expected<Uncertain> SpanLeft(Session* session,
                             const ReleaseOptions& o,
                             const Releases& before,
                             const Uncertain& gap_mm) {
  double outward_mm = -before.outward_mm;
  double sd_mm = before.outward_sd_mm;
  for (const Face& face : FacesToRelease(session, o.common)) {
    const auto touched =
        session->probing().Touch(face,
                                 {.repeats = o.common.repeats,
                                  .campaign = "backlash_check." + Name(o.common.axis)});
    if (!touched) return tl::unexpected(touched.error());
    const Uncertain mean = MeanTouch_mm(
        touched->trigger_mm, NoiseOf(session, o.common.axis, std::span(&*touched, 1)));
    outward_mm += mean.value;
    sd_mm = std::hypot(sd_mm, mean.sd);
  }
  return Uncertain{
      .value = gap_mm.value - outward_mm, .sd = sd_mm, .identifiable = true};
}

Expected<Uncertain> GapLeft(Session* session,
                            const ReleaseOptions& o,
                            const Releases& before,
                            const Uncertain& gap_mm) {
  const bool two_faces = before.faces == 2;
  const GapCheck check =
      o.check.value_or(two_faces ? GapCheck::kSpan : GapCheck::kNone);
  if (check == GapCheck::kDial || check == GapCheck::kLaser) {
    const std::string kind = check == GapCheck::kDial ? "dial." : "laser.";
    return ReadGapLeft(
        session, o.common.axis, kind + Name(o.common.axis), o.common.repeats);
  }
  if (check == GapCheck::kSpan && two_faces) {
    return SpanLeft(session, o, before, gap_mm);
  }
  return Uncertain{};
}

Expected<void> Check(Session* session,
                     const ReleaseOptions& o,
                     const Releases& measured,
                     const Uncertain& gap_mm,
                     const Proposal& proposal,
                     double before_mm) {
  const std::string name = NameOf(Setting::kBacklash, o.common.axis);
  if (!o.common.verify) {
    session->Conclude(name, "mm", gap_mm, true);
    return {};
  }
  const auto left_mm = GapLeft(session, o, measured, gap_mm);
  if (!left_mm) return tl::unexpected(left_mm.error());
  bool kept = true;
  if (left_mm->identifiable) {
    const auto good = session->KeepOrRollBack(proposal,
                                              before_mm,
                                              {.error_before = gap_mm.value - before_mm,
                                               .error_after = left_mm->value,
                                               .sd = left_mm->sd});
    if (!good) return tl::unexpected(good.error());
    kept = *good;
    session->Tell(fmt::format(
        "Approached from both sides, {:+.4f} mm of the gap of {:.4f} mm are left: {}.",
        left_mm->value,
        gap_mm.value,
        std::abs(left_mm->value) < kScatterWarning_mm ? "one cluster"
                                                      : "still two clusters"));
  }
  session->Conclude(name, "mm", gap_mm, kept);
  return {};
}

}  // namespace

Expected<void> RunRelease(Session* session, const ReleaseOptions& o) {
  const CommonOptions& c = o.common;
  ExplainPlanOfReleaseBacklash(session, o);
  const bool valid = HoldsItsCarriage(session, c.axis);
  const auto measure = [&] {
    return MeasureReleaseBacklash(session, o);
  };
  const auto measured =
      c.as_published ? measure() : WithoutCompensation(session, c.axis, measure);
  if (!measured) return tl::unexpected(measured.error());
  WarnOfScatter(session, "one face", measured->scatter_mm, measured->faces_mm);
  if (o.statistics) PrintClusters(session, *measured, c.axis);
  const ReleaseFit fit = FitReleaseBacklash(session, *measured, o);
  const std::string name = NameOf(Setting::kBacklash, c.axis);
  const double before_mm = session->Believed(Setting::kBacklash, c.axis);
  session->Tell(
      fmt::format("Trigger and release lie {:.4f} mm apart at rest, {:.4f} mm "
                  "of it hysteresis.",
                  fit.combination_mm.value,
                  Hysteresis(session, o).value));
  if (!valid && !c.as_published) {
    session->Measured(name, before_mm, "Not applied: the carriage gives way.");
    session->Conclude(name, "mm", {});
    session->End(Ending::kConfounded);
    return {};
  }
  Uncertain gap_mm = c.as_published ? fit.combination_mm : fit.backlash_mm;
  // As published, the reading is added to what is set.
  if (c.as_published) gap_mm.value += before_mm;
  if (!c.as_published) {
    // Who believes in too many steps a millimetre reads too little.
    gap_mm =
        WithInput(gap_mm, InputOf("steps/mm", gap_mm.value, ScaleOf(session, c.axis)));
  }
  const Proposal proposal{
      .setting = Setting::kBacklash,
      .axis = c.axis,
      .after = std::max(0.0, gap_mm.value),
      .sd = gap_mm.sd,
      .why =
          fmt::format("The gap reads {:.4f} mm (sd {:.4f}).", gap_mm.value, gap_mm.sd)};
  const auto applied = session->Apply(proposal);
  if (!applied) return tl::unexpected(applied.error());
  if (!*applied) {
    if (session->rules().apply) session->End(Ending::kRefused);
    session->Conclude(name, "mm", gap_mm);
    return {};
  }
  if (c.as_published) {
    session->Conclude(name, "mm", gap_mm, true);
    return {};
  }
  return Check(session, o, *measured, gap_mm, proposal, before_mm);
}

ReleaseOptions ReadReleaseOptions(YamlMap* map, const CommonOptions& defaults) {
  ReleaseOptions o;
  o.common = ReadCommon(map, defaults);
  if (const auto feeds = map->Optional("feeds_mm_s")) {
    for (const YamlValue& feed : feeds->List()) {
      o.feeds_mm_s.push_back(feed.Number({0.01, 100}));
    }
    std::ranges::sort(o.feeds_mm_s);
    const bool twice = std::ranges::adjacent_find(o.feeds_mm_s) != o.feeds_mm_s.end();
    if (o.feeds_mm_s.size() < 2 || twice) {
      feeds->Fail("must be two or more different feeds in mm/s",
                  "the latency of the trigger is extrapolated away");
    }
  }
  if (map->Has("hysteresis_mm")) {
    o.hysteresis_mm = map->Number("hysteresis_mm", {0, 1});
  }
  o.hysteresis_u_mm = map->NumberOr("hysteresis_u_mm", -1, {0, 1});
  if (map->Has("check")) {
    const std::string word =
        map->WordOr("check", "span", {"none", "span", "dial", "laser"});
    o.check = word == "dial"    ? GapCheck::kDial
              : word == "laser" ? GapCheck::kLaser
              : word == "span"  ? GapCheck::kSpan
                                : GapCheck::kNone;
  }
  return o;
}

namespace {

PreparedProcedure PrepareReleaseBacklash(YamlMap map, const Machine& /*drawing*/) {
  const ReleaseOptions o = ReadReleaseOptions(&map, {});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(
        bench, "trigger_release_backlash", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunRelease(&session, o));
  };
}

}  // namespace

constinit const Procedure kTriggerReleaseBacklash{
    .name = "trigger_release_backlash",
    .about =
        "Backlash from the trigger on the way in against the release on the way "
        "out.",
    .source =
        "The form Marlin's G425 uses; probe-away moves G38.4 of LinuxCNC and RRF.",
    .published =
        "Touch a face, back off until the probe releases; the difference of "
        "the two positions is the backlash, added to what is set. One feed, "
        "compensation left on.",
    .physics =
        "difference = b + hysteresis + 2 v tau. The reversal crosses the gap while the "
        "stylus stays bent, so face, tip and pre-travel cancel. Two feeds extrapolate "
        "the latency tau away; the switch's hysteresis must be known. With M425 set "
        "the controller spreads the correction over a move of 10 b, the short release "
        "reads b once more, and a second run adds it twice: measure with M425 at 0, "
        "check by approaches from both sides, never by release. Valid only while rail "
        "friction exceeds the stylus' force and the load that hangs on the nut; else "
        "it reads the hysteresis alone.",
    .has_variants = true,
    .prepare = PrepareReleaseBacklash};

}  // namespace caltwin
