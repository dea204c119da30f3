#include "calibration/diagnosis/pictures_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/covariate.h"
#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/nuisances.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/map_table.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 8> kChannels = {
    "x", "y", "z", "a", "b", "c", "probe", "bed"};
constexpr std::array<std::string_view, 18> kColumns = {"x",
                                                       "y",
                                                       "z",
                                                       "dir_x",
                                                       "dir_y",
                                                       "dir_z",
                                                       "motor_a",
                                                       "motor_b",
                                                       "motor_c",
                                                       "dir_a",
                                                       "dir_b",
                                                       "dir_c",
                                                       "since_rev",
                                                       "t",
                                                       "temp",
                                                       "feed",
                                                       "load",
                                                       "theta"};
constexpr double kSees = 0.5;  // A row sees a channel that shows in it by more.

template <std::size_t kSize>
std::size_t PlaceIn(const std::array<std::string_view, kSize>& all,
                    std::string_view one) {
  return static_cast<std::size_t>(std::ranges::find(all, one) - all.begin());
}

std::vector<bool> LeftOut(const Observed& observed, const Diagnosis& diagnosis) {
  std::vector<bool> out;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    out.push_back(std::ranges::find(diagnosis.outlier_rows, observed.row(i).row) !=
                  diagnosis.outlier_rows.end());
  }
  return out;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// What each finding does to the rows, less what of it the baseline takes [mm].
std::vector<Eigen::VectorXd> VisibleOf(const Observed& observed,
                                       const Diagnosis& diagnosis,
                                       const std::vector<bool>& out) {
  const Evidence evidence(observed, {diagnosis.sigma_mm, 0}, BaselineOf(observed), out);
  std::vector<Eigen::VectorXd> visible;
  for (const Finding& finding : diagnosis.findings) {
    const Eigen::MatrixXd white = evidence.Left(evidence.Whiten(finding.change_mm));
    visible.emplace_back(diagnosis.sigma_mm.cwiseProduct(white.col(0)));
  }
  return visible;
}

std::string ChannelOfFinding(const Finding& finding, const MachineKind* kind) {
  if (finding.map) return finding.map->channel;
  const auto effect = FindEffect(finding.cause);
  if (!effect || !EffectAt(*effect).sight) return finding.axis;
  return ShownOn(EffectAt(*effect), finding.axis, kind).channel;
}

// Of a wave along the axis `covariate`; 0: it is none.
double PeriodOf_mm(const Finding& finding,
                   const Machine& machine,
                   std::string_view covariate) {
  const auto axis = AxisNamed(covariate);
  if (!axis) return 0;
  const auto found =
      std::ranges::find(finding.parameters, "period_mm", &FindingParameter::name);
  if (found != finding.parameters.end()) return found->value;
  return finding.cause == "microstep" ? Microstep::Period_mm(machine.axis(*axis)) : 0;
}

// The thermometer that a temperature cause follows, as a column of the rows; others:
// the one that moves most, "temp".
std::string ThermometerOf(const Finding& finding) {
  if (finding.cause == "frame_temperature") return "temp_" + finding.axis + "_c";
  const bool by_screw =
      finding.cause == "thermal_screw" || finding.cause == "probe_temperature";
  return by_screw ? "temp_screw_c" : "temp";
}

// The covariates drawn: the one along, and the one that splits (empty: none).
std::pair<std::string, std::string> DrawnAgainst(const Finding& finding) {
  std::vector<std::string> words = finding.covariates;
  std::ranges::stable_partition(
      words, [](const std::string& word) { return !word.starts_with("dir_"); });
  if (words.empty()) words = {"t"};
  std::ranges::replace(words, std::string("temp"), ThermometerOf(finding));
  return {words[0], words.size() > 1 ? words[1] : ""};
}

double ShownValue(const Observed& observed, Eigen::Index i, std::string_view word) {
  if (word == "temp_frame_c") return observed.row(i).temp_frame_c;
  if (word == "temp_bed_c") return observed.row(i).temp_bed_c;
  if (word == "temp_screw_c") return observed.row(i).temp_screw_c;
  const double value = CovariateAt(observed.at(i), word);
  return word == "theta" ? DegFromRad(value) : value;
}

// Classes of a second covariate: its two senses, or its thirds.
void Split(const std::vector<double>& values, FindingSeries* series) {
  if (series->split_by.starts_with("dir_")) {
    for (const double value : values) series->split.push_back(value > 0 ? 0 : 1);
    series->split_labels = {"forward", "backward"};
    return;
  }
  const auto [least, most] = std::ranges::minmax(values);
  const double third = (most - least) / 3;
  for (const double value : values) {
    const int part = third > 0 ? static_cast<int>((value - least) / third) : 0;
    series->split.push_back(std::min(part, 2));
  }
  for (int part = 0; part < 3; ++part) {
    series->split_labels.push_back(fmt::format("{} {:.3g} to {:.3g}",
                                               series->split_by,
                                               least + part * third,
                                               least + (part + 1) * third));
  }
}

FindingSeries SeriesOf(const Observed& observed,
                       const Finding& finding,
                       const Eigen::VectorXd& before_mm,
                       const Diagnosis& diagnosis,
                       const std::vector<bool>& out) {
  const auto [along, split_by] = DrawnAgainst(finding);
  FindingSeries series{.cause = finding.cause,
                       .axis = finding.axis,
                       .channel = ChannelOfFinding(finding, observed.machine().kind),
                       .covariate = along,
                       .is_by_order = finding.is_by_order,
                       .period_mm = PeriodOf_mm(finding, observed.machine(), along),
                       .split_by = split_by};
  const Eigen::VectorXd shows = ChannelOf(observed, series.channel);
  std::vector<double> second, sigmas_um;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (std::abs(shows[i]) < kSees || out[static_cast<std::size_t>(i)]) continue;
    double at = ShownValue(observed, i, along);
    const double other = split_by.empty() ? 0 : ShownValue(observed, i, split_by);
    if (!Known(at) || !Known(other)) continue;
    if (series.period_mm > 0) {
      at -= series.period_mm * std::floor(at / series.period_mm);
    }
    series.rows.push_back(observed.row(i).row);
    series.at.push_back(at);
    series.before_um.push_back(UmFromMm(before_mm[i] / shows[i]));
    series.after_um.push_back(UmFromMm(diagnosis.residual_after_mm[i] / shows[i]));
    sigmas_um.push_back(UmFromMm(diagnosis.sigma_mm[i]));
    second.push_back(other);
  }
  series.pure_error_um = Median(sigmas_um);
  if (!split_by.empty() && !second.empty()) Split(second, &series);
  return series;
}

// Sums over rows reached in one sense.
struct Sense {
  double before_mm = 0, after_mm = 0;
  int rows = 0;
};

DirectionContrast ContrastOf(const Observed& observed,
                             const Diagnosis& diagnosis,
                             const std::vector<bool>& out,
                             Axis axis) {
  constexpr double kAlong = 0.9;
  const Eigen::VectorXd shows = ChannelOf(observed, Name(axis));
  std::map<long, std::array<Sense, 2>> by_position_um;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double dir = observed.row(i).dir[Index(axis)];
    const double cmd_mm = observed.row(i).cmd_mm[Index(axis)];
    if (std::abs(shows[i]) < kAlong || out[static_cast<std::size_t>(i)]) continue;
    if (!Known(dir) || dir == 0 || !Known(cmd_mm)) continue;
    Sense& sense = by_position_um[std::lround(UmFromMm(cmd_mm))][dir > 0 ? 0 : 1];
    sense.before_mm += diagnosis.residual_before_mm[i] / shows[i];
    sense.after_mm += diagnosis.residual_after_mm[i] / shows[i];
    ++sense.rows;
  }
  DirectionContrast contrast{.axis = std::string(Name(axis))};
  std::vector<double> sds_um;
  const double sigma_um =
      UmFromMm(Median({diagnosis.sigma_mm.data(),
                       diagnosis.sigma_mm.data() + diagnosis.sigma_mm.size()}));
  for (const auto& [position_um, senses] : by_position_um) {
    const auto& [forward, backward] = senses;
    if (forward.rows == 0 || backward.rows == 0) continue;
    contrast.at_mm.push_back(MmFromUm(static_cast<double>(position_um)));
    contrast.before_um.push_back(UmFromMm(forward.before_mm / forward.rows -
                                          backward.before_mm / backward.rows));
    contrast.after_um.push_back(
        UmFromMm(forward.after_mm / forward.rows - backward.after_mm / backward.rows));
    sds_um.push_back(sigma_um * std::sqrt(1.0 / forward.rows + 1.0 / backward.rows));
  }
  contrast.sd_um = Median(sds_um);
  return contrast;
}

double Rms(double sum, int count) {
  return count > 0 ? std::sqrt(sum / count) : 0;
}

// Scatter of replicates about their means, what the findings explain (a drift, say)
// taken off first, rows left out of the fit out of this too.
void AddPureError(const Observed& observed,
                  const Diagnosis& diagnosis,
                  const std::vector<bool>& out,
                  std::vector<LackOfFit>* all) {
  std::map<std::string, std::vector<Eigen::Index>> groups;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (!out[static_cast<std::size_t>(i)]) {
      groups[ReplicateKey(observed, i)].push_back(i);
    }
  }
  std::vector<double> sum_mm2(all->size(), 0);
  for (const auto& [key, members] : groups) {
    const Eigen::VectorXd left_mm = diagnosis.residual_after_mm(members);
    const auto c = static_cast<std::size_t>(
        observed.campaign_of()[static_cast<std::size_t>(members.front())]);
    sum_mm2[c] += (left_mm.array() - left_mm.mean()).square().sum();
    (*all)[c].replicate_dof += static_cast<int>(members.size()) - 1;
  }
  for (std::size_t c = 0; c < all->size(); ++c) {
    LackOfFit& fit = (*all)[c];
    fit.pure_error_um = fit.replicate_dof > 0
                            ? UmFromMm(std::sqrt(sum_mm2[c] / fit.replicate_dof))
                            : kUnknown;
  }
}

std::vector<LackOfFit> LackOfFitOf(const Observed& observed,
                                   const Diagnosis& diagnosis,
                                   const std::vector<bool>& out) {
  const std::size_t count = observed.campaigns().size();
  std::vector<LackOfFit> all(count);
  std::vector<double> sigma2(count, 0), before2(count, 0), after2(count, 0);
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    if (out[row]) continue;
    const auto c = static_cast<std::size_t>(observed.campaign_of()[row]);
    ++all[c].rows;
    sigma2[c] += std::pow(diagnosis.sigma_mm[i], 2);
    before2[c] += std::pow(diagnosis.residual_before_mm[i], 2);
    after2[c] += std::pow(diagnosis.residual_after_mm[i], 2);
  }
  for (std::size_t c = 0; c < count; ++c) {
    all[c].campaign = observed.campaigns()[c];
    all[c].sigma_um = UmFromMm(Rms(sigma2[c], all[c].rows));
    all[c].before_um = UmFromMm(Rms(before2[c], all[c].rows));
    all[c].after_um = UmFromMm(Rms(after2[c], all[c].rows));
  }
  AddPureError(observed, diagnosis, out, &all);
  return all;
}

std::vector<FlaggedRow> FlaggedOf(const Observed& observed,
                                  const Diagnosis& diagnosis,
                                  const std::vector<bool>& out) {
  std::vector<FlaggedRow> flagged;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const Row& row = observed.row(i);
    const bool is_out = out[static_cast<std::size_t>(i)];
    const bool is_marked = !row.flag.empty() && !IsKindOfReading(row.flag);
    if (!is_out && !is_marked) continue;
    flagged.push_back({.row = row.row,
                       .campaign = row.campaign,
                       .cmd_mm = {row.cmd_mm.begin(), row.cmd_mm.end()},
                       .value_mm = row.value_mm,
                       .left_um = UmFromMm(diagnosis.residual_after_mm[i]),
                       .sigmas = diagnosis.residual_after_mm[i] / diagnosis.sigma_mm[i],
                       .flag = row.flag,
                       .is_out = is_out});
  }
  return flagged;
}

}  // namespace

std::vector<EvidenceCell> EvidenceMapOf(const std::vector<EvidenceLine>& weighed) {
  std::map<std::pair<std::size_t, std::size_t>, EvidenceCell> best;
  for (const EvidenceLine& line : weighed) {
    for (const std::string& covariate : line.covariates) {
      const EvidenceCell cell{.channel = line.channel,
                              .covariate = covariate,
                              .log_odds = line.log_odds,
                              .cause = line.cause,
                              .axis = line.axis};
      const std::pair place = {PlaceIn(kChannels, cell.channel),
                               PlaceIn(kColumns, covariate)};
      const auto [found, is_new] = best.try_emplace(place, cell);
      if (!is_new && cell.log_odds > found->second.log_odds) found->second = cell;
    }
  }
  std::vector<EvidenceCell> cells;
  for (const auto& [place, cell] : best) cells.push_back(cell);
  return cells;
}

PicturesData PicturesDataOf(const Observed& as_read, const Diagnosis& diagnosis) {
  const Observed observed = AtBaseline(as_read);
  const std::vector<bool> out = LeftOut(observed, diagnosis);
  PicturesData data{.evidence_map = EvidenceMapOf(diagnosis.weighed),
                    .lack_of_fit = LackOfFitOf(observed, diagnosis, out),
                    .flagged = FlaggedOf(observed, diagnosis, out)};
  const auto visible_mm = VisibleOf(observed, diagnosis, out);
  for (std::size_t f = 0; f < diagnosis.findings.size(); ++f) {
    Eigen::VectorXd before_mm = diagnosis.residual_before_mm;
    for (std::size_t other = 0; other < visible_mm.size(); ++other) {
      if (other != f) before_mm -= visible_mm[other];
    }
    data.findings.push_back(
        SeriesOf(observed, diagnosis.findings[f], before_mm, diagnosis, out));
  }
  for (const Axis axis : kAxes) {
    DirectionContrast contrast = ContrastOf(observed, diagnosis, out, axis);
    if (contrast.at_mm.size() > 2) data.contrasts.push_back(std::move(contrast));
    auto periodogram = PeriodogramOf(as_read, diagnosis, axis);
    if (periodogram) data.periodograms.push_back(std::move(*periodogram));
  }
  return data;
}

}  // namespace caltwin
