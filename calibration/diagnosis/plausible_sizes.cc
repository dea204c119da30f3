#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "calibration/diagnosis/stated_noise.h"
#include "calibration/facts/ratios.h"
#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kInch_mm = MmFromInch(1.0);
constexpr double kThousand = UmFromMm(1.0);
constexpr double kLargestGauged_mm = 1;   // Residual scatter that is no machine's.
constexpr double kLargestTouched_mm = 3;  // Beds and plates are that crooked, not more.
constexpr double kAbsurdSlope = 0.5;
constexpr double kNear = 0.03;
constexpr std::size_t kFewestInLine = 5;

bool IsNear(double ratio, double what) {
  return std::abs(ratio / what - 1) < kNear;
}

bool IsGauged(const Row& row) {
  return row.kind != RowKind::kTouch;
}

std::string NameOf(const RowSeries& series) {
  return fmt::format(
      "campaign {}{}",
      series.first->campaign,
      series.first->setup.empty() ? "" : ", setup " + series.first->setup);
}

/// What a slope of moved against commanded, less one, means where it is no machine's.
void DoubtSlope(const RowSeries& series, double slope, std::vector<Doubt>* doubts) {
  const double moved = 1 + (IsGauged(*series.first) ? slope : -slope);
  Doubt doubt{.kind = "scale_absurd", .refuse = true};
  if (IsNear(moved, 2)) {
    doubt.kind = "value_is_position";
    doubt.hint =
        "value_mm is the position read, not actual minus commanded; where the axis "
        "does "
        "move twice as far (microsteps, a lead, a diameter for a radius), give "
        "commanded "
        "and read positions as two columns: caltwin diagnose subtracts them";
  } else if (std::abs(moved) < 0.003) {
    doubt.kind = "value_is_position";
    doubt.hint =
        "the reading does not follow the axis: value_mm is commanded minus a constant, "
        "the gauge stood still, or it reads metres";
  } else if (IsNear(moved, -1)) {
    doubt.kind = "reversed_axis";
    doubt.hint = "the gauge counts the other way than the axis: reverse one of them";
  } else if (IsNear(moved, kInch_mm) || IsNear(moved, 1 / kInch_mm)) {
    doubt.kind = "position_unit";
    doubt.hint = "that is an inch: reading and command are in different units";
  } else if (IsNear(moved, kThousand) || IsNear(moved, 1 / kThousand)) {
    doubt.kind = "position_unit";
    doubt.hint = "that is a factor of 1000: reading and command are in different units";
  } else if (KnownRatioOf(moved, kUnknown).reading.empty() &&
             std::abs(slope) > kAbsurdSlope) {
    doubt.hint = "units, sign or column of value_mm or of the position are wrong";
  } else {
    return;  // Microsteps and leads are a fact of their own.
  }
  doubt.message = fmt::format(
      "{}: for every mm commanded the readings move {:.4g} mm", NameOf(series), moved);
  doubts->push_back(std::move(doubt));
}

// Whether readings come in steps of a tenth or more: no probe shows a thousandth of a
// micrometre, so what is written finer is in mm.
bool IsCoarse(const RowSeries& series) {
  constexpr double kStep = 0.1, kRounding = 1e-6;
  return std::ranges::all_of(series.rows, [&](const Row* row) {
    const double steps = row->value_mm / kStep;
    return std::abs(steps - std::round(steps)) < kRounding;
  });
}

void DoubtSize(const RowSeries& series,
               const SeriesFit& fit,
               std::vector<Doubt>* doubts) {
  constexpr double kNoBed_mm = 30;  // Gantries rack and beds lean by less.
  const bool is_gauged = IsGauged(*series.first);
  const double largest_mm = is_gauged ? kLargestGauged_mm : kLargestTouched_mm;
  if (fit.size_mm < largest_mm) return;
  if (!is_gauged && fit.size_mm < kNoBed_mm && !IsCoarse(series)) return;
  doubts->push_back(
      {.kind = "value_unit",
       .message = fmt::format("{}: readings scatter by {:.3g} mm about a straight line",
                              NameOf(series),
                              fit.size_mm),
       .hint = fmt::format("in micrometres it would be {:.3g} um: value_mm is in mm",
                           fit.size_mm),
       .refuse = true});
}

// Forward readings lag behind backward ones by the gap; touches of one face have one
// sense, so gauges only.
void DoubtGap(const RowSeries& series,
              const SeriesFit& fit,
              std::vector<Doubt>* doubts) {
  constexpr double kSure = 5;
  if (!IsGauged(*series.first) || fit.half_gap_mm < kSure * fit.half_gap_sd_mm ||
      fit.half_gap_mm <= 0) {
    return;
  }
  doubts->push_back(
      {.kind = "negative_gap",
       .message = fmt::format("{}: readings are {:.1f} um further when the axis came "
                              "from - than when it came from +",
                              NameOf(series),
                              UmFromMm(2 * fit.half_gap_mm)),
       .hint = "lost motion lags, it never leads: backlash compensation that does too "
               "much, or the sign of value_mm or of dir_ is reversed"});
}

// How many different remainders positions leave, those that are round leaving none.
std::size_t NumRemainders(const std::set<double>& positions, double step) {
  constexpr double kResolution = 1e-3;
  std::set<long> remainders;
  for (const double position : positions) {
    const double steps = position / step;
    const long remainder =
        std::lround((steps - std::round(steps)) * step / kResolution);
    if (remainder != 0) remainders.insert(remainder);
  }
  return remainders.size();
}

// Whether positions are round numbers of mm once they are taken as inches, and are not
// as they stand. One odd position, and those a round number away from it, may be round
// in inches by chance; so may a grid of equal steps, which is why positions where the
// machine cannot go are none.
bool AreInches(const std::set<double>& positions, int axis, const Machine* machine) {
  constexpr double kRound_mm = 0.5;
  const auto all_round = [&](double scale, double step, double tolerance) {
    return std::ranges::all_of(positions, [&](double position) {
      const double steps = position * scale / step;
      return std::abs(steps - std::round(steps)) * step < tolerance;
    });
  };
  const bool is_too_far = std::ranges::any_of(positions, [&](double position) {
    return !CanStandAt(machine, axis, MmFromInch(position));
  });
  return !is_too_far && !all_round(1, 0.01, 1e-4) &&
         NumRemainders(positions, kRound_mm) >= 4 &&
         all_round(kInch_mm, kRound_mm, 0.01);
}

// Targets are round numbers in the unit they were chosen in, each campaign's in its
// own.
void DoubtPositions(const RowTable& table,
                    const Machine* machine,
                    std::vector<Doubt>* doubts) {
  for (const int axis : {0, 1, 2}) {
    std::map<std::string, std::set<double>> positions;
    for (const Row& row : table.rows) {
      if (Known(row.cmd_mm[axis]) && row.cmd_mm[axis] != 0) {
        positions[row.campaign].insert(row.cmd_mm[axis]);
      }
    }
    for (const auto& [campaign, of_campaign] : positions) {
      if (!AreInches(of_campaign, axis, machine)) continue;
      doubts->push_back({.kind = "position_unit",
                         .message = fmt::format(
                             "the positions along {} of campaign {} are round numbers "
                             "of mm if taken as inches: {:.5g} is {:.4g} mm",
                             "xyz"[axis],
                             campaign,
                             *of_campaign.rbegin(),
                             MmFromInch(*of_campaign.rbegin())),
                         .hint = fmt::format("cmd_{}_mm is in mm", "xyz"[axis]),
                         .refuse = true});
      break;
    }
  }
}

// Taken as not stated.
void DoubtZeroSigmas(const RowTable& table, std::vector<Doubt>* doubts) {
  Doubt doubt{.kind = "sigma_unit"};
  for (const Row& row : table.rows) {
    if (Known(row.sigma_mm) && row.sigma_mm <= 0) doubt.rows.push_back(row.row);
  }
  if (doubt.rows.empty()) return;
  doubt.message = fmt::format("sigma_mm is not above 0 in {} rows, the first is row {}",
                              doubt.rows.size(),
                              doubt.rows.front());
  doubt.hint = "no reading is exact: taken as unknown; leave the column empty there";
  doubts->push_back(std::move(doubt));
}

void DoubtSigmas(const RowTable& table,
                 const DataHeader& header,
                 const std::vector<RowSeries>& all,
                 std::vector<Doubt>* doubts) {
  constexpr double kTooFar = 30;
  std::vector<double> sigmas_mm;
  for (const Row& row : table.rows) {
    double sigma_mm = row.sigma_mm;
    const auto campaign = header.campaigns.find(row.campaign);
    if (!Known(sigma_mm) && campaign != header.campaigns.end()) {
      const auto instrument = header.instruments.find(campaign->second.instrument);
      if (instrument != header.instruments.end()) {
        sigma_mm = MmFromUm(instrument->second.sigma_um);
      }
    }
    if (Known(sigma_mm) && sigma_mm > 0) sigmas_mm.push_back(sigma_mm);
  }
  const double repeat_mm = RepeatDeviation_mm(all);
  if (sigmas_mm.size() * 2 < table.rows.size() || !Known(repeat_mm)) return;
  const double sigma_mm = Median(sigmas_mm);
  const double ratio = sigma_mm / repeat_mm;
  const bool is_usual = ratio < kTooFar && ratio > 1 / (10 * kTooFar);
  const std::string_view inches = InchesBy(ratio);
  if (is_usual && inches.empty()) return;
  doubts->push_back(
      {.kind = "sigma_unit",
       .message =
           fmt::format("the stated uncertainty of a reading is {:.3g} um, repeated "
                       "readings scatter by {:.3g} um",
                       UmFromMm(sigma_mm),
                       UmFromMm(repeat_mm)),
       .hint = !inches.empty() ? std::string(inches)
               : ratio > 1
                   ? "sigma_mm is in mm, sigma_um in micrometres; was one written "
                     "for the other?"
                   : "value_mm or the uncertainty is in another unit"});
}

// The finest step between readings against how they scatter.
void DoubtSteps(const RowTable& table,
                const std::vector<RowSeries>& all,
                std::vector<Doubt>* doubts) {
  std::set<double> values;
  for (const Row& row : table.rows) values.insert(row.value_mm);
  if (values.size() < 2) return;
  double step_mm = INFINITY;
  for (auto value = std::next(values.begin()); value != values.end(); ++value) {
    const double gap_mm = *value - *std::prev(value);
    if (gap_mm > 1e-9) step_mm = std::min(step_mm, gap_mm);
  }
  const bool is_grid = std::ranges::all_of(values, [&](double value) {
    const double steps = (value - *values.begin()) / step_mm;
    return std::abs(steps - std::round(steps)) < 0.02;
  });
  const double repeat_mm = RepeatDeviation_mm(all);
  if (!is_grid || !Known(repeat_mm) || repeat_mm > step_mm) return;
  doubts->push_back(
      {.kind = "quantised",
       .message =
           fmt::format("readings come in steps of {:.4g} um and scatter by {:.3g} "
                       "um",
                       UmFromMm(step_mm),
                       UmFromMm(repeat_mm)),
       .hint = fmt::format("a reading is not known better than {:.3g} um, whatever the "
                           "scatter says",
                           UmFromMm(step_mm / std::sqrt(12.0)))});
}

// Every numbered run a campaign of its own.
RowTable RunsAsCampaigns(const RowTable& table) {
  RowTable by_run = table;
  for (Row& row : by_run.rows) {
    if (row.rep) row.campaign += fmt::format(" (run {})", *row.rep);
  }
  return by_run;
}

}  // namespace

RowTable WithoutLoneScrews(const RowTable& table) {
  constexpr double kApart_mm = 0.01;
  std::map<std::string, const Row*> firsts;
  std::set<std::string> alone;
  for (const Row& row : table.rows) {
    const Row& first = *firsts.try_emplace(row.campaign, &row).first->second;
    for (const std::size_t screw : {1, 2}) {
      for (const auto screws_mm : {&Row::motor_mm, &Row::screw_mm}) {
        const double apart_mm = ((row.*screws_mm)[screw] - (row.*screws_mm)[0]) -
                                ((first.*screws_mm)[screw] - (first.*screws_mm)[0]);
        if (std::abs(apart_mm) > kApart_mm) alone.insert(row.campaign);
      }
    }
  }
  RowTable alike = table;
  std::erase_if(alike.rows,
                [&](const Row& row) { return alone.contains(row.campaign); });
  return alike;
}

void DoubtSizes(const RowTable& table,
                const RowTable& moved_alike,
                const DataHeader& header,
                const Machine* machine,
                const KnownOfRows& known,
                std::vector<Doubt>* doubts) {
  const std::vector<RowSeries> all = SeriesOf(table);
  for (const RowSeries& series : SeriesOf(moved_alike)) {
    if (series.rows.size() < kFewestInLine) continue;
    const SeriesFit fit = FitSeries(series);
    const std::size_t before = doubts->size();
    if (!known.is_deviation) DoubtSlope(series, fit.slope, doubts);
    if (doubts->size() > before) continue;
    if (!known.has_unit) DoubtSize(series, fit, doubts);
    DoubtGap(series, fit, doubts);
  }
  DoubtGaps(all, doubts);
  const RowTable by_run = RunsAsCampaigns(moved_alike);
  DoubtGaps(SeriesOf(by_run), doubts);
  DoubtFaces(all, doubts);
  DoubtApproach(table, doubts);
  DoubtCampaigns(moved_alike, doubts);
  DoubtRuns(moved_alike, doubts);
  DoubtPositionUnits(moved_alike, doubts);
  DoubtPositions(table, machine, doubts);
  DoubtZeroSigmas(table, doubts);
  DoubtSigmas(table, header, all, doubts);
  DoubtSteps(table, all, doubts);
}

}  // namespace caltwin
