#include "calibration/estimate/observation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

Vec3<double> PoseOf(const Row& row, const Machine& machine) {
  Vec3<double> pose_mm;
  for (const Axis axis : kAxes) {
    const double cmd_mm = row.cmd_mm[static_cast<std::size_t>(Index(axis))];
    pose_mm[Index(axis)] = Known(cmd_mm) ? cmd_mm : machine.axis(axis).mid_mm();
  }
  return pose_mm;
}

std::string ArtefactKey(const Row& row) {
  if (row.kind != RowKind::kTouch) {
    return row.setup.empty() ? row.campaign : row.campaign + "/" + row.setup;
  }
  if (!row.setup.empty()) return row.setup;
  if (!row.feature.empty()) return row.feature.substr(0, row.feature.find('.'));
  return row.campaign;
}

// Settings that change without homing shift the machine against what lies on it, so
// each has its own placement, where there are several.
std::string PlacementKey(const Row& row, bool several_settings) {
  return several_settings ? ArtefactKey(row) + "@" + row.settings : ArtefactKey(row);
}

bool HasSeveralSettings(const RowTable& table) {
  return std::ranges::any_of(table.rows, [&](const Row& row) {
    return row.settings != table.rows.front().settings;
  });
}

// Mean commanded position of the rows of each placement.
std::map<std::string, Vec3<double>> Centres(const RowTable& table,
                                            const Machine& machine,
                                            bool several_settings) {
  std::map<std::string, Vec3<double>> sums;
  std::map<std::string, int> counts;
  for (const Row& row : table.rows) {
    const std::string key = PlacementKey(row, several_settings);
    const auto at = sums.try_emplace(key, Vec3<double>::Zero()).first;
    at->second += PoseOf(row, machine);
    ++counts[key];
  }
  for (auto& [key, sum] : sums) sum /= counts[key];
  return sums;
}

}  // namespace

At RowToAt(const Row& row, const Machine& machine, const SettingsById& settings) {
  const auto found = settings.find(row.settings);
  return AtOf(row, machine, found == settings.end() ? machine.settings : found->second);
}

std::vector<Observation> ObservationsOf(const RowTable& table,
                                        const Machine& machine,
                                        const RowUse& use) {
  const bool several_settings = HasSeveralSettings(table);
  std::map<std::string, Vec3<double>> centres;
  if (use.placement_turns) centres = Centres(table, machine, several_settings);

  std::vector<Observation> observations;
  for (const Row& row : table.rows) {
    Observation observation{
        .at = RowToAt(row, machine, use.settings),
        .value_mm = row.value_mm,
        .sigma_mm = Known(row.sigma_mm) ? row.sigma_mm : use.default_sigma_mm,
        .group = row.feature.empty() ? row.campaign : row.feature};
    Require(observation.sigma_mm > 0, "an observation has a standard deviation");
    const Vec3<double>& n = observation.at.n;
    const std::string key = PlacementKey(row, several_settings);
    const std::string placement = "placement." + key + ".";
    for (const Axis axis : kAxes) {
      if (n[Index(axis)] == 0) continue;
      observation.nuisances[placement + Name(axis)] = n[Index(axis)];
    }
    if (use.placement_turns && row.kind == RowKind::kTouch) {
      const Vec3<double> arm_mm = PoseOf(row, machine) - centres.at(key);
      observation.nuisances[placement + "turn"] =
          n.y() * arm_mm.x() - n.x() * arm_mm.y();
    }
    if (IsRelease(row)) {
      observation.nuisances["probe_hysteresis"] = 1.0;
    }
    observations.push_back(std::move(observation));
  }
  return observations;
}

}  // namespace caltwin
