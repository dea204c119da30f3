// Campaigns on a delta: touches of its bed, marks on a plate, columns of heights.

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

constexpr double kMoveFeed_mm_s = 40;
constexpr double kLift_mm = 6;
constexpr double kSideways_mm = 8;
constexpr double kDwell_s = 2;
constexpr double kLowest_mm = 8;
constexpr double kMarksOut = 0.7;  // Of the disc: half a square's side in it.
constexpr double kColumnsOut = 0.85;

double RadiusOf_mm(const PlannedCampaign& campaign, const MeasuringSession& session) {
  const double said_mm = campaign.options.Number("radius_mm");
  return said_mm > 0 ? said_mm : DeltaOf(session.machine()).print_radius_mm;
}

Vec3<double> OnCircle(double radius_mm, double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return {
      Rounded(radius_mm * std::cos(angle)), Rounded(radius_mm * std::sin(angle)), 0};
}

Row BedTouchRow(const PlannedCampaign&, const Vec3<double>& at_mm, int rep) {
  Row row = TouchOf("bed", "bed.top", at_mm, {0, 0, 1});
  row.rep = rep;
  return row;
}

Row GaugeRow(const std::string& setup, const std::string& feature, Axis along) {
  Row row{.kind = RowKind::kPosition, .setup = setup};
  row.n = {0, 0, 0};
  row.n[static_cast<std::size_t>(Index(along))] = 1;
  row.feature = feature;
  return row;
}

}  // namespace

void PlanDeltaGrid(const PlannedCampaign& campaign, MeasuringSession* session) {
  const double golden_turns = (3 - std::sqrt(5.0)) / 2;
  const int points = campaign.options.Count("points");
  const double radius_mm = RadiusOf_mm(campaign, *session);
  std::vector<Row> rows;
  for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
    for (int i = 0; i < points; ++i) {
      const double out_mm = radius_mm * std::sqrt(i / (points - 1.0));
      rows.push_back(BedTouchRow(campaign, OnCircle(out_mm, golden_turns * i), rep));
    }
  }
  TouchAll(rows, campaign.options.Numbers("feeds_mm_s"), session);
}

void PlanDeltaRing(const PlannedCampaign& campaign, MeasuringSession* session) {
  for (const char* option : {"diameter_mm", "spindle_deg", "height_mm", "at_mm"}) {
    if (!campaign.options.is_written(option)) continue;
    session->Fail(fmt::format("has no {} on a delta", option),
                  "it touches the bed on three circles: points, repeats, feeds_mm_s");
  }
  const int points = campaign.options.Count("points");
  const double radius_mm = DeltaOf(session->machine()).print_radius_mm;
  std::vector<Row> rows;
  for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
    for (const double share : {1.0 / 3, 2.0 / 3, 1.0}) {
      for (int i = 0; i < points; ++i) {
        const auto turns = static_cast<double>(i) / points;
        rows.push_back(BedTouchRow(campaign, OnCircle(share * radius_mm, turns), rep));
      }
    }
  }
  TouchAll(rows, campaign.options.Numbers("feeds_mm_s"), session);
}

void PlanDeltaXy(const PlannedCampaign& campaign, MeasuringSession* session) {
  const int side = campaign.options.Count("points");
  const double half_mm = kMarksOut * RadiusOf_mm(campaign, *session);
  int laid = 0;
  for (const double height_mm : campaign.options.Numbers("heights_mm")) {
    const std::string setup = fmt::format("{}_{}", campaign.name, ++laid);
    std::vector<Vec3<double>> marks_mm;
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        marks_mm.emplace_back(Rounded(half_mm * (2.0 * i / (side - 1) - 1)),
                              Rounded(half_mm * (2.0 * j / (side - 1) - 1)),
                              height_mm);
      }
    }
    Shuffle(&marks_mm, session->rng());
    for (const Vec3<double>& mark_mm : marks_mm) {
      session->RequireReach(mark_mm);
      // From any side, so that each carriage comes up as often as down.
      session->Rapid(mark_mm + OnCircle(kSideways_mm, session->rng()->Uniform()));
      session->MoveTo(mark_mm, kMoveFeed_mm_s);
      for (const Axis along : {Axis::kX, Axis::kY}) {
        session->ReadGauge(GaugeRow(setup, "plate.marks", along), kDwell_s);
      }
    }
  }
}

void PlanZColumns(const PlannedCampaign& campaign, MeasuringSession* session) {
  const double radius_mm = RadiusOf_mm(campaign, *session);
  const int places = campaign.options.Count("places");
  const int heights = campaign.options.Count("heights");
  const double said_mm = campaign.options.Number("to_mm");
  if (said_mm > 0 && said_mm <= kLowest_mm) {
    session->Fail(fmt::format("has to_mm = {:g}: columns begin {:g} mm above the bed",
                              said_mm,
                              kLowest_mm),
                  "approached from below, a gauge needs room");
  }
  const double top_mm = said_mm > 0 ? said_mm : kLowest_mm + radius_mm;
  for (int place = 0; place < places; ++place) {
    const double turns = (place - 1.0) / std::max(places - 1, 1);
    const Vec3<double> foot_mm =
        OnCircle(place == 0 ? 0 : kColumnsOut * radius_mm, turns);
    const std::string setup = fmt::format("{}_{}", campaign.name, place + 1);
    for (int i = 0; i < heights; ++i) {
      Vec3<double> at_mm = foot_mm;
      at_mm[2] = Rounded(kLowest_mm + (top_mm - kLowest_mm) * i / (heights - 1));
      session->RequireReach(at_mm);
      for (const double from_mm : {kLift_mm, -kLift_mm}) {
        session->Rapid(at_mm + Vec3<double>(0, 0, from_mm));
        session->MoveTo(at_mm, kMoveFeed_mm_s);
        session->ReadGauge(GaugeRow(setup, "", Axis::kZ), kDwell_s);
      }
    }
  }
}

}  // namespace caltwin
