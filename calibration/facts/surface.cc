#include "calibration/facts/surface.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/estimate/f_test.h"
#include "calibration/facts/sheet.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kMostChance = 1e-3;

// Places on a line along one axis show the slope along it, and nothing of the other.
void AddLine(const Sheet& sheet, const ReadingNoise& noise, Facts* facts) {
  const bool is_x = sheet.half_mm()[0] > 1, is_y = sheet.half_mm()[1] > 1;
  if (is_x == is_y || sheet.size() < 2 || facts->Find("plane") != nullptr) return;
  double n = 0, q = 0, z = 0, qq = 0, qz = 0;
  for (const Spot& spot : sheet.spots()) {
    const double at_mm = is_x ? spot.x_mm : spot.y_mm;
    n += 1;
    q += at_mm;
    z += spot.height_mm;
    qq += at_mm * at_mm;
    qz += at_mm * spot.height_mm;
  }
  const double spread = qq - q * q / n;
  const double slope = (qz - q * z / n) / spread;
  const double sd = noise.sd_mm / std::sqrt(sheet.MeanReadings()) / std::sqrt(spread);
  facts->all.push_back(
      {.id = "plane",
       .figures = {{is_x ? "slope_x_mrad" : "slope_y_mrad",
                    MradFromRad(slope),
                    MradFromRad(sd)}},
       .sentence = fmt::format(
           "The touched places rise by {} along {}; along {} they say nothing",
           WithSd(MradFromRad(slope), MradFromRad(sd), "mrad"),
           is_x ? "X" : "Y",
           is_x ? "Y" : "X")});
}

void AddPlane(const Sheet& sheet,
              const SheetFit& plane,
              const SpotNoise& noise,
              std::string_view unit,
              Facts* facts) {
  Fact fact{.id = "plane"};
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double slope = plane.sizes_mm[1 + k] / sheet.half_mm()[k];
    const double sd = noise.sd_mm * plane.unit_sds[1 + k] / sheet.half_mm()[k];
    // A slope per counted place is none.
    const double rise_mm = 2 * plane.sizes_mm[1 + k];
    const double rise_sd_mm = 2 * noise.sd_mm * plane.unit_sds[1 + k];
    if (unit == "mm") {
      fact.figures.push_back({k == 0 ? "slope_x_mrad" : "slope_y_mrad",
                              MradFromRad(slope),
                              MradFromRad(sd)});
    } else {
      fact.figures.push_back({k == 0 ? "rise_x_um" : "rise_y_um",
                              UmFromMm(rise_mm),
                              UmFromMm(rise_sd_mm)});
    }
    if (Known(sd)) {
      const double sigmas = std::abs(slope) / std::max(sd, 1e-12);
      fact.sigmas = Known(fact.sigmas) ? std::max(fact.sigmas, sigmas) : sigmas;
    }
  }
  fact.sentence = fmt::format(
      "The plane of the {} touched places rises by {} over {:.4g} {} along X and by {} "
      "over {:.4g} {} along Y",
      sheet.size(),
      WithSd(2 * plane.sizes_mm[1], 2 * noise.sd_mm * plane.unit_sds[1], "mm"),
      2 * sheet.half_mm()[0],
      unit,
      WithSd(2 * plane.sizes_mm[2], 2 * noise.sd_mm * plane.unit_sds[2], "mm"),
      2 * sheet.half_mm()[1],
      unit);
  facts->all.push_back(std::move(fact));
}

// What no screw or leg of three can level: corners against corners.
void AddTwist(const SheetFit& fit, const SpotNoise& noise, Facts* facts) {
  constexpr double kSure = 5, kLeastUnknown_mm = 0.05;
  constexpr Eigen::Index kTwist = 3;
  const double twist_mm = fit.sizes_mm[kTwist];
  const double sd_mm = noise.sd_mm * fit.unit_sds[kTwist];
  const bool is_sure = Known(sd_mm) ? std::abs(twist_mm) > kSure * sd_mm
                                    : std::abs(twist_mm) > kLeastUnknown_mm;
  if (!is_sure) return;
  Fact fact{.id = "twist",
            .figures = {{"height_um", UmFromMm(twist_mm), UmFromMm(sd_mm)},
                        {"corners_um", UmFromMm(2 * twist_mm), UmFromMm(2 * sd_mm)}},
            .sigmas = std::abs(twist_mm) / std::max(sd_mm, 1e-12),
            .is_answer = true};
  if (!Known(sd_mm)) fact.sigmas = kUnknown;
  fact.sentence = fmt::format(
      "Two opposite corners stand {} higher than the other two ({}): a twist, which no "
      "plane, no three screws and no tilt removes. Either the gantry is racked or "
      "bends "
      "(its two sides are not parallel), or the bed itself is twisted; on a delta the "
      "towers stand at other angles than the firmware has{}",
      WithSd(2 * std::abs(twist_mm), 2 * sd_mm, "mm"),
      twist_mm > 0
          ? "front left and rear right, where X and Y run to the right and to the rear"
          : "front right and rear left, where X and Y run to the right and to the rear",
      Known(sd_mm) ? "" : ". Its uncertainty is not known: no place was touched twice");
  facts->all.push_back(std::move(fact));
}

// Too few places or repeats to tell a shape from scatter, and too much left to be
// scatter.
void AddLargeForm(const SheetFit& plane, bool is_repeated, Facts* facts) {
  const double range_mm = plane.left_mm.maxCoeff() - plane.left_mm.minCoeff();
  facts->all.push_back(
      {.id = "form",
       .figures = {{"peak_to_peak_um", UmFromMm(range_mm)},
                   {"rms_um", UmFromMm(std::sqrt(plane.squares_mm2() / plane.dof))}},
       .sentence = fmt::format(
           "Beside its plane the surface is uneven by {:.2g} mm from "
           "lowest to highest. Whether it repeats is {} touched twice), but "
           "no probe scatters by so much: a shape that no tilt, and on a "
           "delta no endstop, removes",
           range_mm,
           is_repeated ? "hardly known (too few places were"
                       : "not known (no place was"),
       .is_answer = true});
}

// What a plane leaves, against how one touch repeats; without repeats, whether a smooth
// shape takes it up.
void AddForm(const Sheet& sheet,
             const SheetFit& plane,
             const ReadingNoise& noise,
             Facts* facts) {
  constexpr double kLarge_mm = 0.2;
  if (plane.dof < 2) return;
  const double range_mm = plane.left_mm.maxCoeff() - plane.left_mm.minCoeff();
  double chance = 1;
  SpotNoise spot{};
  if (Known(noise.sd_mm)) {
    spot = NoiseOf(sheet, plane, noise);
    const double f = plane.squares_mm2() / plane.dof / (spot.sd_mm * spot.sd_mm);
    chance = FUpperTail(f, plane.dof, spot.dof);
  } else {
    const SheetFit shape = Fit(sheet, kAllTerms);
    if (!shape.is_determined || shape.dof < 3) {
      if (range_mm >= kLarge_mm) AddLargeForm(plane, false, facts);
      return;
    }
    const double more = plane.dof - shape.dof;
    const double f = (plane.squares_mm2() - shape.squares_mm2()) / more /
                     std::max(shape.squares_mm2() / shape.dof, 1e-14);
    chance = FUpperTail(f, more, shape.dof);
    spot.sd_mm = std::sqrt(shape.squares_mm2() / shape.dof);
  }
  const double rms_mm = std::sqrt(plane.squares_mm2() / plane.dof);
  const bool is_there = chance <= kMostChance;
  // Two or three repeats leave any scatter possible, but not one that no probe has.
  constexpr double kFewRepeats = 3, kSigmas = 10;
  if (!is_there && range_mm >= kLarge_mm && spot.dof < kFewRepeats &&
      rms_mm > kSigmas * spot.sd_mm) {
    return AddLargeForm(plane, true, facts);
  }
  facts->all.push_back(
      {.id = "form",
       .figures = {{"peak_to_peak_um",
                    UmFromMm(range_mm),
                    UmFromMm(spot.sd_mm) * std::sqrt(2.0)},
                   {"rms_um", UmFromMm(rms_mm)}},
       .sigmas = rms_mm / std::max(spot.sd_mm, 1e-12),
       .sentence =
           is_there
               ? fmt::format("Beside its plane the surface is uneven by {} um from "
                             "lowest to highest ({} um rms), where a touch {} {} um: a "
                             "shape that is there; a mesh takes it out of prints",
                             TwoDigits(UmFromMm(range_mm)),
                             TwoDigits(UmFromMm(rms_mm)),
                             Known(noise.sd_mm) ? "repeats to" : "scatters by",
                             TwoDigits(UmFromMm(spot.sd_mm)))
               : fmt::format(
                     "Beside its plane the surface is flat to {} um from lowest "
                     "to highest: no more than touches scatter",
                     TwoDigits(UmFromMm(range_mm))),
       .is_answer = is_there});
}

void AddFar(const Sheet& sheet,
            const std::vector<bool>& is_out,
            std::set<std::int64_t>* rows,
            Facts* facts) {
  Fact fact{.id = "outliers", .word = "surface", .is_answer = true};
  for (std::size_t i = 0; i < is_out.size(); ++i) {
    if (!is_out[i]) continue;
    const Spot& spot = sheet.spots()[i];
    fact.rows.insert(fact.rows.end(), spot.rows.begin(), spot.rows.end());
  }
  if (fact.rows.empty()) return;
  std::ranges::sort(fact.rows);
  rows->insert(fact.rows.begin(), fact.rows.end());
  fact.figures = {{"count", static_cast<double>(fact.rows.size())}};
  fact.sentence = fmt::format(
      "{} {} far from the surface that all other touches lie on: bad touch{}, left out",
      fact.rows.size() == 1 ? "Row" : "Rows",
      fmt::format(
          "{} {}", fmt::join(fact.rows, ", "), fact.rows.size() == 1 ? "is" : "are"),
      fact.rows.size() == 1 ? "" : "es");
  facts->all.push_back(std::move(fact));
}

using Sheets = std::map<std::string, std::vector<Spot>>;

double MeanOf(const std::vector<Spot>& spots) {
  double sum_mm = 0;
  for (const Spot& spot : spots) sum_mm += spot.height_mm;
  return sum_mm / static_cast<double>(spots.size());
}

// Heights of a sheet less those of another where both have the place; kUnknown
// elsewhere.
std::vector<double> ApartFrom(const std::vector<Spot>& others, const Sheet& sheet) {
  std::vector<double> apart_mm;
  for (const Spot& spot : sheet.spots()) {
    const auto same = std::ranges::find_if(others, [&](const Spot& other) {
      return other.x_mm == spot.x_mm && other.y_mm == spot.y_mm;
    });
    apart_mm.push_back(same == others.end() ? kUnknown
                                            : spot.height_mm - same->height_mm);
  }
  return apart_mm;
}

// What another sheet has at the same place is the surface, and no bad touch: the place
// differs from there by as much as all others do.
void KeepWhatRepeats(const Sheets& sheets,
                     const std::string& own,
                     const Sheet& sheet,
                     std::vector<bool>* is_out) {
  constexpr double kAlike = 0.3, kUsual = 4;
  const double mean_mm = MeanOf(sheet.spots());
  for (const auto& [key, others] : sheets) {
    if (key == own) continue;
    const std::vector<double> apart_mm = ApartFrom(others, sheet);
    std::vector<double> common_mm;
    std::ranges::copy_if(
        apart_mm, std::back_inserter(common_mm), [](double mm) { return Known(mm); });
    if (common_mm.empty()) continue;
    const double usual_mm = Median(common_mm);
    for (double& each_mm : common_mm) each_mm = std::abs(each_mm - usual_mm);
    const double spread_mm = kSigmaOfMedian * Median(common_mm);
    for (std::size_t i = 0; i < is_out->size(); ++i) {
      if (!(*is_out)[i] || !Known(apart_mm[i])) continue;
      const double off_mm = std::abs(sheet.spots()[i].height_mm - mean_mm);
      const double change_mm = std::abs(apart_mm[i] - usual_mm);
      if (change_mm < std::max(kAlike * off_mm, kUsual * spread_mm))
        (*is_out)[i] = false;
    }
  }
}

// How far the nearest other spot stands from each.
double Pitch_mm(const std::vector<Spot>& spots) {
  std::vector<double> nearest_mm;
  for (const Spot& one : spots) {
    double least_mm = HUGE_VAL;
    for (const Spot& other : spots) {
      if (&one == &other) continue;
      const double apart_mm = std::hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm);
      least_mm = std::min(least_mm, apart_mm);
    }
    nearest_mm.push_back(least_mm);
  }
  return Median(nearest_mm);
}

// Bad touches stand alone. Several beside each other, an edge or a corner, are the
// shape of the surface there.
void KeepRegions(const Sheet& sheet, std::vector<bool>* is_out) {
  constexpr double kBeside = 1.5;
  constexpr std::ptrdiff_t kFewest = 4;
  const auto num_out = std::ranges::count(*is_out, true);
  if (num_out < kFewest) return;
  const std::vector<Spot>& spots = sheet.spots();
  const double beside_mm = kBeside * Pitch_mm(spots);
  std::ptrdiff_t num_beside = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    bool has_neighbour = false;
    for (std::size_t k = 0; k < spots.size() && (*is_out)[i]; ++k) {
      has_neighbour |= k != i && (*is_out)[k] &&
                       std::hypot(spots[i].x_mm - spots[k].x_mm,
                                  spots[i].y_mm - spots[k].y_mm) < beside_mm;
    }
    num_beside += has_neighbour ? 1 : 0;
  }
  if (2 * num_beside > num_out) is_out->assign(is_out->size(), false);
}

}  // namespace

std::set<std::int64_t> FactsOfSurface(const std::vector<const Row*>& rows,
                                      const Repeats& repeats,
                                      bool has_places,
                                      Facts* facts) {
  std::set<std::int64_t> outliers;
  const std::size_t before = facts->all.size();
  const Sheets sheets = SheetsOf(rows, repeats.outliers);
  for (const auto& [key, spots] : sheets) {
    const ReadingNoise& reading =
        repeats.NoiseOf(key.substr(0, key.find('|')), RowKind::kTouch);
    Sheet sheet(spots);
    if (!sheet.has_area()) AddLine(sheet, reading, facts);
    if (sheet.size() < kPlaneTerms || !sheet.has_area()) continue;
    std::vector<bool> is_out = FarSpots(sheet, reading.sd_mm);
    KeepWhatRepeats(sheets, key, sheet, &is_out);
    KeepRegions(sheet, &is_out);
    AddFar(sheet, is_out, &outliers, facts);
    sheet = sheet.Without(is_out);
    // One bed as it first stood: later sheets only for what is far off.
    const bool is_told =
        std::any_of(facts->all.begin() + static_cast<std::ptrdiff_t>(before),
                    facts->all.end(),
                    [](const Fact& fact) { return fact.id == "plane"; });
    const SheetFit plane = Fit(sheet, kPlaneTerms);
    if (is_told || !plane.is_determined) continue;
    const SheetFit twist = Fit(sheet, kTwistTerms);
    const SheetFit shape = Fit(sheet, kAllTerms);
    const SheetFit& richest = shape.is_determined && shape.dof >= 3 ? shape : twist;
    const SpotNoise noise =
        NoiseOf(sheet, richest.is_determined ? richest : plane, reading);
    AddPlane(sheet, plane, noise, has_places ? "mm" : "places", facts);
    if (richest.is_determined) AddTwist(richest, noise, facts);
    AddForm(sheet, plane, reading, facts);
  }
  return outliers;
}

}  // namespace caltwin
