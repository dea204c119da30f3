#include "calibration/procedures/cluster_backlash.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/clusters.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kStart_mm = 20;    // NeXT 3.5: left_surface - 20, left_surface + 20.
constexpr double kTarget_mm = 5;    // left_surface + 5, from either side.
constexpr double kTooLarge_mm = 1;  // A gap no drive has.

struct Clusters {
  std::vector<double> from_plus_mm{};   ///< Started at left_surface + 20.
  std::vector<double> from_minus_mm{};  ///< Started at left_surface - 20.
};

// Gets to the start of one iteration. The macro drives straight there, as G0 does; the
// text's own words leave room for lifting the probe over the block first.
Expected<void> GoToStart(Session* session,
                         const Vec3<double>& start_mm,
                         bool straight) {
  if (!straight) {
    if (const auto raised = session->probing().Raise(); !raised) return raised;
    Vec3<double> over_mm = start_mm;
    over_mm[2] = session->controller().position_mm()[2];
    if (const auto over = session->controller().MoveTo(over_mm); !over) return over;
  }
  return session->controller().MoveTo(start_mm);
}

Expected<Clusters> MeasureAsPublished(Session* session, const ClusterOptions& o) {
  const CommonOptions& c = o.release.common;
  const Artefact* artefact = FindArtefact(&session->bench(),
                                          c.artefact,
                                          {ArtefactType::kWeb, ArtefactType::kBlock123},
                                          c.place);
  const std::vector<Face> faces =
      FacesForSpan(*artefact, {.axis = c.axis, .place = c.place});
  const Face& face = faces.front();
  const int i = Index(c.axis);
  const double slow_mm_s = session->bench().machine.probe.speeds_mm_s.back();
  // Along z the text has no second side; its surface is then the top, come to from
  // above, and the other start lies below it.
  if (const auto gone = session->probing().GoBefore(face, kStart_mm); !gone) {
    return tl::unexpected(gone.error());
  }
  Clusters clusters;
  for (int n = 0; n < c.repeats; ++n) {
    const bool minus = n % 2 == 1;
    Vec3<double> start_mm = face.at_mm;
    start_mm[i] += minus ? -kStart_mm : kStart_mm;
    if (const auto gone = GoToStart(session, start_mm, o.macro); !gone) {
      return tl::unexpected(gone.error());
    }
    Vec3<double> target_mm = start_mm;
    target_mm[i] = face.at_mm[i] + kTarget_mm;
    const auto found = session->controller().ProbeTowards(target_mm, slow_mm_s);
    if (!found) return tl::unexpected(found.error());
    // nxtLastProbeResult: the tip's centre moved onto the surface.
    const double radius_mm = session->believed().tip_radius_mm;
    const double at_mm =
        session->controller().position_mm()[i] + (minus ? radius_mm : -radius_mm);
    (minus ? clusters.from_minus_mm : clusters.from_plus_mm).push_back(at_mm);
  }
  if (const auto raised = session->probing().Raise(); !raised) {
    return tl::unexpected(raised.error());
  }
  return clusters;
}

Expected<void> RunAsPublished(Session* session, const ClusterOptions& o) {
  const CommonOptions& c = o.release.common;
  const std::string name = NameOf(Setting::kBacklash, c.axis);
  const double step_mm = session->probing().Noise(c.axis).step_mm;
  for (int pass = 1; pass <= c.iterations; ++pass) {
    const auto clusters = MeasureAsPublished(session, o);
    if (!clusters) return tl::unexpected(clusters.error());
    const ClusterStatistics statistics =
        CompareClusters(clusters->from_plus_mm, clusters->from_minus_mm, step_mm);
    WarnOfScatter(session,
                  "one side",
                  std::max(statistics.scatter_plus_mm, statistics.scatter_minus_mm),
                  std::array{clusters->from_plus_mm, clusters->from_minus_mm});
    if (pass > 1 && statistics.one_cluster_as_published) {
      session->Tell("All touches form one cluster.");
      return {};
    }
    const Uncertain gap_mm =
        ClusterGapAsPublished(clusters->from_plus_mm, clusters->from_minus_mm, step_mm);
    session->Tell(fmt::format(
        "Two clusters {:.4f} mm apart: that is the thickness between the two faces "
        "less 2 delta + b, not the backlash.",
        gap_mm.value));
    if (gap_mm.value > kTooLarge_mm) {
      session->Tell(
          Trouble::kUnreasonable,
          "no drive has a gap of more than 1 mm: the probe came to two faces, "
          "not to one from two sides");
    }
    const double before_mm = session->Believed(Setting::kBacklash, c.axis);
    const double added_mm = pass == 1 ? 0 : before_mm;
    const auto applied = session->Apply(
        {.setting = Setting::kBacklash,
         .axis = c.axis,
         .after = added_mm + gap_mm.value,
         .iteration = pass,
         .why = pass == 1
                    ? "The clusters' distance."
                    : "Still two clusters: the text increases the compensation."});
    if (!applied) return tl::unexpected(applied.error());
    Uncertain concluded = gap_mm;
    concluded.value += added_mm;
    session->Conclude(name, "mm", concluded, *applied);
    if (!*applied) {
      if (pass == 1 && session->rules().apply) session->End(Ending::kRefused);
      return {};
    }
  }
  return {};
}

PreparedProcedure PrepareClusterBacklash(YamlMap map, const Machine& /*drawing*/) {
  ClusterOptions o;
  o.release = ReadReleaseOptions(&map, {.repeats = 10});
  o.release.statistics = true;
  if (map.Has("macro")) {
    map.WordOr("macro", "G9100", {"G9100"});
    o.macro = true;
  }
  map.NoMoreKeys();
  return [o](Bench* bench) {
    const CommonOptions& c = o.release.common;
    Session session(bench, "next_cluster_backlash", c.Variant(), c.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunCluster(&session, o));
  };
}

}  // namespace

Expected<void> RunCluster(Session* session, const ClusterOptions& o) {
  if (o.release.common.as_published || o.macro) return RunAsPublished(session, o);
  return RunRelease(session, o.release);
}

constinit const Procedure kClusterBacklash{
    .name = "next_cluster_backlash",
    .about = "NeXT phase 3: backlash from the statistics of repeated touches.",
    .source = "NeXT machine calibration guide 1.0, section 3.5 and macro G9100.",
    .published =
        "Touch the left face ten times, in turn from left_surface - 20 and from "
        "left_surface + 20, target left_surface + 5. backlash = |mean+ - mean-|, set "
        "by M425; each cluster must scatter by less than 5 um; repeat until all form "
        "one cluster, else increase the compensation.",
    .physics =
        "The + start lies inside the solid block, where the probe collides. On a web "
        "between about 4 and 18 mm thick it triggers on the other face, and the "
        "clusters lie thickness - (2 delta + b) apart, which is not the backlash; "
        "raising the compensation never makes one cluster of two faces. The corrected "
        "form keeps the statistics and forms its clusters from triggers on the way in "
        "and releases on the way out, which differ by b + hysteresis + 2 v tau (see "
        "trigger_release_backlash), then checks by approaches from both sides.",
    .has_variants = true,
    .prepare = PrepareClusterBacklash};

}  // namespace caltwin
