#include "renders/clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>

#include <fmt/format.h>

namespace caltwin {
namespace {

/// The way the tip moved into the surface: against its normal.
std::string ApproachText(const std::array<double, 3>& n) {
  for (const Axis axis : kAxes) {
    const double component = n[Index(axis)];
    if (component > 0.999) return fmt::format("-{}", Letter(axis));
    if (component < -0.999) return fmt::format("+{}", Letter(axis));
  }
  if (!Known(n[0]) || !Known(n[1]) || !Known(n[2])) return "unknown";
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", -n[0], -n[1], -n[2]);
}

std::string SenseText(const std::array<double, 3>& dir) {
  std::string text;
  for (const double sense : dir) {
    text += !Known(sense) ? '?' : sense > 0 ? '+' : sense < 0 ? '-' : '0';
  }
  return text;
}

/// All that makes two touches comparable. Nominal points are told apart to 0.01 mm.
std::string KeyOf(const Row& row) {
  return fmt::format("{}|{}|{}|{}|{}|{}|{:.2f}|{:.2f}|{:.2f}",
                     row.feature,
                     ApproachText(row.n),
                     SenseText(row.dir),
                     row.settings,
                     row.setup,
                     row.home,
                     row.cmd_mm[0],
                     row.cmd_mm[1],
                     row.cmd_mm[2]);
}

}  // namespace

double Cluster::mean_mm() const {
  const double sum_mm = std::accumulate(value_mm.begin(), value_mm.end(), 0.0);
  return sum_mm / static_cast<double>(value_mm.size());
}

double Cluster::sd_mm() const {
  if (value_mm.size() < 2) return 0;
  const double middle_mm = mean_mm();
  double sum_mm2 = 0;
  for (const double value : value_mm) {
    sum_mm2 += (value - middle_mm) * (value - middle_mm);
  }
  return std::sqrt(sum_mm2 / static_cast<double>(value_mm.size() - 1));
}

double Cluster::range_mm() const {
  const auto [least, most] = std::ranges::minmax(value_mm);
  return most - least;
}

std::vector<Cluster> ClustersOf(const RowTable& table) {
  std::map<std::string, std::size_t> index_of;
  std::vector<Cluster> clusters;
  double running = 0;
  for (const Row& row : table.rows) {
    running += 1;
    if (row.kind != RowKind::kTouch) continue;
    const auto [entry, is_new] = index_of.try_emplace(KeyOf(row), clusters.size());
    if (is_new) {
      clusters.push_back({.feature = row.feature,
                          .approach = ApproachText(row.n),
                          .settings = row.settings});
    }
    Cluster& cluster = clusters[entry->second];
    cluster.number.push_back(row.row > 0 ? static_cast<double>(row.row) : running);
    cluster.value_mm.push_back(row.value_mm);
  }
  return clusters;
}

}  // namespace caltwin
