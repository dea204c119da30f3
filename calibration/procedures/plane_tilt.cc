#include "calibration/procedures/plane_tilt.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/tilt_plane.h"
#include "calibration/procedures/scale_doubt.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kPastArtefact_mm = 15;  // Between a point and what stands beside it.

bool IsClear(const Bench& bench, const Vec3<double>& at_mm, const std::string& plate) {
  return std::ranges::none_of(bench.artefacts, [&](const Artefact& artefact) {
    if (artefact.id == plate) return false;
    // Walls of holes are 15 mm thick; blocks may be turned to their longest side.
    const double reach_mm = artefact.type == ArtefactType::kBlock123
                                ? kBlockSizes_mm[2] / 2
                                : artefact.size_mm.head<2>().maxCoeff() / 2 + 15;
    const Vec3<double> off_mm = at_mm - artefact.at_mm;
    return std::max(std::abs(off_mm[0]), std::abs(off_mm[1])) <
           reach_mm + kPastArtefact_mm;
  });
}

// What both slopes' errors have in common: where they were touched, and z's steps/mm.
void CorrelateSlopes(Session* session, const TiltPlane& plane) {
  if (!plane.slope_x.identifiable || !plane.slope_y.identifiable) return;
  const Given z = ScaleOf(session, Axis::kZ);
  const auto widened = [&](const Uncertain& slope, Axis along) {
    return CombinedU(WithScaleDoubt(slope, ScaleOf(session, along), z).budget);
  };
  const double x = widened(plane.slope_x, Axis::kX),
               y = widened(plane.slope_y, Axis::kY);
  const double both =
      plane.slope_covariance + plane.slope_x.value * plane.slope_y.value * z.sd * z.sd;
  session->Correlate({"bed_tilt.slope_x_mrad", "bed_tilt.slope_y_mrad"},
                     Eigen::Matrix2d{{x * x, both}, {both, y * y}});
}

}  // namespace

std::vector<Face> TiltGrid(Session* session, const PlaneTiltOptions& o) {
  const Bench& bench = session->bench();
  const Artefact* plate =
      SeekArtefact(&session->bench(), o.artefact, {ArtefactType::kPlate}, o.place);
  Eigen::Vector2d low_mm, high_mm;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const int i = Index(axis);
    const AxisDrawing& drawing = bench.machine.axis(axis);
    low_mm[i] = drawing.min_mm;
    high_mm[i] = drawing.max_mm;
    if (plate != nullptr) {
      const double half_mm = plate->size_mm[i] / 2;
      low_mm[i] = std::max(low_mm[i], plate->at_mm[i] - half_mm);
      high_mm[i] = std::min(high_mm[i], plate->at_mm[i] + half_mm);
    }
    low_mm[i] += o.margin_mm;
    high_mm[i] -= o.margin_mm;
  }
  std::vector<Face> faces;
  for (int row = 0; row < o.rows; ++row) {
    for (int column = 0; column < o.columns; ++column) {
      const double u = o.columns == 1 ? 0.5 : double(column) / (o.columns - 1);
      const double v = o.rows == 1 ? 0.5 : double(row) / (o.rows - 1);
      Face face = TableAt(low_mm[0] + u * (high_mm[0] - low_mm[0]),
                          low_mm[1] + v * (high_mm[1] - low_mm[1]));
      if (plate != nullptr) {
        face.artefact = plate->id;
        face.feature = plate->id + ".top";
        face.at_mm[2] = Top_mm(*plate);
      }
      if (IsClear(bench, face.at_mm, face.artefact)) faces.push_back(face);
    }
  }
  return faces;
}

Expected<void> RunPlaneTilt(Session* session, const PlaneTiltOptions& o) {
  std::vector<Vec3<double>> points_mm;
  std::vector<Touched> touches;
  for (const Face& face : TiltGrid(session, o)) {
    const auto touched = session->probing().Touch(
        face, {.repeats = o.repeats, .campaign = "plane_tilt"});
    if (!touched) return tl::unexpected(touched.error());
    Vec3<double> point_mm = face.at_mm;
    point_mm[2] = face.at_mm[2] + Mean(touched->trigger_mm);
    points_mm.push_back(point_mm);
    touches.push_back(*touched);
  }
  const double sigma_mm = MeanSd_mm(NoiseOf(session, Axis::kZ, touches), o.repeats);
  const TiltPlane plane = FitTiltPlane(points_mm, std::max(sigma_mm, 1e-9));
  const auto conclude = [&](const std::string& which, Axis along, Uncertain slope) {
    slope = WithScaleDoubt(slope, ScaleOf(session, along), ScaleOf(session, Axis::kZ));
    slope = Scaled(std::move(slope), MradFromRad(1.0));
    const std::string name = "bed_tilt." + which;
    session->Measured(name, slope.value, "Slope of the plane through the touches.");
    session->Conclude(name, "mrad", slope);
  };
  conclude("slope_x_mrad", Axis::kX, plane.slope_x);
  conclude("slope_y_mrad", Axis::kY, plane.slope_y);
  CorrelateSlopes(session, plane);
  if (!plane.slope_x.identifiable) {
    session->Tell("A plane needs three touches that do not lie on one line.");
    session->End(Ending::kConfounded);
    return {};
  }
  session->Tell(
      fmt::format("{} touches leave {:.2f} um rms about the plane, {:.2f} um "
                  "at worst{}.",
                  points_mm.size(),
                  UmFromMm(plane.rms_mm),
                  UmFromMm(plane.worst_mm),
                  plane.dof > 0 ? ""
                                : ": three points fit exactly, which "
                                  "says nothing of flatness"));
  return {};
}

PlaneTiltOptions ReadPlaneTilt(YamlMap* map) {
  PlaneTiltOptions o;
  o.place = map->place();
  map->WordOr("variant", "corrected", {"as_published", "corrected"});
  o.artefact = map->TextOr("artefact", "");
  if (const auto grid = map->Optional("grid")) {
    const auto counts = grid->Numbers(2, {1, 100});
    o.columns = static_cast<int>(counts[0]);
    o.rows = static_cast<int>(counts[1]);
  }
  o.repeats = static_cast<int>(map->IntegerOr("repeats", 2, 1, 1000));
  o.margin_mm = map->NumberOr("margin_mm", 20, {0, 1000});
  return o;
}

namespace {

PreparedProcedure PreparePlaneTilt(YamlMap map, const Machine& /*drawing*/) {
  const PlaneTiltOptions o = ReadPlaneTilt(&map);
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench, "plane_tilt", "corrected", {});
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunPlaneTilt(&session, o));
  };
}

}  // namespace

constinit const Procedure kPlaneTilt{
    .name = "plane_tilt",
    .about = "Tilt of a plate or the table by a grid of touches.",
    .source = "Levelling by a probed plane, in every public firmware.",
    .published =
        "z = a x + b y + c through the touched points; the angles are the "
        "arctangents of a and b.",
    .physics =
        "Least squares with covariance; slopes in mrad, + rises towards +x and "
        "+y. Pre-travel and tip lift all points alike and cancel. Three points "
        "fit exactly, so their residual proves nothing.",
    .has_variants = false,
    .prepare = PreparePlaneTilt,
    .drives = DrivesAsked::kAny};

}  // namespace caltwin
