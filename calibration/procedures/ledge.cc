#include "calibration/procedures/ledge.h"

#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "calibration/estimate/tilt_plane.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"
#include "sim/machine/disc_overlap.h"

namespace caltwin {
namespace {

constexpr double kCorner_mm = 14;  // Of the four touches off the lip's middle.

// What the touches of the top tell of the lip as it lies.
struct Lip {
  Uncertain top_mm{};  // Reading along +z at the middle, the disc's rim included.
  Eigen::Vector2d slope{0, 0};
  double slope_sd = 0;
  std::vector<Touched> touches{};
};

Expected<void> Fit(Session* session, const std::string& stylus) {
  if (const auto raised = session->probing().Raise(); !raised) return raised;
  return session->bench().person->Do({.kind = Act::Kind::kFitStylus,
                                      .text = fmt::format("Fit the {} stylus.", stylus),
                                      .artefact = stylus});
}

Expected<Lip> TouchTop(Session* session, const Face& top, const SpanPlan& plan) {
  Lip lip;
  std::vector<Vec3<double>> points_mm;
  double sd_mm = 0;
  for (const auto& [x, y] :
       std::array<std::array<int, 2>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    Face corner = top;
    corner.at_mm += Vec3<double>(x, y, 0) * kCorner_mm;
    const auto touched = session->probing().Touch(
        corner, {.repeats = plan.repeats, .campaign = plan.campaign});
    if (!touched) return tl::unexpected(touched.error());
    const Uncertain mean = MeanOf(session, Axis::kZ, touched->trigger_mm);
    points_mm.emplace_back(corner.at_mm[0], corner.at_mm[1], mean.value);
    sd_mm = std::max(sd_mm, mean.sd);
    lip.touches.push_back(*touched);
  }
  const TiltPlane plane = FitTiltPlane(points_mm, std::max(sd_mm, 1e-9), top.at_mm);
  lip.top_mm = plane.height_mm;
  lip.slope = {plane.slope_x.value, plane.slope_y.value};
  lip.slope_sd = plane.slope_x.sd;
  return lip;
}

// What tilt alone adds to the span: the rim above, and below the way to where the disc
// meets the underside; with the uncertainty that the slopes leave.
Uncertain TiltShare(const Artefact& ledge,
                    const Face& bottom,
                    const Lip& lip,
                    double disc_radius_mm) {
  const double turn_rad = RadFromDeg(ledge.turn_deg);
  const Eigen::Vector2d out_mm = (bottom.at_mm - ledge.at_mm).head<2>();
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  Eigen::Matrix2d local;  // From the machine's axes to the artefact's.
  local << c, s, -s, c;
  const Eigen::Vector2d slope = local * lip.slope;
  const Eigen::Vector2d contact_mm =
      FirstContact_mm({.disc_mm = local * out_mm,
                       .radius_mm = disc_radius_mm,
                       .half_mm = ledge.size_mm.head<2>() / 2},
                      -slope);
  const double rim_mm = Mutant("ledge_forgets_the_rim", disc_radius_mm, 0.0);
  return {.value = rim_mm * slope.norm() - slope.dot(contact_mm),
          .sd = (disc_radius_mm + contact_mm.norm()) * lip.slope_sd,
          .identifiable = true};
}

}  // namespace

Expected<SpanReading> MeasureLedge(Session* session,
                                   const Artefact& ledge,
                                   const SpanPlan& plan) {
  const std::vector<Face> faces = FacesForSpan(ledge, plan);
  const Face& bottom = faces[0].from_below ? faces[0] : faces[1];
  const Face& top = faces[0].from_below ? faces[1] : faces[0];
  if (const auto fitted = Fit(session, "disc"); !fitted) {
    return tl::unexpected(fitted.error());
  }
  const auto lip = TouchTop(session, top, plan);
  if (!lip) return tl::unexpected(lip.error());
  const auto below = session->probing().Touch(
      bottom, {.repeats = plan.repeats, .campaign = plan.campaign});
  if (!below) return tl::unexpected(below.error());
  if (const auto fitted = Fit(session, "ball"); !fitted) {
    return tl::unexpected(fitted.error());
  }

  const Uncertain under_mm = MeanOf(session, Axis::kZ, below->trigger_mm);
  const Uncertain tilt_mm =
      TiltShare(ledge, bottom, *lip, session->bench().machine.probe.disc_radius_mm);
  SpanReading reading;
  reading.size_mm = {.value = ledge.size_mm[2], .sd = MmFromUm(ledge.u_um)};
  reading.span_mm = {
      .value = ledge.size_mm[2] + lip->top_mm.value + under_mm.value - tilt_mm.value,
      .sd = std::hypot(lip->top_mm.sd, under_mm.sd, tilt_mm.sd)};
  reading.faces = lip->touches;
  reading.faces.push_back(*below);
  session->Tell(fmt::format(
      "The lip lies tilted by {:.2f} mrad; that alone would read {:+.1f} um, "
      "taken off.",
      MradFromRad(lip->slope.norm()),
      UmFromMm(tilt_mm.value)));
  return reading;
}

}  // namespace caltwin
