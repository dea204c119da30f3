#include "calibration/procedures/ledge.h"

#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "calibration/estimate/tilt_plane.h"
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

Expected<void> FitLedge(Session* session, const std::string& stylus) {
  if (const auto raised = session->probing().Raise(); !raised) return raised;
  return session->bench().person->Do({.kind = Act::Kind::kFitStylus,
                                      .text = fmt::format("Fit the {} stylus.", stylus),
                                      .artefact = stylus});
}

Expected<Lip> TouchTop(Session* session, const Face& top, const SpanPlan& plan) {
  Lip lip;
  for (const auto& [x, y] :
       std::array<std::array<int, 2>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    Face corner = top;
    corner.at_mm += Vec3<double>(x, y, 0) * kCorner_mm;
    const auto touched = session->probing().Touch(
        corner, {.repeats = plan.repeats, .campaign = plan.campaign});
    if (!touched) return tl::unexpected(touched.error());
    lip.touches.push_back(*touched);
  }
  const TouchNoise noise = NoiseOf(session, Axis::kZ, lip.touches);
  std::vector<Vec3<double>> points_mm;
  for (const Touched& touched : lip.touches) {
    const Vec3<double>& at_mm = touched.face.at_mm;
    points_mm.emplace_back(at_mm[0], at_mm[1], Mean(touched.trigger_mm));
  }
  const double sd_mm = MeanSd_mm(noise, plan.repeats);
  const TiltPlane plane = FitTiltPlane(points_mm, std::max(sd_mm, 1e-9), top.at_mm);
  lip.top_mm = plane.height_mm;
  lip.slope = {plane.slope_x.value, plane.slope_y.value};
  lip.slope_sd = plane.slope_x.sd;
  return lip;
}

// What a slope adds to the readings along the outward normals, above and below.
struct TiltReads {
  double rim_mm = 0;        // Above: the disc meets the lip at its rim.
  double underside_mm = 0;  // Below: where the underside hangs lowest over the disc.
  double reach_mm = 0;      // How far off the lip's middle both happen, at most.
};

TiltReads ReadsOf(const Artefact& ledge,
                  const Eigen::Vector2d& below_mm,
                  const Eigen::Vector2d& slope,
                  double disc_radius_mm) {
  const double turn_rad = RadFromDeg(ledge.turn_deg);
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  Eigen::Matrix2d local;  // From the machine's axes to the artefact's.
  local << c, s, -s, c;
  const Eigen::Vector2d local_slope = local * slope;
  const Eigen::Vector2d contact_mm =
      FirstContact_mm({.disc_mm = local * (below_mm - ledge.at_mm.head<2>()),
                       .radius_mm = disc_radius_mm,
                       .half_mm = ledge.size_mm.head<2>() / 2},
                      -local_slope);
  return {.rim_mm = disc_radius_mm * local_slope.norm(),
          .underside_mm = -local_slope.dot(contact_mm),
          .reach_mm = disc_radius_mm + contact_mm.norm()};
}

bool IsOf(const Row& row, const Artefact& ledge, const std::string& face) {
  return row.kind == RowKind::kTouch && row.feature == ledge.id + "." + face;
}

}  // namespace

Expected<SpanReading> MeasureLedge(Session* session,
                                   const Artefact& ledge,
                                   const SpanPlan& plan) {
  const std::vector<Face> faces = FacesForSpan(ledge, plan);
  const Face& bottom = faces[0].from_below ? faces[0] : faces[1];
  const Face& top = faces[0].from_below ? faces[1] : faces[0];
  if (const auto fitted = FitLedge(session, "disc"); !fitted) {
    return tl::unexpected(fitted.error());
  }
  const auto lip = TouchTop(session, top, plan);
  if (!lip) return tl::unexpected(lip.error());
  const auto below = session->probing().Touch(
      bottom, {.repeats = plan.repeats, .campaign = plan.campaign});
  if (!below) return tl::unexpected(below.error());
  if (const auto fitted = FitLedge(session, "ball"); !fitted) {
    return tl::unexpected(fitted.error());
  }

  const TouchNoise noise = NoiseOf(session, Axis::kZ, std::span(&*below, 1));
  const Uncertain under_mm = MeanTouch_mm(below->trigger_mm, noise);
  const TiltReads tilt = ReadsOf(ledge,
                                 bottom.at_mm.head<2>(),
                                 lip->slope,
                                 session->bench().machine.probe.disc_radius_mm);
  const double tilt_mm = tilt.rim_mm + tilt.underside_mm;
  SpanReading reading;
  reading.size_mm = {.value = ledge.size_mm[2],
                     .sd = MmFromUm(ledge.u_um),
                     .source = SizeOf(ledge, Axis::kZ)};
  reading.span_mm = {
      .value = ledge.size_mm[2] + lip->top_mm.value + under_mm.value - tilt_mm,
      .sd = std::hypot(lip->top_mm.sd, under_mm.sd, tilt.reach_mm * lip->slope_sd)};
  reading.faces = lip->touches;
  reading.faces.push_back(*below);
  session->Tell(fmt::format(
      "The lip lies tilted by {:.2f} mrad; that alone would read {:+.1f} um, "
      "taken off.",
      MradFromRad(lip->slope.norm()),
      UmFromMm(tilt_mm)));
  return reading;
}

void LevelLedge(const Artefact& ledge,
                double disc_radius_mm,
                const std::vector<Row>& rows,
                std::vector<Observation>* observations) {
  std::vector<Vec3<double>> tops_mm;
  for (const Row& row : rows) {
    if (!IsOf(row, ledge, "top")) continue;
    tops_mm.emplace_back(row.cmd_mm[0], row.cmd_mm[1], row.value_mm);
  }
  const TiltPlane plane = FitTiltPlane(tops_mm, /*sigma_mm=*/0.001, ledge.at_mm);
  if (!plane.slope_x.identifiable || !plane.slope_y.identifiable) return;
  const Eigen::Vector2d slope(plane.slope_x.value, plane.slope_y.value);
  const Eigen::Vector2d middle_mm = ledge.at_mm.head<2>();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool top = IsOf(rows[i], ledge, "top");
    if (!top && !IsOf(rows[i], ledge, "bottom")) continue;
    const Eigen::Vector2d at_mm(rows[i].cmd_mm[0], rows[i].cmd_mm[1]);
    const TiltReads tilt = ReadsOf(ledge, at_mm, slope, disc_radius_mm);
    Observation& observation = (*observations)[i];
    observation.value_mm -=
        top ? tilt.rim_mm + slope.dot(at_mm - middle_mm) : tilt.underside_mm;
    observation.at.q_mm.head<2>() = middle_mm;
  }
}

}  // namespace caltwin
