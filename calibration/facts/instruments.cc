#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/facts/average.h"
#include "calibration/facts/cells.h"
#include "calibration/facts/groups.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kSure = 4;

/// What measured a campaign, as far as the header says.
struct Gauge {
  std::string name{};
  double u_mm = 0;  ///< Of its scale or certificate; 0: not stated.
};

Gauge GaugeOf(const std::string& campaign, const DataHeader& header) {
  Gauge gauge{.name = campaign};
  const auto of = header.campaigns.find(campaign);
  if (of == header.campaigns.end() || of->second.instrument.empty()) return gauge;
  gauge.name = of->second.instrument;
  const auto instrument = header.instruments.find(gauge.name);
  if (instrument != header.instruments.end())
    gauge.u_mm = MmFromUm(instrument->second.u_um);
  return gauge;
}

/// One place and sense that both measured: the second's reading less the first's.
struct Apart {
  double at_mm = 0, sense = 0, mm = 0;
  double noise_mm = kUnknown;  ///< Standard deviation that repeats give it.
};

/// A place in hundredths of a millimetre, and the sense.
using Place = std::pair<long, int>;
std::map<Place, Rows> PlacesOf(const Rows& rows, std::size_t axis) {
  std::map<Place, Rows> places;
  for (const Row* row : rows) {
    const double sense = Known(row->dir[axis]) ? row->dir[axis] : 0;
    places[{std::lround(100 * row->cmd_mm[axis]), static_cast<int>(sense)}].push_back(
        row);
  }
  return places;
}

std::vector<Apart> ApartOf(const Rows& one,
                           const Rows& other,
                           std::size_t axis,
                           const Repeats& repeats) {
  std::vector<Apart> apart;
  const auto others = PlacesOf(other, axis);
  for (const auto& [place, rows] : PlacesOf(one, axis)) {
    const auto same = others.find(place);
    if (same == others.end()) continue;
    const Average first = AverageOf(rows), second = AverageOf(same->second);
    const double first_mm = repeats.NoiseOf(*rows.front()).sd_mm;
    const double second_mm = repeats.NoiseOf(*same->second.front()).sd_mm;
    apart.push_back({rows.front()->cmd_mm[axis],
                     static_cast<double>(place.second),
                     second.mean - first.mean,
                     std::hypot(first_mm / std::sqrt(first.num),
                                second_mm / std::sqrt(second.num))});
  }
  return apart;
}

/// By how much the second reads more: per millimetre, and at a reversal.
struct Comparison {
  double slope = 0, slope_sd = 0, gap_mm = 0, gap_sd_mm = 0;
  double left_mm = 0;  ///< Root mean square of what is neither.
  double span_mm = 0;
  std::size_t places = 0;
  bool has_gap = false;
};

std::optional<Comparison> Compare(const std::vector<Apart>& apart) {
  constexpr std::size_t kFewest = 4;
  const auto senses = [&](double sense) {
    return std::ranges::count(apart, sense, &Apart::sense) >= 2;
  };
  Comparison told{.places = apart.size(), .has_gap = senses(-1) && senses(1)};
  const Eigen::Index terms = told.has_gap ? 3 : 2;
  const auto num = static_cast<Eigen::Index>(apart.size());
  if (apart.size() < kFewest || num <= terms) return std::nullopt;
  const auto [low, high] = std::ranges::minmax(apart, {}, &Apart::at_mm);
  told.span_mm = high.at_mm - low.at_mm;
  if (!(told.span_mm > 0)) return std::nullopt;
  const double middle_mm = (low.at_mm + high.at_mm) / 2;
  Eigen::MatrixXd columns(num, terms);
  Eigen::VectorXd apart_mm(num);
  double noise_mm2 = 0;
  for (Eigen::Index i = 0; i < num; ++i) {
    const Apart& one = apart[static_cast<std::size_t>(i)];
    columns(i, 0) = 1;
    columns(i, 1) = one.at_mm - middle_mm;
    if (told.has_gap) columns(i, 2) = -one.sense / 2;
    apart_mm[i] = one.mm;
    noise_mm2 += one.noise_mm * one.noise_mm / static_cast<double>(num);
  }
  const Eigen::VectorXd sizes = LeastSquares(columns, apart_mm);
  const double left_mm2 = (apart_mm - columns * sizes).squaredNorm();
  told.left_mm = std::sqrt(left_mm2 / static_cast<double>(num - terms));
  const double sd_mm =
      Known(noise_mm2) ? std::max(told.left_mm, std::sqrt(noise_mm2)) : told.left_mm;
  const Eigen::MatrixXd inverse =
      Cholesky(columns.transpose() * columns)
          .SolveEach(Eigen::MatrixXd::Identity(terms, terms));
  told.slope = sizes[1];
  told.slope_sd = sd_mm * std::sqrt(inverse(1, 1));
  if (told.has_gap) {
    told.gap_mm = sizes[2];
    told.gap_sd_mm = sd_mm * std::sqrt(inverse(2, 2));
  }
  return told;
}

// Which of the two errs, where their certificates say so.
std::string WhichErrs(const Gauge& one, const Gauge& other, double apart_mm) {
  constexpr double kFiner = 3, kBeyond = 2;
  const bool are_stated = one.u_mm > 0 && other.u_mm > 0;
  if (!are_stated) {
    return ". These rows cannot say which of the two is right";
  }
  const Gauge& fine = one.u_mm < other.u_mm ? one : other;
  const Gauge& coarse = one.u_mm < other.u_mm ? other : one;
  if (std::abs(apart_mm) < kBeyond * coarse.u_mm) {
    return fmt::format(", within the {} um that are stated of '{}'",
                       TwoDigits(UmFromMm(coarse.u_mm)),
                       coarse.name);
  }
  if (kFiner * fine.u_mm > coarse.u_mm) {
    return ", more than either is stated to err by, and their certificates are alike: "
           "these rows cannot say which of the two is right";
  }
  return fmt::format(
      ". '{}' errs: '{}' is known to {} um, and it is more than the {} um that are "
      "stated of '{}'",
      coarse.name,
      fine.name,
      TwoDigits(UmFromMm(fine.u_mm)),
      TwoDigits(UmFromMm(coarse.u_mm)),
      coarse.name);
}

bool IsCertain(const Gauge& one, const Gauge& other, double apart_mm) {
  return WhichErrs(one, other, apart_mm).find(" errs: ") != std::string::npos;
}

bool IsLong(const Comparison& told) {
  return std::abs(told.slope) > kSure * told.slope_sd;
}

bool IsGap(const Comparison& told) {
  return told.has_gap && std::abs(told.gap_mm) > kSure * told.gap_sd_mm;
}

// "43 +- 1 um of 250 mm travelled (174 um/m), and 15 +- 1 um at a reversal".
std::string ApartInWords(const Comparison& told) {
  std::vector<std::string> differs;
  if (IsLong(told)) {
    differs.push_back(fmt::format("{} of {:.4g} mm travelled ({:.3g} um/m)",
                                  WithSd(UmFromMm(std::abs(told.slope) * told.span_mm),
                                         UmFromMm(told.slope_sd * told.span_mm),
                                         "um"),
                                  told.span_mm,
                                  PpmFromFraction(std::abs(told.slope))));
  }
  if (IsGap(told)) {
    differs.push_back(fmt::format(
        "{} at a reversal",
        WithSd(UmFromMm(std::abs(told.gap_mm)), UmFromMm(told.gap_sd_mm), "um")));
  }
  return fmt::format("{}", fmt::join(differs, ", and "));
}

Fact FactOf(std::size_t axis, const Comparison& told) {
  Fact fact{
      .axis = kAxisNames[axis],
      .word = "instruments",
      .figures = {
          {"apart_um",
           UmFromMm(told.slope * told.span_mm),
           UmFromMm(told.slope_sd * told.span_mm)},
          {"apart_ppm", PpmFromFraction(told.slope), PpmFromFraction(told.slope_sd)}}};
  if (told.has_gap) {
    fact.figures.push_back({"gap_um", UmFromMm(told.gap_mm), UmFromMm(told.gap_sd_mm)});
  }
  fact.figures.push_back({"left_um", UmFromMm(told.left_mm)});
  return fact;
}

void AddAgreement(std::size_t axis,
                  const Gauge& one,
                  const Gauge& other,
                  const Comparison& told,
                  Facts* facts) {
  Fact fact = FactOf(axis, told);
  fact.id = "agreement";
  fact.sentence = fmt::format(
      "'{}' and '{}' agree about {}: {} apart over {:.4g} mm, and {} um at single "
      "places. What both show is the axis, and no instrument",
      one.name,
      other.name,
      "XYZ"[axis],
      WithSd(UmFromMm(told.slope * told.span_mm),
             UmFromMm(told.slope_sd * told.span_mm),
             "um"),
      told.span_mm,
      TwoDigits(UmFromMm(told.left_mm)));
  facts->all.push_back(std::move(fact));
}

void AddContradiction(std::size_t axis,
                      const Gauge& one,
                      const Gauge& other,
                      const Comparison& told,
                      Facts* facts) {
  const double apart_mm = told.slope * told.span_mm;
  const double most_mm = IsLong(told) && std::abs(apart_mm) > std::abs(told.gap_mm)
                             ? apart_mm
                             : told.gap_mm;
  const bool reads_more = most_mm > 0;
  const bool is_within = one.u_mm > 0 && other.u_mm > 0 &&
                         std::abs(most_mm) < 2 * std::max(one.u_mm, other.u_mm);
  Fact fact = FactOf(axis, told);
  fact.id = "contradiction";
  fact.sigmas = IsLong(told) ? std::abs(told.slope) / told.slope_sd
                             : std::abs(told.gap_mm) / told.gap_sd_mm;
  fact.is_answer = !is_within;
  fact.sentence = fmt::format("'{}' reads {} than '{}' along {}: {}{}",
                              reads_more ? other.name : one.name,
                              IsLong(told) ? "a longer way" : "a wider gap",
                              reads_more ? one.name : other.name,
                              "XYZ"[axis],
                              ApartInWords(told),
                              WhichErrs(one, other, most_mm));
  facts->all.push_back(std::move(fact));
  if (is_within || IsCertain(one, other, most_mm)) return;
  facts->not_determined.emplace_back("cause");
  facts->cannot.push_back(fmt::format(
      "which of '{}' and '{}' reads the true way: they contradict each other",
      one.name,
      other.name));
  facts->next.insert(
      facts->next.begin(),
      {"block",
       fmt::format("measure one length that is known, a gauge block or a 1-2-3 block, "
                   "with both: it tells which of the two errs{}",
                   IsGap(told)
                       ? "; and let both come upon one place ten times from either "
                         "side, with the axis clamped between"
                       : "")});
}

}  // namespace

void FactsOfInstruments(const Rows& rows,
                        const Repeats& repeats,
                        const DataHeader& header,
                        Facts* facts) {
  std::map<std::size_t, std::map<std::string, Rows>> axes;
  std::map<std::size_t, std::vector<std::string>> order;
  for (const Row* row : rows) {
    const int axis = AxisAlong(*row);
    const bool is_reading = row->kind == RowKind::kPosition && axis >= 0 &&
                            !repeats.outliers.contains(row->row);
    if (!is_reading) continue;
    const auto k = static_cast<std::size_t>(axis);
    const std::string name = GaugeOf(row->campaign, header).name;
    // A campaign whose instrument nobody stated may be the same instrument again.
    if (name == row->campaign && !header.instruments.contains(name)) continue;
    Rows& own = axes[k][name];
    if (own.empty()) order[k].push_back(name);
    own.push_back(row);
  }
  for (const auto& [k, gauges] : axes) {
    for (std::size_t i = 1; i < order[k].size(); ++i) {
      const Rows& one = gauges.at(order[k][0]);
      const Rows& other = gauges.at(order[k][i]);
      const auto told = Compare(ApartOf(one, other, k, repeats));
      if (!told) continue;
      const bool differ = IsLong(*told) || IsGap(*told);
      const auto add = differ ? AddContradiction : AddAgreement;
      add(k,
          GaugeOf(one.front()->campaign, header),
          GaugeOf(other.front()->campaign, header),
          *told,
          facts);
    }
  }
}

}  // namespace caltwin
