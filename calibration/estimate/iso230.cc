#include "calibration/estimate/iso230.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSameTarget_mm = 1e-4;
constexpr double kAlongAxis = 0.999;  // Of n: a cosine error of 0.1 %.
constexpr int kRunsOfStandard = 5;
constexpr std::size_t kPositionsOfStandard = 5;

constexpr std::array kSymbols = {
    NamedSymbol{"A", &Iso230Symbols::a, "accuracy, both directions"},
    NamedSymbol{"R", &Iso230Symbols::r, "repeatability, both directions"},
    NamedSymbol{"E", &Iso230Symbols::e, "systematic error, both directions"},
    NamedSymbol{"M", &Iso230Symbols::m, "range of the mean error"},
    NamedSymbol{"B", &Iso230Symbols::b, "largest reversal value"},
    NamedSymbol{"B_mean", &Iso230Symbols::b_mean, "mean reversal value"},
    NamedSymbol{"A_fwd", &Iso230Symbols::a_fwd, "accuracy, forward"},
    NamedSymbol{"A_bwd", &Iso230Symbols::a_bwd, "accuracy, backward"},
    NamedSymbol{"R_fwd", &Iso230Symbols::r_fwd, "repeatability, forward"},
    NamedSymbol{"R_bwd", &Iso230Symbols::r_bwd, "repeatability, backward"},
    NamedSymbol{"E_fwd", &Iso230Symbols::e_fwd, "systematic error, forward"},
    NamedSymbol{"E_bwd", &Iso230Symbols::e_bwd, "systematic error, backward"},
};

/// Readings at one target.
struct Readings {
  double target_mm = 0;
  std::vector<double> forward_mm{}, backward_mm{};
};

std::optional<double> MeanOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::optional<double> SdOf(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  const double mean = MeanOf(values).value();
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

/// Rows of the choice, grouped by target, ascending.
std::vector<Readings> Grouped(const std::vector<const Row*>& rows, Axis axis) {
  std::vector<const Row*> sorted = rows;
  const auto target_mm = [axis](const Row* row) {
    return row->cmd_mm[Index(axis)];
  };
  std::ranges::stable_sort(sorted, {}, target_mm);
  std::vector<Readings> groups;
  for (const Row* row : sorted) {
    if (groups.empty() || target_mm(row) - groups.back().target_mm > kSameTarget_mm) {
      groups.push_back({.target_mm = target_mm(row)});
    }
    const double sense = row->dir[Index(axis)];
    const double x_mm = std::copysign(1.0, row->n[Index(axis)]) * row->value_mm;
    if (sense == 1) groups.back().forward_mm.push_back(x_mm);
    if (sense == -1) groups.back().backward_mm.push_back(x_mm);
  }
  return groups;
}

Iso230Position PositionOf(const Readings& readings) {
  Iso230Position position{
      .target_mm = readings.target_mm,
      .runs_fwd = static_cast<int>(readings.forward_mm.size()),
      .runs_bwd = static_cast<int>(readings.backward_mm.size()),
      .mean_fwd_mm = MeanOf(readings.forward_mm),
      .mean_bwd_mm = MeanOf(readings.backward_mm),
      .s_fwd_mm = SdOf(readings.forward_mm),
      .s_bwd_mm = SdOf(readings.backward_mm),
  };
  if (position.mean_fwd_mm && position.mean_bwd_mm) {
    position.b_mm = *position.mean_fwd_mm - *position.mean_bwd_mm;
  }
  return position;
}

/// Least and greatest of what was put in; unknown as soon as one of them is.
class Range {
 public:
  void Take(std::optional<double> value) {
    is_known_ = is_known_ && value.has_value();
    if (!value) return;
    least_ = std::min(least_, *value);
    greatest_ = std::max(greatest_, *value);
  }
  std::optional<double> width() const {
    if (!is_known_ || greatest_ < least_) return std::nullopt;
    return greatest_ - least_;
  }
  std::optional<double> greatest() const {
    if (!is_known_ || greatest_ < least_) return std::nullopt;
    return greatest_;
  }

 private:
  bool is_known_ = true;
  double least_ = std::numeric_limits<double>::infinity();
  double greatest_ = -std::numeric_limits<double>::infinity();
};

std::optional<double> Sum(std::optional<double> a,
                          std::optional<double> b,
                          double factor) {
  if (!a || !b) return std::nullopt;
  return *a + factor * *b;
}

/// R_i; `by_means` says whether the branch with B_i is the largest.
struct Repeatability {
  std::optional<double> value{};
  bool by_means = false;
};

Repeatability RepeatabilityOf(const Iso230Position& position) {
  if (!position.b_mm || !position.s_fwd_mm || !position.s_bwd_mm) return {};
  const double forward = *position.s_fwd_mm, backward = *position.s_bwd_mm;
  const double by_means = 2 * forward + 2 * backward + std::abs(*position.b_mm);
  const double by_scatter = 4 * std::max(forward, backward);
  return {.value = std::max(by_means, by_scatter), .by_means = by_means >= by_scatter};
}

/// One direction's accuracy and systematic error, added also to those of both.
struct Direction {
  std::optional<double> Iso230Position::*mean_mm;
  std::optional<double> Iso230Position::*s_mm;
  std::optional<double> Iso230Symbols::*a;
  std::optional<double> Iso230Symbols::*r;
  std::optional<double> Iso230Symbols::*e;
};
constexpr std::array kDirections = {
    Direction{&Iso230Position::mean_fwd_mm,
              &Iso230Position::s_fwd_mm,
              &Iso230Symbols::a_fwd,
              &Iso230Symbols::r_fwd,
              &Iso230Symbols::e_fwd},
    Direction{&Iso230Position::mean_bwd_mm,
              &Iso230Position::s_bwd_mm,
              &Iso230Symbols::a_bwd,
              &Iso230Symbols::r_bwd,
              &Iso230Symbols::e_bwd},
};

Iso230Symbols SymbolsOf(const std::vector<Iso230Position>& positions) {
  Iso230Symbols symbols;
  Range accuracy, systematic;
  for (const Direction& direction : kDirections) {
    Range own_accuracy, own_systematic, own_s;
    for (const Iso230Position& position : positions) {
      const auto mean = position.*direction.mean_mm, s = position.*direction.s_mm;
      own_s.Take(s);
      for (Range* range : {&systematic, &own_systematic}) range->Take(mean);
      for (Range* range : {&accuracy, &own_accuracy}) {
        range->Take(Sum(mean, s, 2));
        range->Take(Sum(mean, s, -2));
      }
    }
    symbols.*direction.a = own_accuracy.width();
    symbols.*direction.e = own_systematic.width();
    if (const auto most = own_s.greatest()) symbols.*direction.r = 4 * *most;
  }
  symbols.a = accuracy.width();
  symbols.e = systematic.width();
  Range repeatability, mean, reversal;
  std::optional<double> reversal_sum = 0;
  for (const Iso230Position& position : positions) {
    repeatability.Take(RepeatabilityOf(position).value);
    const auto twice_mean = Sum(position.mean_fwd_mm, position.mean_bwd_mm, 1);
    mean.Take(twice_mean ? std::optional(*twice_mean / 2) : std::nullopt);
    reversal.Take(position.b_mm ? std::optional(std::abs(*position.b_mm))
                                : std::nullopt);
    reversal_sum = Sum(reversal_sum, position.b_mm, 1);
  }
  symbols.r = repeatability.greatest();
  symbols.m = mean.width();
  symbols.b = reversal.greatest();
  if (reversal_sum && !positions.empty()) {
    symbols.b_mean = *reversal_sum / static_cast<double>(positions.size());
  }
  return symbols;
}

Iso230Symbols ExpandedOf(const Iso230Sheet& sheet, const Iso230Budget& budget) {
  if (!budget.is_known || sheet.runs_min < 1) return {};
  const double n = sheet.runs_min;
  const double m = static_cast<double>(sheet.positions.size());
  const double u_r = MmFromUm(std::hypot(budget.reading_u_um, budget.environment_u_um));
  const double u_l = MmFromUm(
      std::hypot(budget.device_u_um, budget.alignment_u_um, budget.temperature_u_um));
  const double of_scatter =
      4 * u_r / std::sqrt(n - 1);  // Infinite, but unused, if n = 1.
  double of_r = 0;
  for (const Iso230Position& position : sheet.positions) {
    const Repeatability r = RepeatabilityOf(position);
    if (r.value != sheet.symbols.r) continue;
    of_r = r.by_means ? u_r * std::sqrt(8 / (n - 1) + 2 / n) : of_scatter;
  }
  const double of_means = std::hypot(u_l, u_r * std::sqrt(2 / n));
  const double of_accuracy = std::hypot(u_l, u_r * std::sqrt(2 / n + 8 / (n - 1)));
  const Iso230Symbols u = {
      .a = of_accuracy,
      .r = of_r,
      .e = of_means,
      .m = std::hypot(u_l, u_r / std::sqrt(n)),
      .b = u_r * std::sqrt(2 / n),
      .b_mean = u_r * std::sqrt(2 / (n * m)),
      .a_fwd = of_accuracy,
      .a_bwd = of_accuracy,
      .r_fwd = of_scatter,
      .r_bwd = of_scatter,
      .e_fwd = of_means,
      .e_bwd = of_means,
  };
  Iso230Symbols expanded;
  for (const NamedSymbol& symbol : kSymbols) {
    if (sheet.symbols.*symbol.value) expanded.*symbol.value = 2 * *(u.*symbol.value);
  }
  return expanded;
}

std::optional<Span> SpanOf(const std::vector<const Row*>& rows, double Row::*member) {
  std::optional<Span> span;
  for (const Row* row : rows) {
    const double value = row->*member;
    if (!Known(value)) continue;
    if (!span) span = Span{value, value};
    span->min = std::min(span->min, value);
    span->max = std::max(span->max, value);
  }
  return span;
}

bool IsRegular(const std::vector<Iso230Position>& positions) {
  if (positions.size() < 3) return false;
  const double step_mm = positions[1].target_mm - positions[0].target_mm;
  for (std::size_t i = 2; i < positions.size(); ++i) {
    const double next_mm = positions[i].target_mm - positions[i - 1].target_mm;
    if (std::abs(next_mm - step_mm) > 2 * kSameTarget_mm) return false;
  }
  return true;
}

bool Differ(const std::vector<const Row*>& rows, std::string Row::*member) {
  return std::ranges::any_of(
      rows, [&](const Row* row) { return row->*member != rows.front()->*member; });
}

std::vector<std::string> RemarksOn(const Iso230Sheet& sheet,
                                   const std::vector<const Row*>& rows) {
  std::vector<std::string> remarks;
  const auto& positions = sheet.positions;
  const auto say = [&](bool applies, const std::string& remark) {
    if (applies) remarks.push_back(remark);
  };
  say(sheet.rows_without_direction > 0,
      fmt::format("{} readings have no direction and are left out",
                  sheet.rows_without_direction));
  const auto has_both = [](const Iso230Position& p) {
    return p.b_mm.has_value();
  };
  const auto complete = std::ranges::count_if(positions, has_both);
  say(complete < static_cast<std::ptrdiff_t>(positions.size()),
      fmt::format("{} of {} positions were not reached from both directions: what "
                  "needs both is not stated",
                  static_cast<std::ptrdiff_t>(positions.size()) - complete,
                  positions.size()));
  say(sheet.runs_min < kRunsOfStandard,
      fmt::format("ISO 230-2 asks for {} runs in each direction, here are {}",
                  kRunsOfStandard,
                  sheet.runs_min));
  say(sheet.runs_min != sheet.runs_max,
      fmt::format("the number of runs differs between positions: {} to {}",
                  sheet.runs_min,
                  sheet.runs_max));
  say(positions.size() < kPositionsOfStandard,
      fmt::format("ISO 230-2 asks for at least {} positions, here are {}",
                  kPositionsOfStandard,
                  positions.size()));
  say(IsRegular(positions),
      "the positions are evenly spaced: an error that repeats with their spacing, or a "
      "fraction of it, is not seen");
  say(Differ(rows, &Row::setup),
      "the rows belong to several setups: what their placement differs by counts as "
      "scatter");
  say(Differ(rows, &Row::settings),
      "the rows were measured under several settings: they count as one machine here");
  return remarks;
}

}  // namespace

std::span<const NamedSymbol> AllIso230Symbols() {
  return kSymbols;
}

bool MeasuresAlong(const Row& row, Axis axis) {
  return row.kind == RowKind::kPosition && Known(row.cmd_mm[Index(axis)]) &&
         std::abs(row.n[Index(axis)]) > kAlongAxis;
}

std::vector<Iso230Choice> Iso230Choices(const RowTable& table) {
  struct Choice {
    Iso230Choice choice{};
    double first_mm = 0;
    bool moves = false;
  };
  std::vector<Choice> candidates;
  for (const Row& row : table.rows) {
    for (const Axis axis : kAxes) {
      if (!MeasuresAlong(row, axis)) continue;
      const double target_mm = row.cmd_mm[Index(axis)];
      auto found = std::ranges::find_if(candidates, [&](const Choice& c) {
        return c.choice.axis == axis && c.choice.campaign == row.campaign;
      });
      if (found == candidates.end()) {
        candidates.push_back({{axis, row.campaign}, target_mm});
      } else if (std::abs(target_mm - found->first_mm) > kSameTarget_mm) {
        found->moves = true;
      }
    }
  }
  std::vector<Iso230Choice> choices;
  for (const Choice& candidate : candidates) {
    if (candidate.moves) choices.push_back(candidate.choice);
  }
  return choices;
}

Iso230Sheet EvaluateIso230(const RowTable& table,
                           const Iso230Choice& choice,
                           const Iso230Budget& budget) {
  Iso230Sheet sheet{.axis = choice.axis, .campaign = choice.campaign};
  std::vector<const Row*> rows;
  for (const Row& row : table.rows) {
    if (row.campaign != choice.campaign || !MeasuresAlong(row, choice.axis)) continue;
    const double sense = row.dir[Index(choice.axis)];
    if (sense == 1 || sense == -1) {
      rows.push_back(&row);
    } else {
      ++sheet.rows_without_direction;
    }
  }
  for (const Readings& readings : Grouped(rows, choice.axis)) {
    sheet.positions.push_back(PositionOf(readings));
  }
  for (const Iso230Position& position : sheet.positions) {
    for (const int runs : {position.runs_fwd, position.runs_bwd}) {
      if (runs == 0) continue;
      sheet.runs_min = sheet.runs_min == 0 ? runs : std::min(sheet.runs_min, runs);
      sheet.runs_max = std::max(sheet.runs_max, runs);
    }
  }
  sheet.symbols = SymbolsOf(sheet.positions);
  sheet.expanded_u = ExpandedOf(sheet, budget);
  sheet.ambient_c = SpanOf(rows, &Row::temp_ambient_c);
  sheet.screw_c = SpanOf(rows, &Row::temp_screw_c);
  sheet.time_s = SpanOf(rows, &Row::t_s);
  sheet.feed_mm_s = SpanOf(rows, &Row::feed_mm_s);
  sheet.remarks = RemarksOn(sheet, rows);
  return sheet;
}

}  // namespace caltwin
