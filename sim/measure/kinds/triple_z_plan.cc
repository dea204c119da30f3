// Campaigns on a triple-Z printer: touches of its bed, columns of heights, single
// screws.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

constexpr double kLift_mm = 6;
constexpr double kLowest_mm = 8;  // Approached from below, a sensor needs room.
constexpr double kMoveFeed_mm_s = 10;
constexpr double kDwell_s = 2;

// Along one axis: from margin to margin.
double PlaceAlong_mm(const AxisDrawing& axis, double margin_mm, int i, int count) {
  const double from_mm = axis.min_mm + margin_mm, to_mm = axis.max_mm - margin_mm;
  return Rounded(from_mm + (to_mm - from_mm) * i / (count - 1));
}

std::vector<Vec3<double>> BedPoints_mm(const PlannedCampaign& campaign,
                                       const MeasuringSession& session) {
  const auto [columns, rows] = GridOf(campaign, session);
  const double margin_mm = campaign.options.Number("margin_mm");
  const AxisDrawing& x = session.machine().axis(Axis::kX);
  const AxisDrawing& y = session.machine().axis(Axis::kY);
  if (2 * margin_mm >= std::min(x.travel_mm(), y.travel_mm())) {
    session.Fail(fmt::format("has margin_mm = {:g}: nothing is left", margin_mm),
                 "choose a smaller margin");
  }
  std::vector<Vec3<double>> points_mm;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      points_mm.emplace_back(PlaceAlong_mm(x, margin_mm, i, columns),
                             PlaceAlong_mm(y, margin_mm, j, rows),
                             0);
    }
  }
  return points_mm;
}

// From the lowest to the highest in even steps, each moved by up to half a lead.
std::vector<double> Heights_mm(const PlannedCampaign& campaign,
                               MeasuringSession* session) {
  const AxisDrawing& z = session->machine().axis(Axis::kZ);
  const double said_mm = campaign.options.Number("to_mm");
  const double top_mm = said_mm > 0 ? said_mm : z.max_mm - kLift_mm - z.lead_mm;
  if (top_mm <= kLowest_mm) {
    session->Fail(fmt::format("has to_mm = {:g}: columns begin {:g} mm above the bed",
                              said_mm,
                              kLowest_mm),
                  "approached from below, a sensor needs room");
  }
  const int count = campaign.options.Count("heights");
  std::vector<double> heights_mm;
  for (int i = 0; i < count; ++i) {
    const double even_mm = kLowest_mm + (top_mm - kLowest_mm) * i / (count - 1);
    heights_mm.push_back(
        Rounded(even_mm + z.lead_mm * (session->rng()->Uniform() - 0.5)));
  }
  return heights_mm;
}

void ReadColumn(const Row& row,
                const Eigen::Vector2d& at_mm,
                const std::vector<double>& heights_mm,
                MeasuringSession* session) {
  for (const double height_mm : heights_mm) {
    const Vec3<double> q_mm(at_mm[0], at_mm[1], height_mm);
    session->RequireReach(q_mm);
    for (const double from_mm : {kLift_mm, -kLift_mm}) {
      session->Rapid(q_mm + Vec3<double>(0, 0, from_mm));
      session->MoveTo(q_mm, kMoveFeed_mm_s);
      session->ReadGauge(row, kDwell_s);
    }
  }
}

Row HeightGauge(const std::string& setup, const std::string& feature) {
  Row row{.kind = RowKind::kPosition, .setup = setup};
  row.n = {0, 0, 1};
  row.feature = feature;
  return row;
}

}  // namespace

void PlanTzGrid(const PlannedCampaign& campaign, MeasuringSession* session) {
  const auto points_mm = BedPoints_mm(campaign, *session);
  const auto& offsets_mm = campaign.options.Numbers("probe_offset_mm");
  for (const double offset_mm : offsets_mm) {
    const bool is_told = offsets_mm.size() > 1 || offset_mm != 0;
    std::vector<Row> rows;
    for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
      for (const Vec3<double>& at_mm : points_mm) {
        rows.push_back(TouchOf("bed", "bed.top", at_mm, Unit(Axis::kZ)));
        rows.back().rep = rep;
        if (is_told) rows.back().probe_off_mm = {0, offset_mm, 0};
      }
    }
    TouchAll(rows, campaign.options.Numbers("feeds_mm_s"), session);
  }
}

void PlanTzHeights(const PlannedCampaign& campaign, MeasuringSession* session) {
  auto points_mm = BedPoints_mm(campaign, *session);
  Shuffle(&points_mm, session->rng());
  for (const Vec3<double>& at_mm : points_mm) {
    ReadColumn(HeightGauge(campaign.name, "bed.top"),
               at_mm.head<2>(),
               Heights_mm(campaign, session),
               session);
  }
}

void PlanFixedPost(const PlannedCampaign& campaign, MeasuringSession* session) {
  for (int i = 0; i < kNumScrews; ++i) {
    const std::string setup = fmt::format("{}_{}", campaign.name, ScrewName(i));
    const auto& screw =
        TripleZOf(session->machine()).screws[static_cast<std::size_t>(i)];
    session->Wait(campaign.options.Number("pause_s"));  // The post is stood elsewhere.
    ReadColumn(HeightGauge(setup, "post.bed"),
               screw.at_mm,
               Heights_mm(campaign, session),
               session);
  }
  session->Certify("post", {.type = "post"});
}

void PlanScrewsOneByOne(const PlannedCampaign& campaign, MeasuringSession* session) {
  const double travel_mm = campaign.options.Number("travel_mm");
  const auto points_mm = BedPoints_mm(campaign, *session);
  const auto touch_all = [&](const Vec3<double>& raised_mm) {
    session->SetScrews(raised_mm);
    std::vector<Row> rows;
    for (const Vec3<double>& at_mm : points_mm) {
      rows.push_back(TouchOf("bed", "bed.top", at_mm, Unit(Axis::kZ)));
    }
    TouchAll(rows, campaign.options.Numbers("feeds_mm_s"), session);
  };
  touch_all(Vec3<double>::Zero());
  for (int screw = 0; screw < kNumScrews; ++screw) {
    for (const double by_mm : {travel_mm, -travel_mm}) {
      touch_all(by_mm * Vec3<double>::Unit(screw));
    }
  }
  session->SetScrews(Vec3<double>::Zero());
}

}  // namespace caltwin
