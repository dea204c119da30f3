#include "calibration/kinds/triple_z/doing.h"

#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/kinds/triple_z/missed_touch.h"
#include "calibration/kinds/triple_z/troubles.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

Estimate SlopeEstimate(const std::string& name, const Uncertain& slope) {
  const Uncertain in_mrad = Scaled(slope, MradFromRad(1.0));
  return {.name = name,
          .unit = "mrad",
          .value = in_mrad.value,
          .sd = in_mrad.sd,
          .identifiable = in_mrad.identifiable,
          .budget = in_mrad.budget};
}

// The grid that has a point in the middle of each cell of the probed one.
std::vector<Eigen::Vector2d> CellMiddles(const TripleZBench& bench,
                                         const TripleZOptions& o) {
  std::vector<Eigen::Vector2d> middles;
  const Eigen::Vector2d cells(o.columns - 1, o.rows - 1);
  const Eigen::Vector2d from_mm = Eigen::Vector2d::Constant(o.margin_mm);
  const Eigen::Vector2d cell_mm = (bench.most_mm - 2 * from_mm).cwiseQuotient(cells);
  for (int j = 0; j < o.rows - 1; ++j) {
    for (int i = 0; i < o.columns - 1; ++i) {
      const Eigen::Vector2d at(i + 0.5, j + 0.5);
      middles.emplace_back(from_mm + at.cwiseProduct(cell_mm));
    }
  }
  return middles;
}

}  // namespace

std::vector<Eigen::Vector2d> PointsOf(const TripleZPrinter& printer,
                                      const TripleZOptions& o) {
  const TripleZBench& bench = printer.bench();
  if (!o.at_screws) return ProbeGrid(bench, o.columns, o.rows, o.margin_mm);
  return {bench.drawn_mm.begin(), bench.drawn_mm.end()};
}

namespace {

// Touches all places; where one fails, says why by what the others read.
std::optional<std::vector<BedTouch>> TouchAll(
    TripleZPrinter* printer, const std::vector<Eigen::Vector2d>& places, Doing* doing) {
  std::vector<BedTouch> touches;
  for (const Eigen::Vector2d& at_mm : places) {
    const auto height_mm = printer->Probe(at_mm);
    if (!height_mm) {
      doing->Fail(height_mm.error());
      const std::string why =
          AskWhyNoHeight(printer, at_mm, touches, height_mm.error());
      if (!why.empty()) doing->Say({why, Message::Kind::kCause});
      return std::nullopt;
    }
    touches.push_back({at_mm, *height_mm});
  }
  return touches;
}

// As published the list, whatever the touches show; corrected what they show.
void SayWhyOffPlane(TripleZPrinter* printer,
                    const TripleZOptions& o,
                    const BedPlane& plane,
                    std::span<const BedTouch> touches,
                    Doing* doing) {
  if (!plane.is_told()) return;
  if (o.is_as_published) {
    const std::string list = HighResidualAsPublished(plane);
    if (!list.empty()) doing->Say(list);
    return;
  }
  const auto off = WhyOffPlane(touches, Unsuspected_mm(printer->bench()));
  if (off) doing->Say({TouchAgain(printer, *off, touches), Message::Kind::kCause});
}

}  // namespace

std::optional<BedPlane> ProbePlane(TripleZPrinter* printer,
                                   const TripleZOptions& o,
                                   Doing* doing,
                                   std::vector<BedTouch>* touches) {
  auto touched = TouchAll(printer, PointsOf(*printer, o), doing);
  if (!touched) return std::nullopt;
  *touches = *std::move(touched);
  const BedPlane plane = FitBedPlane(
      *touches, printer->bench().sigma_mm, printer->bench().is_sigma_stated);
  if (doing->done().plane) return plane;
  doing->done().plane = plane;
  auto& result = doing->done().result;
  result.estimates.push_back(SlopeEstimate("bed_tilt.slope_x_mrad", plane.fit.slope_x));
  result.estimates.push_back(SlopeEstimate("bed_tilt.slope_y_mrad", plane.fit.slope_y));
  if (plane.is_told()) {
    const double x = plane.fit.slope_x.sd, y = plane.fit.slope_y.sd;
    const double both = plane.fit.slope_covariance;
    doing->Correlate({"bed_tilt.slope_x_mrad", "bed_tilt.slope_y_mrad"},
                     Eigen::Matrix2d{{x * x, both}, {both, y * y}});
  }
  doing->Say(fmt::format(
      "plane z = {:.6f} x {:+.6f} y {:+.4f} from {} points, residual {:.4f} mm; tilt "
      "{:.4f} deg along x, {:.4f} along y, {:.4f} in all",
      plane.a(),
      plane.b(),
      plane.c_mm(),
      plane.points,
      plane.fit.rms_mm,
      plane.TiltX_deg(),
      plane.TiltY_deg(),
      plane.Tilt_deg()));
  doing->SayAll(PlaneVerdicts(plane));
  SayWhyOffPlane(printer, o, plane, *touches, doing);
  return plane;
}

std::string WordsOfLevel(const LevelReport& report) {
  return fmt::format(
      "validation of {} points: mean {:.4f} mm, max {:.4f}, standard deviation "
      "{:.4f}{}",
      report.count,
      report.mean_mm,
      report.max_mm,
      report.std_mm,
      report.mean_mm < 0.1 ? "" : "; above the 0.1 mm that are asked");
}

bool HoldOut(TripleZPrinter* printer,
             const TripleZOptions& o,
             const BedPlane& expected,
             Doing* doing) {
  if (!o.holds_out || doing->done().result.ending != Ending::kDone) return true;
  auto touches = doing->Got(printer->ProbeAll(CellMiddles(printer->bench(), o)));
  if (!touches) return false;
  for (BedTouch& touch : *touches) touch.height_mm -= expected.At_mm(touch.at_mm);
  const LevelReport report = ReportLevel(*touches, 0);
  doing->done().hold_out = report;
  doing->Say(fmt::format(
      "hold-out: {} points that were not fitted: mean {:.4f} mm, max {:.4f}",
      report.count,
      report.mean_mm,
      report.max_mm));
  return true;
}

bool IsSmallEnough(const Vec3<double>& raise_mm,
                   const TripleZOptions& o,
                   Doing* doing) {
  const double most_mm = raise_mm.cwiseAbs().maxCoeff();
  if (most_mm <= o.largest_mm) return true;
  doing->Refuse(
      fmt::format("a screw would be moved by {:.3f} mm, more than {:g} (largest_mm): "
                  "not done",
                  most_mm,
                  o.largest_mm));
  return false;
}

BedPlane LevelPlane(double level_mm) {
  BedPlane plane;
  plane.fit.height_mm.value = level_mm;
  return plane;
}

namespace {

// Touches with one screw moved alone, and put back. Where the bed comes too near or too
// far to be touched it is moved by less.
std::optional<RaisedTouches> TryScrew(TripleZPrinter* printer,
                                      const std::vector<Eigen::Vector2d>& points,
                                      const Vec3<double>& test_mm,
                                      Doing* doing) {
  constexpr double kLeastPart = 0.25;
  for (double part = 1;; part /= 2) {
    const Vec3<double> up_mm = part * test_mm;
    if (!doing->Did(printer->Raise(up_mm))) return std::nullopt;
    auto touches = printer->ProbeAll(points);
    const bool is_untouched =
        !touches && (touches.error().kind == MachineFault::Kind::kNoTrigger ||
                     touches.error().kind == MachineFault::Kind::kRefused);
    if ((touches || is_untouched) && !doing->Did(printer->Raise(-up_mm))) {
      return std::nullopt;
    }
    if (touches) return RaisedTouches{up_mm, *std::move(touches)};
    if (!is_untouched || part <= kLeastPart) {
      doing->Fail(touches.error());
      return std::nullopt;
    }
  }
}

}  // namespace

std::optional<std::vector<RaisedTouches>> TryScrews(TripleZPrinter* printer,
                                                    const TripleZOptions& o,
                                                    Doing* doing) {
  const auto points = ProbeGrid(printer->bench(), 3, 3, o.margin_mm);
  auto as_found = TouchAll(printer, points, doing);
  if (!as_found) return std::nullopt;
  std::vector<RaisedTouches> stands = {{Vec3<double>::Zero(), *std::move(as_found)}};
  for (int i = 0; i < kNumScrews; ++i) {
    auto tried = TryScrew(printer, points, o.test_mm * Vec3<double>::Unit(i), doing);
    if (!tried) return std::nullopt;
    stands.push_back(*std::move(tried));
  }
  return stands;
}

std::map<std::string, double> AlongBoth(const std::string& one,
                                        const std::string& two) {
  return {{one, std::sqrt(0.5)}, {two, std::sqrt(0.5)}};
}

}  // namespace caltwin
