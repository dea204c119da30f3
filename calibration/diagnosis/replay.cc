#include "calibration/diagnosis/replay.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/as_found.h"
#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/whole_tables.h"
#include "calibration/estimate/linear_fit.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSmallPart = 0.5;   // Of a row's noise.
constexpr double kFinest_mm = 1e-4;  // No noise is believed to be smaller.
constexpr std::size_t kNamedRows = 10;

// Noise of each row as judged; 0: the row does not count.
Eigen::VectorXd SigmaOf(const Observed& observed, const Diagnosis& diagnosis) {
  Eigen::VectorXd sigma_mm = diagnosis.sigma_mm.cwiseMax(kFinest_mm);
  for (Eigen::Index i = 0; i < sigma_mm.size(); ++i) {
    const bool is_out =
        std::ranges::find(diagnosis.outlier_rows, observed.row(i).row) !=
        diagnosis.outlier_rows.end();
    if (is_out) sigma_mm[i] = 0;
  }
  return sigma_mm;
}

// The values of columns, in their units, that fit readings best; priors count as a
// reading each.
Eigen::VectorXd FitOf(const Eigen::VectorXd& left_mm,
                      const std::vector<Nuisance>& columns,
                      const Eigen::VectorXd& sigma_mm) {
  const Eigen::Index n = left_mm.size();
  const auto k = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd white = Eigen::MatrixXd::Zero(n + k, k);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + k);
  Eigen::VectorXd prior_sd(k);
  for (Eigen::Index c = 0; c < k; ++c) {
    const Nuisance& column = columns[static_cast<std::size_t>(c)];
    prior_sd[c] = column.prior_sd;
    white.col(c).head(n) = column.column_mm * column.prior_sd;
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const double weight = sigma_mm[i] > 0 ? 1 / sigma_mm[i] : 0;
    white.row(i) *= weight;
    right[i] = left_mm[i] * weight;
  }
  white.bottomRows(k).setIdentity();
  return prior_sd.cwiseProduct(SolveLinear(white, right).x);
}

// What they leave.
Eigen::VectorXd LeftOf(Eigen::VectorXd left_mm,
                       const std::vector<Nuisance>& columns,
                       const Eigen::VectorXd& sigma_mm) {
  if (columns.empty()) return left_mm;
  const Eigen::VectorXd values = FitOf(left_mm, columns, sigma_mm);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    left_mm -= columns[c].column_mm * values[static_cast<Eigen::Index>(c)];
  }
  return left_mm;
}

double Rms_mm(const Eigen::VectorXd& left_mm, const Eigen::VectorXd& sigma_mm) {
  double sum = 0;
  int rows = 0;
  for (Eigen::Index i = 0; i < left_mm.size(); ++i) {
    if (sigma_mm[i] == 0) continue;
    sum += left_mm[i] * left_mm[i];
    ++rows;
  }
  return std::sqrt(sum / std::max(rows, 1));
}

// A twin of the machine with these findings, the baseline as it is beside them.
struct Extended {
  AsFound as_found{};
  std::vector<BaselineLine> lines{};  ///< Of the baseline, as fitted.
  std::vector<Nuisance> not_built{};  ///< Columns of the baseline that it lacks.
};

// A line that the rows do not determine is left as drawn: whatever number came out is
// none, and left free it would take up what the finding leaves.
Extended ExtendedBy(const Observed& observed,
                    const std::vector<Finding>& findings,
                    const Eigen::VectorXd& sigma_mm,
                    const std::set<std::string>& open) {
  std::vector<Nuisance> found;
  Eigen::VectorXd change_mm = Eigen::VectorXd::Zero(observed.num_rows());
  for (const Finding& finding : findings) {
    found.push_back({.name = finding.cause, .column_mm = finding.change_mm});
    change_mm += finding.change_mm;
  }
  constexpr int kRounds = 4;
  Observed at = AtBaseline(observed, found);
  std::vector<Nuisance> baseline = BaselineOf(at);
  Eigen::VectorXd values = FitOf(at.residual_mm() - change_mm, baseline, sigma_mm);
  const DiagnosedKind& kind = DiagnosedAs(observed.machine());
  // Lines that turn a build trade far before the rows tell them apart: straight only so
  // far.
  for (int round = 0; kind.turns_build() && round < kRounds; ++round) {
    Eigen::VectorXd left_mm = at.residual_mm() - change_mm;
    for (std::size_t k = 0; k < baseline.size(); ++k) {
      left_mm -= baseline[k].column_mm * values[static_cast<Eigen::Index>(k)];
    }
    at = TurnedBy(observed, at, baseline, values, left_mm);
    baseline = BaselineOf(at);
    values = FitOf(at.residual_mm() - change_mm, baseline, sigma_mm);
  }
  std::vector<BaselineLine> lines;
  for (std::size_t k = 0; k < baseline.size(); ++k) {
    if (open.contains(baseline[k].name)) continue;
    lines.push_back(
        {.name = baseline[k].name,
         .value = baseline[k].offset + values[static_cast<Eigen::Index>(k)]});
  }
  Extended extended{.as_found = AsFoundBy(observed, lines, findings), .lines = lines};
  for (const Nuisance& one : baseline) {
    const bool is_left = open.contains(one.name) && !IsPlace(one.name);
    if (!is_left && !extended.as_found.built.contains(one.name)) {
      if (kind.Turns(one.name)) continue;
      extended.not_built.push_back(one);
    }
  }
  return extended;
}

class Replayer {
 public:
  Replayer(const Observed& observed,
           const Diagnosis& diagnosis,
           const ReplayOptions& options)
      : observed_(observed),
        options_(options),
        sigma_mm_(SigmaOf(observed, diagnosis)),
        floor_mm_(diagnosis.gain.noise_floor_mm) {
    // Lines that turn a build are known together, though not one by one.
    if (DiagnosedAs(observed.machine()).turns_build()) return;
    for (const BaselineLine& line : diagnosis.baseline) {
      if (!line.is_determined) open_.insert(line.name);
    }
  }

  Replay Make(const std::vector<Finding>& findings) {
    Replay replay{.is_generic_model = observed_.machine().model.empty(),
                  .has_findings = !findings.empty(),
                  .rows = static_cast<int>((sigma_mm_.array() > 0).count())};
    const Extended with = ExtendedBy(observed_, findings, sigma_mm_, open_);
    const Eigen::VectorXd with_mm = Read_mm(with, Fidelity::kPhysics);
    Compare(with_mm - Read_mm(with, Fidelity::kFast), &replay);
    Eigen::VectorXd rest_mm = Measured_mm() - with_mm;
    for (const std::size_t i : with.as_found.not_built) {
      const Finding& finding = findings[i];
      replay.as_fitted.push_back(
          finding.axis.empty() ? finding.cause : finding.cause + "." + finding.axis);
      rest_mm -= finding.change_mm;
    }
    replay.left_after_mm = LeftOf(rest_mm, with.not_built, sigma_mm_);
    replay.left_before_mm = findings.empty() ? replay.left_after_mm : LeftBefore_mm();
    replay.before_mm = Rms_mm(replay.left_before_mm, sigma_mm_);
    replay.after_mm = Rms_mm(replay.left_after_mm, sigma_mm_);
    replay.floor_mm = floor_mm_;
    for (const std::string& line : open_) {
      if (!IsPlace(line)) replay.as_drawn.push_back(line);
    }
    if (was_interrupted_) return {.why_not = "The replay was interrupted."};
    return replay;
  }

 private:
  Eigen::VectorXd LeftBefore_mm() {
    const Extended without = ExtendedBy(observed_, {}, sigma_mm_, open_);
    return LeftOf(Measured_mm() - Read_mm(without, Fidelity::kPhysics),
                  without.not_built,
                  sigma_mm_);
  }

  Eigen::VectorXd Measured_mm() const {
    Eigen::VectorXd values_mm(observed_.num_rows());
    for (Eigen::Index i = 0; i < values_mm.size(); ++i) {
      values_mm[i] = observed_.row(i).value_mm;
    }
    return values_mm;
  }

  Eigen::VectorXd Read_mm(const Extended& twin, Fidelity fidelity) {
    const RowTable table = DiagnosedAs(observed_.machine())
                               .Performed(observed_,
                                          {.effects = twin.as_found.effects,
                                           .lines = twin.lines,
                                           .fidelity = fidelity,
                                           .interrupted = options_.interrupted});
    Eigen::VectorXd values_mm = Eigen::VectorXd::Zero(observed_.num_rows());
    if (table.rows.size() < observed_.table().rows.size()) was_interrupted_ = true;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      values_mm[static_cast<Eigen::Index>(i)] = table.rows[i].value_mm;
    }
    return values_mm;
  }

  void Compare(const Eigen::VectorXd& apart_mm, Replay* replay) const {
    replay->form_rms_mm = Rms_mm(apart_mm, sigma_mm_);
    for (Eigen::Index i = 0; i < apart_mm.size(); ++i) {
      if (sigma_mm_[i] == 0) continue;
      replay->form_max_mm = std::max(replay->form_max_mm, std::abs(apart_mm[i]));
      if (std::abs(apart_mm[i]) > kSmallPart * sigma_mm_[i]) {
        replay->far_rows.push_back(observed_.row(i).row);
      }
    }
  }

  const Observed& observed_;
  const ReplayOptions& options_;
  Eigen::VectorXd sigma_mm_;
  double floor_mm_ = 0;
  std::set<std::string> open_{};  ///< Lines that the rows do not determine.
  bool was_interrupted_ = false;
};

std::string FarText(const Replay& replay) {
  const std::size_t named = std::min(kNamedRows, replay.far_rows.size());
  const std::string more =
      replay.far_rows.size() > named
          ? fmt::format(" and {} more", replay.far_rows.size() - named)
          : "";
  return fmt::format(
      "MuJoCo and the closed form differ by more than half of the noise in row{} {}{} "
      "(at most {:.2f} um): do not lean on them.\n",
      replay.far_rows.size() == 1 ? "" : "s",
      fmt::join(replay.far_rows.begin(),
                replay.far_rows.begin() + static_cast<std::ptrdiff_t>(named),
                ", "),
      more,
      UmFromMm(replay.form_max_mm));
}

}  // namespace

Replay ReplayOf(const Observed& observed,
                const Diagnosis& diagnosis,
                const ReplayOptions& options) {
  if (observed.num_rows() > options.most_rows) {
    return {.why_not = fmt::format(
                "Not replayed in MuJoCo: {} rows, and more than {} take long; --replay "
                "physics does it all the same.",
                observed.num_rows(),
                options.most_rows)};
  }
  try {
    return Replayer(observed, diagnosis, options).Make(diagnosis.findings);
  } catch (const InputError& error) {
    return {.why_not = fmt::format("Not replayed in MuJoCo: {}.", error.what())};
  }
}

std::string ReplayText(const Replay& replay) {
  constexpr double kWorse = 1.02;  // More than rounding and chance.
  constexpr double kFar = 3, kSmall_mm = 1e-3;
  if (!replay.why_not.empty()) return replay.why_not + "\n";
  std::string text = fmt::format(
      "Replayed in MuJoCo ({}): {:.1f} um rms of {} rows before the findings act in "
      "the "
      "twin, {:.1f} after; closed form and twin differ by {:.2f} um rms, {:.2f} at "
      "most.\n",
      replay.is_generic_model ? "a generic model, the machine file names none"
                              : "the machine's own model",
      UmFromMm(replay.before_mm),
      replay.rows,
      UmFromMm(replay.after_mm),
      UmFromMm(replay.form_rms_mm),
      UmFromMm(replay.form_max_mm));
  if (replay.after_mm > kWorse * replay.before_mm) {
    text +=
        "WARNING: with the findings the twin is further from the rows than without: "
        "its pose, its datum or the machine file are not those of the measurement, or "
        "the findings are wrong.\n";
  }
  if (replay.floor_mm > 0 && replay.after_mm > kSmall_mm &&
      replay.after_mm > kFar * replay.floor_mm) {
    text += fmt::format(
        "The twin{} still leaves {:.1f} times the noise floor of {:.1f} um: some cause "
        "is missing, or a value found is wrong{}.\n",
        replay.has_findings ? " with the findings" : "",
        replay.after_mm / replay.floor_mm,
        UmFromMm(replay.floor_mm),
        replay.as_drawn.empty()
            ? ""
            : fmt::format(
                  ", or it is what these rows do not determine and the twin has "
                  "as drawn ({})",
                  fmt::join(replay.as_drawn, ", ")));
  }
  if (!replay.far_rows.empty()) text += FarText(replay);
  if (!replay.as_fitted.empty()) {
    text += fmt::format("No twin can be built with {}: taken as fitted.\n",
                        fmt::join(replay.as_fitted, ", "));
  }
  return text;
}

nlohmann::ordered_json ReplayJson(const Replay& replay) {
  if (!replay.why_not.empty()) return nullptr;
  return {{"rmse_before_um", UmFromMm(replay.before_mm)},
          {"rmse_after_um", UmFromMm(replay.after_mm)},
          {"closed_form_rms_um", UmFromMm(replay.form_rms_mm)},
          {"closed_form_max_um", UmFromMm(replay.form_max_mm)},
          {"rows", replay.rows},
          {"rows_apart", replay.far_rows},
          {"findings_as_fitted", replay.as_fitted},
          {"model", replay.is_generic_model ? "generic" : "file"}};
}

}  // namespace caltwin
