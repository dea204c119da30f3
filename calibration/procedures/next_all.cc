#include "calibration/procedures/next_all.h"

#include "calibration/loop/user_vars.h"
#include "calibration/procedures/cluster_backlash.h"
#include "calibration/procedures/deflection.h"
#include "calibration/procedures/dual_dimension.h"
#include "calibration/procedures/plane_tilt.h"
#include "calibration/procedures/rough_steps.h"
#include "calibration/procedures/verify.h"

namespace caltwin {
namespace {

// One phase of several: that it could not tell one quantity does not end the others;
// that nothing was applied does.
Expected<bool> GoOn(Session* session, const Expected<void>& phase) {
  if (!phase) return tl::unexpected(phase.error());
  if (session->result().ending == Ending::kConfounded) session->End(Ending::kDone);
  return session->result().ending == Ending::kDone;
}

Expected<bool> Steps(Session* session, const CommonOptions& c) {
  const std::vector<double> sizes_mm =
      c.as_published ? std::vector{25.4, 50.8} : std::vector{25.4, 76.2};
  return GoOn(session, RunDualDimension(session, {.common = c, .sizes_mm = sizes_mm}));
}

Expected<bool> NextAllGap(Session* session,
                          const AllOptions& o,
                          const CommonOptions& c) {
  ClusterOptions cluster{.release = o.release};
  cluster.release.common = c;
  cluster.release.statistics = true;
  return GoOn(session, RunCluster(session, cluster));
}

Expected<bool> RunAxis(Session* session, const AllOptions& o, Axis axis) {
  CommonOptions c = o.common;
  c.axis = axis;
  if (o.rough) {
    const auto done = GoOn(session, RunRoughSteps(session, {.common = c}));
    if (!done || !*done) return done;
  }
  const auto first = o.backlash_first ? NextAllGap(session, o, c) : Steps(session, c);
  if (!first || !*first) return first;
  const auto second = o.backlash_first ? Steps(session, c) : NextAllGap(session, o, c);
  if (!second || !*second) return second;
  return GoOn(session, RunDeflection(session, {.common = c}));
}

void SayOrder(Session* session, const AllOptions& o) {
  session->Tell(
      o.backlash_first
          ? "Order of appendix A: backlash, then steps/mm. Both orders end alike: the "
            "two sizes cancel the gap, and an error of steps/mm below 5 % changes a "
            "gap "
            "by less than 5 % of it."
          : "Order of section 2: steps/mm, then backlash. The two sizes cancel the "
            "gap, "
            "so steps/mm need nothing else, and the gap is then read in true mm.");
}

}  // namespace

Expected<void> RunAll(Session* session, const AllOptions& o) {
  SayOrder(session, o);
  for (const Axis axis : o.axes) {
    const auto done = RunAxis(session, o, axis);
    if (!done) return tl::unexpected(done.error());
    if (!*done) return {};
  }
  if (o.tilt) {
    const auto done = GoOn(session, RunPlaneTilt(session, {.place = o.common.place}));
    if (!done) return tl::unexpected(done.error());
  }
  if (o.verify_at_end) {
    const auto verified = RunVerify(session,
                                    {.axes = o.axes,
                                     .artefact = o.common.artefact,
                                     .instrument = o.instrument,
                                     .place = o.common.place});
    if (!verified) return verified;
  }
  return o.persist ? Persist(session, o.date) : Expected<void>{};
}

namespace {

PreparedProcedure PrepareNextAll(YamlMap map, const Machine& /*drawing*/) {
  AllOptions o;
  o.axes = ReadAxes(&map);
  CommonOptions& c = o.common;
  c.place = map.place();
  c.as_published = map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
                   "as_published";
  c.artefact = map.TextOr("artefact", "");
  c.repeats = static_cast<int>(map.IntegerOr("repeats", 5, 1, 1000));
  c.iterations = static_cast<int>(map.IntegerOr("iterations", 1, 1, 100));
  c.rules.roll_back = map.FlagOr("rollback", !c.as_published);
  c.rules.keep_within_sd = c.as_published ? 0 : kKeepWithinSd;
  c.rules.steps_limit = map.NumberOr("steps_limit", 0.05, {1e-4, 0.5});
  o.rough = map.FlagOr("rough", false);
  o.backlash_first =
      map.WordOr("order", "section_2", {"section_2", "appendix_a"}) == "appendix_a";
  o.tilt = map.FlagOr("tilt", false);
  o.verify_at_end = map.FlagOr("verify", true);
  o.persist = map.FlagOr("persist", true);
  o.date = map.TextOr("date", "");
  o.instrument = map.WordOr("instrument", "dial", {"dial", "laser", "none"});
  if (map.Has("hysteresis_mm")) {
    o.release.hysteresis_mm = map.Number("hysteresis_mm", {0, 1});
  }
  o.release.hysteresis_u_mm = map.NumberOr("hysteresis_u_mm", -1, {0, 1});
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "next_all", o.common.Variant(), o.common.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunAll(&session, o));
  };
}

}  // namespace

constinit const Procedure kNextAll{
    .name = "next_all",
    .about = "NeXT phases 1 to 5 on every axis, kept in nxt-user-vars.g.",
    .source = "NeXT machine calibration guide 1.0, sections 2, 3 and 4, appendix A.",
    .published =
        "Rough steps/mm, precise steps/mm, backlash, deflection, verification; "
        "appendix A and the wizard have backlash before precise steps/mm. "
        "Kept as M92, M425 and a global in nxt-user-vars.g.",
    .physics =
        "Either order works, since the two sizes cancel the gap. The deflection "
        "must come last. A `global` line fails on the second load unless "
        "exists() guards it. M500 keeps none of the three.",
    .has_variants = true,
    .prepare = PrepareNextAll};

}  // namespace caltwin
