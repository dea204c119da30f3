#include "sim/effects/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/effects/kinds/screws_at.h"
#include "sim/effects/kinds/station_at.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr double kFirst = -std::numeric_limits<double>::infinity();

// Along n: what a row knows of it.
Vec3<double> DirectionOf(const Row& row) {
  Vec3<double> n = Vec3<double>::Zero();
  bool known = false;
  for (int i = 0; i < 3; ++i) {
    const double component = row.n[static_cast<std::size_t>(i)];
    if (!Known(component)) continue;
    n[i] = component;
    known = true;
  }
  constexpr double kUnitTolerance = 1e-3;
  if (!known || std::abs(n.norm() - 1) > kUnitTolerance) {
    throw InputError(
        row.place,
        fmt::format("row {} does not say along which unit vector its value "
                    "is measured: fill in nx, ny and nz",
                    row.row));
  }
  return n.normalized();
}

Vec3<double> KnownPose(const Row& row) {
  Vec3<double> pose_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    pose_mm[static_cast<int>(i)] = Known(row.cmd_mm[i]) ? row.cmd_mm[i] : 0;
  }
  return pose_mm;
}

// Sums to means, in place.
template <typename Key>
class Means {
 public:
  void Add(const Key& key, const Vec3<double>& value) {
    auto& [sum, count] = sums_.try_emplace(key, Vec3<double>::Zero(), 0).first->second;
    sum += value;
    ++count;
  }
  template <typename Map>
  void To(Map* means) const {
    for (const auto& [key, sum] : sums_) {
      means->emplace(key, Vec3<double>(sum.first / sum.second));
    }
  }

 private:
  std::map<Key, std::pair<Vec3<double>, int>> sums_{};
};

}  // namespace

std::string_view ArtefactOf(const Row& row) {
  return std::string_view(row.feature).substr(0, row.feature.find('.'));
}

bool IsRelease(const Row& row) {
  if (row.kind != RowKind::kTouch) return false;
  double sense = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (Known(row.dir[i]) && Known(row.n[i])) sense += row.dir[i] * row.n[i];
  }
  return sense > 0;
}

Surroundings::Surroundings(const std::vector<Row>& rows)
    : has_times_(!rows.empty() && std::ranges::all_of(rows, [](const Row& row) {
        return Known(row.t_s);
      })) {
  std::vector<const Row*> by_time;
  Means<Placed> artefacts;
  Means<std::string> circles;
  for (const Row& row : rows) {
    by_time.push_back(&row);
    artefacts.Add({row.setup, std::string(ArtefactOf(row))}, KnownPose(row));
    if (row.kind == RowKind::kRadial) circles.Add(row.campaign, KnownPose(row));
  }
  artefacts.To(&artefact_mid_mm_);
  circles.To(&circle_mid_mm_);
  std::ranges::stable_sort(by_time, {}, [&](const Row* row) { return TimeOf_s(*row); });
  for (const Row* row : by_time) {
    for (std::size_t i = 0; i < kNumSensors; ++i) {
      const double temp_c = TemperatureOf(*row, static_cast<Sensor>(i));
      if (Known(temp_c)) climate_.logs[i].Add(TimeOf_s(*row), temp_c);
    }
    homed_at_s_.try_emplace(row->home, homed_at_s_.empty() ? kFirst : TimeOf_s(*row));
  }
}

double Surroundings::TimeOf_s(const Row& row) const {
  return has_times_ ? row.t_s : static_cast<double>(row.row);
}

void Surroundings::Complete(const Row& row, At* at) const {
  at->t_s = TimeOf_s(row);
  const auto homed = homed_at_s_.find(row.home);
  if (homed != homed_at_s_.end()) at->homed_at_s = homed->second;
  at->climate = &climate_;
  const auto mid = artefact_mid_mm_.find({row.setup, std::string(ArtefactOf(row))});
  if (mid != artefact_mid_mm_.end()) at->artefact_mid_mm = mid->second;
  if (row.kind != RowKind::kRadial) return;
  const auto circle = circle_mid_mm_.find(row.campaign);
  if (circle != circle_mid_mm_.end()) {
    at->radius_mm = (KnownPose(row) - circle->second).norm();
  }
}

namespace {

// In which sense the drives came: as the row says, else as its axes did.
DrivesAt DrivesAtOf(const Row& row,
                    const DriveMap* map,
                    const Machine& machine,
                    const At& at) {
  DrivesAt here{.map = map,
                .home_mm = DrivesOf(map, machine.kind->AtHome(machine).q_mm)};
  const Vec3<double> by_axes = DrivesOf(map, at.dir);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double usual = by_axes[i] == 0 ? 0 : std::copysign(1, by_axes[i]);
    const bool is_told = map->is_coupled(i) && Known(row.motor_dir[k]);
    here.dir[i] = is_told ? row.motor_dir[k] : usual;
  }
  return here;
}

}  // namespace

At AtOf(const Row& row, const Machine& machine, const Settings& in_force) {
  At at{.kind = row.kind,
        .n = DirectionOf(row),
        .tip_radius_cfg_mm = in_force.tip_radius_mm,
        .feed_mm_s = Known(row.feed_mm_s) ? row.feed_mm_s : 0,
        .load_n = row.load_n,
        .on_table = row.kind == RowKind::kTouch,
        .setup = row.setup,
        .home = row.home,
        .artefact = ArtefactOf(row)};
  if (Known(row.probe_angle_deg)) at.probe_angle_deg = row.probe_angle_deg;
  if (Known(row.artefact_turn_deg)) at.artefact_turn_deg = row.artefact_turn_deg;
  const Vec3<double> middle_mm = machine.kind->Middle_mm(machine);
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    const auto k = static_cast<std::size_t>(i);
    at.q_mm[i] = Known(row.cmd_mm[k]) ? row.cmd_mm[k] : middle_mm[i];
    at.dir[i] = Known(row.dir[k]) ? row.dir[k] : 0;
    at.since_rev_mm[i] = row.since_rev_mm[k];
    if (Known(row.probe_off_mm[k])) at.probe_off_mm[i] = row.probe_off_mm[k];
    at.steps_per_mm[i] = in_force.steps_per_mm[k];
    at.compensation_mm[i] = in_force.backlash_mm[k];
  }
  if (row.kind == RowKind::kTouch) {
    at.q_mm += (row.value_mm + at.tip_radius_cfg_mm) * at.n - at.probe_off_mm;
  }
  if (IsRelease(row)) at.feed_mm_s = -at.feed_mm_s;
  if (const DriveMap* map = machine.kind->drive_map()) {
    at.drives = DrivesAtOf(row, map, machine, at);
    // Of an axis, which is no drive's.
    for (int i = 0; i < 3; ++i) {
      if (map->is_coupled(i)) at.since_rev_mm[i] = kUnknown;
    }
  }
  AddScrews(row, machine, &at);
  AddStation(row, machine, &at);
  return at;
}

}  // namespace caltwin
