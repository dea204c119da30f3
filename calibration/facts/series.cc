#include "calibration/facts/series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

using Place = std::array<long, 3>;

bool IsHeight(const Row& row) {
  return row.kind == RowKind::kTouch && row.n[2] > 0.999 && Known(row.cmd_mm[0]) &&
         Known(row.cmd_mm[1]);
}

Place PlaceKey(const Row& row) {
  Place place{};
  for (std::size_t k = 0; k < 3; ++k) {
    place[k] = Known(row.cmd_mm[k]) ? std::lround(row.cmd_mm[k] * 100) : -1;
  }
  return place;
}

double LeftBy(const Eigen::MatrixXd& columns, const Eigen::VectorXd& values) {
  const Eigen::VectorXd left = values - columns * LeastSquares(columns, values);
  const auto dof = std::max<Eigen::Index>(1, values.size() - columns.cols());
  return std::sqrt(left.squaredNorm() / static_cast<double>(dof));
}

// Each touch at another place, each millimetres further than the one before: not a bed.
void AddRunaway(const Rows& rows, Facts* facts) {
  constexpr std::size_t kFewest = 4;
  constexpr double kLeastStep_mm = 0.5;
  Rows heights;
  for (const Row* row : rows) {
    if (IsHeight(*row)) heights.push_back(row);
  }
  if (heights.size() < kFewest || heights.size() != rows.size()) return;
  const auto num = static_cast<Eigen::Index>(heights.size());
  const double change_mm = heights.back()->value_mm - heights.front()->value_mm;
  for (std::size_t i = 1; i < heights.size(); ++i) {
    const double step_mm = heights[i]->value_mm - heights[i - 1]->value_mm;
    if (step_mm * change_mm <= 0 || std::abs(step_mm) < kLeastStep_mm) return;
  }
  Eigen::MatrixXd in_order(num, 2), on_plane(num, 3);
  Eigen::VectorXd values_mm(num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const Row& row = *heights[static_cast<std::size_t>(i)];
    in_order.row(i) << 1, static_cast<double>(i);
    on_plane.row(i) << 1, row.cmd_mm[0], row.cmd_mm[1];
    values_mm[i] = row.value_mm;
  }
  const double by_order_mm = LeftBy(in_order, values_mm);
  const double by_plane_mm = LeftBy(on_plane, values_mm);
  if (by_order_mm > 0.5 * by_plane_mm) return;
  Fact fact{
      .id = "drift",
      .word = "order",
      .figures = {{"change_um", UmFromMm(change_mm), UmFromMm(by_order_mm)},
                  {"step_um", UmFromMm(change_mm / static_cast<double>(num - 1))}},
      .is_answer = true};
  for (const Row* row : heights) fact.rows.push_back(row->row);
  fact.sentence = fmt::format(
      "The readings {} with every touch, wherever it is, by {:.2g} mm each ({:.3g} mm "
      "in "
      "all): a line in the order of the touches leaves {:.2g} mm, a tilted plane "
      "{:.2g} mm. "
      "It is no tilted bed: Z loses or gains something at every touch (lost steps, a "
      "lift "
      "that is not counted, steps/mm). Touch one place five times, slower",
      change_mm > 0 ? "rise" : "fall",
      std::abs(change_mm) / static_cast<double>(num - 1),
      std::abs(change_mm),
      by_order_mm,
      by_plane_mm);
  // What a plane would say of it is not so.
  std::erase_if(facts->all, [](const Fact& other) {
    return other.id == "plane" || other.id == "twist" || other.id == "form";
  });
  facts->all.push_back(std::move(fact));
}

/// Heights of one map, by place.
using Map = std::map<Place, std::pair<double, double>>;

// How far one map lies from another at the same places.
struct Apart {
  double mean_mm = 0, scatter_mm = 0, sd_mm = 0;
  std::size_t num = 0;
};

void AddOffset(const std::string& before,
               const std::string& now,
               const Apart& apart,
               Facts* facts) {
  const auto& [mean_mm, scatter_mm, sd_mm, num_places] = apart;
  facts->all.push_back({.id = "offset",
                        .word = "zero",
                        .figures = {{"change_um", UmFromMm(mean_mm), UmFromMm(sd_mm)},
                                    {"scatter_um", UmFromMm(scatter_mm)}},
                        .sigmas = std::abs(mean_mm) / std::max(sd_mm, 1e-9),
                        .sentence = fmt::format(
                            "{} lies {} {} {} at every place ({} places, to {} um): "
                            "the shape is the same, "
                            "only the zero moved (homing, a probe offset applied in "
                            "one of them, warming). "
                            "A third with and one without homing between tells which",
                            now,
                            WithSd(std::abs(mean_mm), sd_mm, "mm"),
                            mean_mm > 0 ? "above" : "below",
                            before,
                            num_places,
                            TwoDigits(UmFromMm(scatter_mm))),
                        .is_answer = true});
  // No homing scatters by so much.
  constexpr double kMoved_mm = 0.5;
  if (std::abs(mean_mm) > kMoved_mm && facts->not_the_machine.reason.empty()) {
    facts->not_the_machine = {
        "probe_mount",
        fmt::format("Between the two maps only the height changed, by {}, and not the "
                    "shape: the bed and the frame stand as before, and the probe sits "
                    "at another height against the nozzle (moved, bent, another "
                    "offset). Find its offset anew",
                    WithSd(std::abs(mean_mm), sd_mm, "mm"))};
  }
}

// Two maps of the same places: apart by a constant, alike in shape.
void AddOffsets(const Rows& rows, const Repeats& repeats, Facts* facts) {
  constexpr std::size_t kFewest = 4;
  constexpr double kSure = 8;
  std::vector<std::string> names;
  std::map<std::string, Map> maps;
  for (const Row* row : rows) {
    if (!IsHeight(*row) || repeats.outliers.contains(row->row)) continue;
    if (!maps.contains(row->campaign)) names.push_back(row->campaign);
    auto& [sum_mm, num] = maps[row->campaign][PlaceKey(*row)];
    sum_mm += row->value_mm;
    num += 1;
  }
  for (std::size_t k = 1; k < names.size(); ++k) {
    const Map &before = maps[names[k - 1]], &now = maps[names[k]];
    std::vector<double> changes_mm, heights_mm;
    for (const auto& [place, sum] : now) {
      const auto other = before.find(place);
      if (other == before.end()) continue;
      const double then_mm = other->second.first / other->second.second;
      changes_mm.push_back(sum.first / sum.second - then_mm);
      heights_mm.push_back(then_mm);
    }
    if (changes_mm.size() < kFewest) continue;
    const auto num = static_cast<double>(changes_mm.size());
    double mean_mm = 0, squares_mm2 = 0;
    for (const double each_mm : changes_mm) mean_mm += each_mm / num;
    for (const double each_mm : changes_mm)
      squares_mm2 += std::pow(each_mm - mean_mm, 2);
    const double scatter_mm = std::sqrt(squares_mm2 / (num - 1));
    const double sd_mm = scatter_mm / std::sqrt(num);
    const bool is_constant = std::abs(mean_mm) > 3 * scatter_mm;
    if (!is_constant || std::abs(mean_mm) < kSure * sd_mm) continue;
    AddOffset(
        names[k - 1], names[k], {mean_mm, scatter_mm, sd_mm, changes_mm.size()}, facts);
    return;
  }
}

}  // namespace

void FactsOfSeries(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   Facts* facts) {
  AddRunaway(rows, facts);
  AddOffsets(rows, repeats, facts);
}

// z_offset falls where the probe is lifted: twist = -change over the travel / offset in
// y, right-handed about +x.
void FactsOfProbeOffset(const std::vector<const Row*>& rows, Facts* facts) {
  constexpr std::size_t kFewest = 4;
  constexpr double kSure = 6, kBeside_mm = 5;
  Rows offsets;
  for (const Row* row : rows) {
    if (row->feature == "nozzle.offset" && Known(row->cmd_mm[0]))
      offsets.push_back(row);
  }
  if (offsets.size() < kFewest) return;
  const auto num = static_cast<Eigen::Index>(offsets.size());
  Eigen::MatrixXd columns(num, 2);
  Eigen::VectorXd values_mm(num);
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;
  for (Eigen::Index i = 0; i < num; ++i) {
    const Row& row = *offsets[static_cast<std::size_t>(i)];
    columns.row(i) << 1, row.cmd_mm[0];
    values_mm[i] = row.value_mm;
    least_mm = std::min(least_mm, row.cmd_mm[0]);
    most_mm = std::max(most_mm, row.cmd_mm[0]);
  }
  const double range_mm = most_mm - least_mm;
  if (range_mm < 1) return;
  const Eigen::VectorXd line = LeastSquares(columns, values_mm);
  const double left_mm = LeftBy(columns, values_mm);
  const double spread_mm =
      std::sqrt((columns.col(1).array() - columns.col(1).mean()).square().sum());
  const double change_mm = line[1] * range_mm;
  const double sd_mm = left_mm / spread_mm * range_mm;
  if (std::abs(change_mm) < kSure * sd_mm) return;
  const double beside_mm = offsets.front()->probe_off_mm[1];
  Fact fact{.id = "offset",
            .word = "by_place",
            .figures = {{"change_um", UmFromMm(change_mm), UmFromMm(sd_mm)}},
            .sigmas = std::abs(change_mm) / std::max(sd_mm, 1e-9),
            .is_answer = true};
  const bool is_beside = Known(beside_mm) && std::abs(beside_mm) > kBeside_mm;
  if (is_beside) {
    const double twist_mrad = -1e3 * change_mm / beside_mm;
    fact.cause = "axis_twist";
    fact.cause_axis = "x";
    fact.parameters = {{"twist_mrad", twist_mrad, 1e3 * sd_mm / std::abs(beside_mm)}};
  }
  fact.sentence = fmt::format(
      "The probe's offset changes by {} from X {:g} to {:g}, in a straight line: it is "
      "not one "
      "number{}",
      WithSd(change_mm, sd_mm, "mm"),
      least_mm,
      most_mm,
      is_beside
          ? fmt::format(
                ". With the probe {:g} mm beside the nozzle along Y the X axis is "
                "twisted by {} over that length. Shim the ends of its rods or rail, or "
                "use the firmware's compensation for a twisted axis; a mesh probed "
                "like this is wrong by as much",
                std::abs(beside_mm),
                WithSd(fact.parameters[0].value, fact.parameters[0].sd, "mrad"))
          : "");
  facts->all.push_back(std::move(fact));
}

void TellBadProbe(const std::vector<const Row*>& rows,
                  const Repeats& repeats,
                  Facts* facts) {
  constexpr double kHigh_mm = 0.3, kRepeats_mm = 0.1;
  if (repeats.outliers.empty() || !facts->not_the_machine.reason.empty()) return;
  if (Known(repeats.noise.sd_mm) && repeats.noise.sd_mm > kRepeats_mm) return;
  std::size_t num_high = 0, num_places = 0;
  double highest_mm = 0;
  for (const Row* row : rows) {
    if (!repeats.outliers.contains(row->row) || !IsHeight(*row)) continue;
    std::vector<double> others_mm;
    for (const Row* other : rows) {
      if (!repeats.outliers.contains(other->row) && IsHeight(*other) &&
          PlaceKey(*other) == PlaceKey(*row)) {
        others_mm.push_back(other->value_mm);
      }
    }
    if (others_mm.empty()) continue;
    ++num_places;
    const double up_mm = row->value_mm - Median(others_mm);
    num_high += up_mm > kHigh_mm ? 1 : 0;
    highest_mm = std::max(highest_mm, up_mm);
  }
  if (num_high < 2 || num_high < num_places) return;
  facts->not_the_machine = {
      "probe_mount",
      fmt::format(
          "The probe triggers by itself now and then: {} touches ended up to {:.2g} mm "
          "high in the air, at places that read right otherwise. Look at its spring, "
          "switch, wire and mount before any calibration",
          num_high,
          highest_mm)};
}

}  // namespace caltwin
