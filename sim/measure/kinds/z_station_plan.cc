// Campaigns at a printer's station: the touches of a nozzle's calibration, and the gap
// that it leaves.

#include <array>

#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_touching.h"

namespace caltwin {
namespace {

constexpr double kCalibration_s = 45;
constexpr double kFeeler_s = 20;

struct Temperatures {
  double nozzle_c = 20, bed_c = 20, chamber_c = 20;
};

// One choice a round: all there are, in an order of chance, and again from the first.
std::vector<Temperatures> Choices(const PlannedCampaign& campaign,
                                  MeasuringSession* session) {
  std::vector<Temperatures> choices;
  for (const double nozzle_c : campaign.options.Numbers("nozzle_c")) {
    for (const double bed_c : campaign.options.Numbers("bed_c")) {
      for (const double chamber_c : campaign.options.Numbers("chamber_c")) {
        choices.push_back({nozzle_c, bed_c, chamber_c});
      }
    }
  }
  if (choices.empty()) {
    session->Fail("has an empty list of temperatures",
                  "nozzle_c, bed_c and chamber_c each need one, as in [25]");
  }
  Shuffle(&choices, session->rng());
  return choices;
}

void HoldAll(const Temperatures& at, MeasuringSession* session) {
  session->HoldAt(Sensor::kNozzle, at.nozzle_c);
  session->HoldAt(Sensor::kBed, at.bed_c);
  session->HoldAt(Sensor::kChamber, at.chamber_c);
}

void NoteWiping(const PlannedCampaign& campaign, Row* row) {
  if (campaign.options.Flag("wiped")) row->nozzle_wiped = 1;
}

// For every round: its temperatures reached and soaked.
template <typename Measure>
void ForEveryRound(const PlannedCampaign& campaign,
                   MeasuringSession* session,
                   const Measure& measure) {
  const auto choices = Choices(campaign, session);
  const int rounds = campaign.options.Count("rounds");
  for (int round = 0; round < rounds; ++round) {
    HoldAll(choices[static_cast<std::size_t>(round) % choices.size()], session);
    session->Wait(campaign.options.Number("soak_s"));
    measure(round);
  }
}

}  // namespace

void PlanZOffset(const PlannedCampaign& campaign, MeasuringSession* session) {
  const ZStationDrawing& drawing = ZStationOf(session->machine());
  ForEveryRound(campaign, session, [&](int round) {
    if (campaign.options.Flag("homes") || round == 0) session->Home();
    for (const ZReading reading :
         {ZReading::kNozzleOnSwitch, ZReading::kBodyOnSwitch, ZReading::kProbeOnBed}) {
      const Eigen::Vector2d place_mm = drawing.PlaceOf_mm(reading);
      const Vec3<double> at_mm(place_mm[0], place_mm[1], drawing.Nominal_mm(reading));
      for (int rep = 1; rep <= campaign.options.Count("repeats"); ++rep) {
        const std::string feature(FeatureOf(reading));
        Row row = TouchOf(feature, feature, at_mm, Unit(Axis::kZ));
        row.rep = rep;
        NoteWiping(campaign, &row);
        row.feed_mm_s = campaign.options.Number("feed_mm_s");
        session->Touch(std::move(row));
      }
    }
  });
}

void PlanZGap(const PlannedCampaign& campaign, MeasuringSession* session) {
  const Eigen::Vector2d place_mm =
      ZStationOf(session->machine()).PlaceOf_mm(ZReading::kGapUnderNozzle);
  ForEveryRound(campaign, session, [&](int) {
    session->Home();
    session->Wait(kCalibration_s);
    for (const double height_mm : campaign.options.Numbers("heights_mm")) {
      const Vec3<double> at_mm(place_mm[0], place_mm[1], height_mm);
      session->RequireReach(at_mm);
      session->Rapid(at_mm);
      Row row{.kind = RowKind::kPosition,
              .setup = std::string(FeatureOf(ZReading::kGapUnderNozzle))};
      row.feature = row.setup;
      row.n = {0, 0, 1};
      NoteWiping(campaign, &row);
      session->ReadGauge(std::move(row), kFeeler_s);
    }
  });
}

}  // namespace caltwin
