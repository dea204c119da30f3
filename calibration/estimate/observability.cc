#include "calibration/estimate/observability.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// Below this an entry of a unit direction is rounding, not a share in it.
constexpr double kZero = 1e-4;

// Who leads a sum and who is told relative to others: the lower, the further front.
int Order(std::string_view name) {
  constexpr std::string_view kFront[] = {
      "probe_pretravel", "backlash", "steps_per_mm", "bed_tilt", "squareness"};
  constexpr std::string_view kBack[] = {
      "trigger_latency", "probe_hysteresis", "tip_size", "placement"};
  const std::string_view cause = name.substr(0, name.find('.'));
  constexpr int kMiddle = 50;
  if (const auto* at = std::ranges::find(kFront, cause); at != std::end(kFront)) {
    return static_cast<int>(at - std::begin(kFront));
  }
  if (const auto* at = std::ranges::find(kBack, cause); at != std::end(kBack)) {
    return kMiddle + 1 + static_cast<int>(at - std::begin(kBack));
  }
  return kMiddle;
}

// The rows of `basis` made sparse: reduced row echelon form, pivots sought in the order
// of `columns`. Returns the pivot column of each row.
std::vector<Eigen::Index> Reduce(std::span<const Eigen::Index> columns,
                                 Eigen::MatrixXd* basis) {
  std::vector<Eigen::Index> pivots;
  for (const Eigen::Index column : columns) {
    const auto row = static_cast<Eigen::Index>(pivots.size());
    if (row == basis->rows()) break;
    Eigen::Index best = 0;
    const double largest =
        basis->col(column).tail(basis->rows() - row).cwiseAbs().maxCoeff(&best);
    if (largest < kZero) continue;
    basis->row(row).swap(basis->row(row + best));
    basis->row(row) /= (*basis)(row, column);
    for (Eigen::Index other = 0; other < basis->rows(); ++other) {
      if (other == row) continue;
      const double factor = (*basis)(other, column);
      basis->row(other) -= factor * basis->row(row);
    }
    pivots.push_back(column);
  }
  *basis = (basis->array().abs() < kZero).select(0, *basis);
  return pivots;
}

// Blind directions that share unknowns, and those unknowns.
struct BlindGroup {
  std::vector<Eigen::Index> rows{};
  std::vector<Eigen::Index> columns{};
};

bool Shares(const Eigen::MatrixXd& basis, Eigen::Index row, const BlindGroup& group) {
  return std::ranges::any_of(
      group.columns, [&](Eigen::Index column) { return basis(row, column) != 0; });
}

std::vector<BlindGroup> GroupsOf(const Eigen::MatrixXd& basis) {
  std::vector<BlindGroup> groups;
  for (Eigen::Index row = 0; row < basis.rows(); ++row) {
    BlindGroup merged{.rows = {row}};
    for (Eigen::Index column = 0; column < basis.cols(); ++column) {
      if (basis(row, column) != 0) merged.columns.push_back(column);
    }
    std::erase_if(groups, [&](const BlindGroup& group) {
      if (!Shares(basis, row, group)) return false;
      merged.rows.insert(merged.rows.end(), group.rows.begin(), group.rows.end());
      merged.columns.insert(
          merged.columns.end(), group.columns.begin(), group.columns.end());
      return true;
    });
    std::ranges::sort(merged.rows);
    std::ranges::sort(merged.columns);
    const auto repeated = std::ranges::unique(merged.columns);
    merged.columns.erase(repeated.begin(), repeated.end());
    groups.push_back(std::move(merged));
  }
  return groups;
}

// What a group's blind directions leave determined, in words. Of a reduced basis
// [I F] with pivots p, the complement is spanned by x_q - sum_p F_pq x_p, one sum for
// each unknown q that is not a pivot.
std::string Statement(const BlindGroup& group,
                      const Eigen::MatrixXd& basis,
                      std::span<const Eigen::Index> pivots,
                      std::span<const std::string> names) {
  std::string told;
  for (const Eigen::Index lead : group.columns) {
    if (std::ranges::find(pivots, lead) != pivots.end()) continue;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(basis.cols());
    sum[lead] = 1;
    for (const Eigen::Index row : group.rows) {
      sum[pivots[static_cast<std::size_t>(row)]] = -basis(row, lead);
    }
    if (!told.empty()) told += " and ";
    told += CombinationInWords(names, sum);
  }
  if (!told.empty()) return told + " only";
  return names[static_cast<std::size_t>(group.columns.front())] + " not at all";
}

std::map<std::string, double> ByName(std::span<const std::string> names,
                                     const Eigen::VectorXd& direction) {
  std::map<std::string, double> by_name;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) > kZero) {
      by_name[names[static_cast<std::size_t>(i)]] = direction[i];
    }
  }
  return by_name;
}

// A unit vector whose foremost unknown counts positive.
Eigen::VectorXd Oriented(const Eigen::VectorXd& direction) {
  double sign = 1;
  for (const double entry : direction) {
    if (std::abs(entry) < kZero) continue;
    sign = entry < 0 ? -1 : 1;
    break;
  }
  return sign * direction.normalized();
}

void AddBlind(const Eigen::MatrixXd& directions,
              std::span<const std::string> names,
              ObservabilityReport* report) {
  // The hindmost unknowns become pivots, so that the foremost lead the sums.
  std::vector<Eigen::Index> backwards(names.size());
  std::iota(backwards.rbegin(), backwards.rend(), 0);
  Eigen::MatrixXd basis = directions.transpose();
  const std::vector<Eigen::Index> pivots = Reduce(backwards, &basis);

  for (const BlindGroup& group : GroupsOf(basis)) {
    const std::string statement = Statement(group, basis, pivots, names);
    for (const Eigen::Index row : group.rows) {
      report->blind.push_back(
          {.statement = statement,
           .blind_direction = ByName(names, Oriented(basis.row(row).transpose()))});
    }
    std::vector<std::string> members;
    for (const Eigen::Index column : group.columns) {
      members.push_back(names[static_cast<std::size_t>(column)]);
    }
    for (std::string& advice : AdviceFor(members)) {
      if (std::ranges::find(report->advice, advice) == report->advice.end()) {
        report->advice.push_back(std::move(advice));
      }
    }
    report->undetermined.insert(
        report->undetermined.end(), members.begin(), members.end());
  }
}

void AddWeakest(const Spectrum& spectrum,
                std::span<const std::string> names,
                ObservabilityReport* report) {
  if (spectrum.rank == 0) return;
  const Eigen::VectorXd weakest = Oriented(spectrum.directions.col(spectrum.rank - 1));
  report->weakest = ByName(names, weakest);
  report->weakest_sd_mm = 1 / spectrum.singular_values[spectrum.rank - 1];
  // In words only what makes a tenth of it or more.
  const double largest = weakest.cwiseAbs().maxCoeff();
  const Eigen::VectorXd shown =
      (weakest.array().abs() < largest / 10).select(0, weakest / largest);
  report->weakest_statement =
      fmt::format("least known: {}, standard deviation {:.3g} um",
                  CombinationInWords(names, shown),
                  UmFromMm(report->weakest_sd_mm));
}

std::string Term(double size, const std::string& name) {
  for (int denominator = 1; denominator <= 12; ++denominator) {
    const double numerator = std::round(size * denominator);
    if (numerator < 1 ||
        std::abs(size * denominator - numerator) > 1e-3 * size * denominator) {
      continue;
    }
    if (numerator == 1 && denominator == 1) return name;
    if (denominator == 1) return fmt::format("{} {}", numerator, name);
    if (numerator == 1) return fmt::format("{} / {}", name, denominator);
    return fmt::format("{}/{} {}", numerator, denominator, name);
  }
  return fmt::format("{:.3g} {}", size, name);
}

}  // namespace

std::string CombinationInWords(std::span<const std::string> names,
                               const Eigen::VectorXd& coefficients) {
  std::string words;
  for (const double sign : {1.0, -1.0}) {
    for (Eigen::Index i = 0; i < coefficients.size(); ++i) {
      const double size = sign * coefficients[i];
      if (size < kZero) continue;
      const bool first = words.empty();
      words += sign > 0 ? (first ? "" : " + ") : (first ? "-" : " - ");
      words += Term(size, names[static_cast<std::size_t>(i)]);
    }
  }
  return words;
}

ObservabilityReport Observe(const Eigen::MatrixXd& whitened_jacobian,
                            std::span<const UnknownColumn> columns,
                            const RankRule& rule) {
  Require(whitened_jacobian.cols() == static_cast<Eigen::Index>(columns.size()),
          "a name for each column");
  std::vector<std::size_t> order(columns.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, {}, [&](std::size_t i) { return Order(columns[i].name); });
  Eigen::MatrixXd jacobian(whitened_jacobian.rows(), whitened_jacobian.cols());
  std::vector<std::string> names;
  for (const std::size_t i : order) {
    jacobian.col(static_cast<Eigen::Index>(names.size())) =
        whitened_jacobian.col(static_cast<Eigen::Index>(i)) / columns[i].mm_per_unit;
    names.push_back(columns[i].name);
  }

  const Spectrum spectrum = SpectrumOf(jacobian, rule);
  ObservabilityReport report{.rank = static_cast<int>(spectrum.rank),
                             .num_unknowns = static_cast<int>(jacobian.cols())};
  const Eigen::Index blind = jacobian.cols() - spectrum.rank;
  if (blind > 0) AddBlind(spectrum.directions.rightCols(blind), names, &report);
  AddWeakest(spectrum, names, &report);
  for (const std::string& name : names) {
    if (std::ranges::find(report.undetermined, name) == report.undetermined.end()) {
      report.determined.push_back(name);
    }
  }
  return report;
}

}  // namespace caltwin
