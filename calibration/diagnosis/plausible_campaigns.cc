#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "calibration/diagnosis/readings_on_a_line.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kInch_mm = MmFromInch(1.0);
constexpr double kThousand = UmFromMm(1.0);
constexpr double kThousandths = kThousand / kInch_mm;  // Of an inch, in a mm.
constexpr std::size_t kFewestCommon = 8;
constexpr double kAlike = 0.9;

/// Where a campaign read [um], and coming in which sense.
using PlaceAndSense = std::tuple<long, long, long, int>;
/// Mean reading at each place of a campaign, as motion (touches reversed).
using ReadingsByPlace = std::map<PlaceAndSense, double>;

bool IsGauged(const Row& row) {
  return row.kind != RowKind::kTouch;
}

ReadingsByPlace ProfileOf(const std::vector<const Row*>& rows) {
  std::map<PlaceAndSense, std::pair<double, int>> sums;
  for (const Row* row : rows) {
    const auto microns = [](double number_mm) {
      return Known(number_mm) ? std::lround(UmFromMm(number_mm)) : 0;
    };
    auto& [sum, count] = sums[{microns(row->cmd_mm[0]),
                               microns(row->cmd_mm[1]),
                               microns(row->cmd_mm[2]),
                               static_cast<int>(SenseAlongNormal(*row))}];
    sum += row->value_mm * (IsGauged(*row) ? 1 : -1);
    count += 1;
  }
  ReadingsByPlace profile;
  for (const auto& [pose, sum] : sums) profile[pose] = sum.first / sum.second;
  return profile;
}

long Coordinate_um(const PlaceAndSense& place, int axis) {
  return axis == 0 ? std::get<0>(place)
                   : (axis == 1 ? std::get<1>(place) : std::get<2>(place));
}

// Whether two places lie on one line along `axis`, come to in one sense.
bool AreInLine(const PlaceAndSense& one, const PlaceAndSense& other, int axis) {
  constexpr long kBeside_um = 1000;
  for (int across = 0; across < 3; ++across) {
    const long apart_um = Coordinate_um(one, across) - Coordinate_um(other, across);
    if (across != axis && std::abs(apart_um) > kBeside_um) return false;
  }
  return std::get<3>(one) == std::get<3>(other);
}

// The axis that alone moved in a campaign; none where none or several did.
std::optional<int> OnlyMoved(const ReadingsByPlace& profile) {
  std::optional<int> moved;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_still = std::ranges::all_of(profile, [&](const auto& one) {
      return Coordinate_um(one.first, axis) ==
             Coordinate_um(profile.begin()->first, axis);
    });
    if (is_still) continue;
    if (moved) return std::nullopt;
    moved = axis;
  }
  return moved;
}

struct PairOfReadings {
  PlaceAndSense place{};
  double one = 0, other = 0;
};

std::vector<PairOfReadings> AtCommonPlaces(const ReadingsByPlace& one,
                                           const ReadingsByPlace& other) {
  std::vector<PairOfReadings> pairs;
  for (const auto& [place, value] : one) {
    const auto found = other.find(place);
    if (found != other.end()) pairs.push_back({place, value, found->second});
  }
  return pairs;
}

// Of campaigns along one line at places of their own: the other between its neighbours,
// once for each pair of them, or one long straight would count as many places.
std::vector<PairOfReadings> AlongCommonLine(const ReadingsByPlace& one,
                                            const ReadingsByPlace& other) {
  std::vector<PairOfReadings> pairs;
  const std::optional<int> axis = OnlyMoved(one);
  if (!axis || OnlyMoved(other) != axis) return pairs;
  std::set<std::pair<int, double>> used;  // Sense, and the next place.
  for (const auto& [place, value] : one) {
    std::vector<PlacedReading> line;  // Sorted: the other coordinates are all alike.
    for (const auto& [there, reading] : other) {
      if (!AreInLine(place, there, *axis)) continue;
      line.push_back({static_cast<double>(Coordinate_um(there, *axis)), reading});
    }
    const auto at = static_cast<double>(Coordinate_um(place, *axis));
    const auto between = ReadingBetween(line, at);
    if (!between) continue;
    const double next =
        std::ranges::lower_bound(line, at, {}, &PlacedReading::at_mm)->at_mm;
    if (used.emplace(std::get<3>(place), next).second) {
      pairs.push_back({place, value, *between});
    }
  }
  return pairs;
}

// Takes out of `values` what the columns of `shapes` can make, which are made
// perpendicular to each other on the way (Gram and Schmidt).
void TakeOut(Eigen::MatrixXd* shapes, Eigen::VectorXd* values) {
  constexpr double kNothingLeft = 1e-9;
  for (Eigen::Index k = 0; k < shapes->cols(); ++k) {
    Eigen::VectorXd shape = shapes->col(k);
    const double before = shape.norm();
    for (Eigen::Index j = 0; j < k; ++j) {
      shape -= shapes->col(j).dot(shape) * shapes->col(j);
    }
    const double left = shape.norm();
    shape = left > kNothingLeft * before ? Eigen::VectorXd(shape / left)
                                         : Eigen::VectorXd::Zero(shape.size());
    shapes->col(k) = shape;
    *values -= shape.dot(*values) * shape;
  }
}

/// How one campaign's readings follow another's where both measured.
struct Likeness {
  std::size_t num_common = 0;
  double correlation = 0;
  double ratio = 0;  ///< Of the second's sizes to the first's.
};

// Offsets are each campaign's own. So is how whatever was set up leans across the axes
// in `leans`: that is taken out too.
Likeness Compare(const ReadingsByPlace& one,
                 const ReadingsByPlace& other,
                 const std::array<bool, 3>& leans) {
  std::vector<PairOfReadings> pairs = AtCommonPlaces(one, other);
  if (pairs.size() < kFewestCommon) pairs = AlongCommonLine(one, other);
  Likeness likeness{.num_common = pairs.size()};
  if (pairs.empty()) return likeness;
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd stood(count, 4);
  Eigen::VectorXd a(count), b(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PairOfReadings& pair = pairs[static_cast<std::size_t>(i)];
    stood(i, 0) = 1;
    for (int axis = 0; axis < 3; ++axis) {
      stood(i, axis + 1) =
          leans[axis] ? static_cast<double>(Coordinate_um(pair.place, axis)) : 0;
    }
    a[i] = pair.one;
    b[i] = pair.other;
  }
  TakeOut(&stood, &a);
  TakeOut(&stood, &b);
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  if (aa <= 0 || bb <= 0) return likeness;
  likeness.correlation = ab / std::sqrt(aa * bb);
  likeness.ratio = std::sqrt(bb / aa);
  return likeness;
}

/// Two campaigns by name.
struct Pair {
  std::string one{}, other{};
};

// True where it found them in different units.
bool DoubtUnits(const Pair& pair,
                const Likeness& likeness,
                std::vector<Doubt>* doubts) {
  if (likeness.num_common < kFewestCommon) return false;
  const double larger = std::max(likeness.ratio, 1 / likeness.ratio);
  const auto is_about = [&](double what) {
    return std::abs(larger / what - 1) < 0.15;
  };
  const bool is_unit =
      is_about(kInch_mm) || is_about(kThousandths) || is_about(kThousand);
  if (std::abs(likeness.correlation) < kAlike || !is_unit) return false;
  doubts->push_back(
      {.kind = "units_differ",
       .message = fmt::format("campaigns {} and {} read alike at the same places, but "
                              "{:.4g} times as much",
                              pair.one,
                              pair.other,
                              larger),
       .hint = is_about(kInch_mm) ? "that is an inch: one of them is in inches"
               : is_about(kThousandths)
                   ? "that is a thousandth of an inch: one of them is in thousandths"
                   : "that is 1000: one of them is in micrometres",
       .refuse = true});
  return true;
}

void DoubtSign(const Pair& pair, const Likeness& likeness, std::vector<Doubt>* doubts) {
  const double larger = std::max(likeness.ratio, 1 / likeness.ratio);
  if (likeness.num_common < kFewestCommon || likeness.correlation > -kAlike ||
      larger > 2) {
    return;
  }
  doubts->push_back(
      {.kind = "reversed_sign",
       .message = fmt::format("campaigns {} and {} read the opposite of each other at "
                              "the same {} places (correlation {:.2f})",
                              pair.one,
                              pair.other,
                              likeness.num_common,
                              likeness.correlation),
       .hint = "one of them is commanded minus actual: value_mm is actual minus "
               "commanded, of a touch reported minus nominal",
       .refuse = true});
}

// What turns the sign of an error that stays: an artefact turned about (a bed_twist, a
// square), a probe held at the other side (Abbe) or turned in the spindle, a screw on
// the other side of its reference temperature. Campaigns that differ in one of these
// may well read the opposite.
std::array<long, 9> HeldAs(const Row& row) {
  constexpr double kPerStep_k = 0.2;  // Steps of 5 K.
  const auto steps = [](double number, double per_step) {
    return Known(number) ? std::lround(number * per_step) : 0;
  };
  return {steps(row.artefact_turn_deg, 1),
          steps(row.probe_angle_deg, 1),
          steps(row.probe_off_mm[0], 1),
          steps(row.probe_off_mm[1], 1),
          steps(row.probe_off_mm[2], 1),
          steps(row.temp_screw_c, kPerStep_k),
          steps(row.temp_frame_c, kPerStep_k),
          steps(row.temp_bed_c, kPerStep_k),
          steps(row.temp_ambient_c, kPerStep_k)};
}

/// How each run of a campaign follows each other one.
class RunsAlike {
 public:
  RunsAlike(const std::vector<ReadingsByPlace>& runs, const std::array<bool, 3>& leans)
      : num_(runs.size()), all_(num_ * num_) {
    for (std::size_t i = 0; i < num_; ++i) {
      for (std::size_t k = 0; k < num_; ++k) {
        all_[i * num_ + k] = Compare(runs[i], runs[k], leans);
      }
    }
  }
  const Likeness& operator()(std::size_t i, std::size_t k) const {
    return all_[i * num_ + k];
  }
  // The run that most others follow; none where fewer than two others do.
  std::optional<std::size_t> Usual() const {
    std::optional<std::size_t> usual;
    std::size_t most = 2;  // Itself and one more are no majority of three.
    for (std::size_t i = 0; i < num_; ++i) {
      std::size_t followers = 0;
      for (std::size_t k = 0; k < num_; ++k) {
        const Likeness& like = (*this)(i, k);
        followers += like.num_common >= kFewestCommon && like.correlation > kAlike &&
                             std::abs(std::log(like.ratio)) < std::log(2.0)
                         ? 1
                         : 0;
      }
      if (followers < most || 2 * followers <= num_) continue;
      most = followers + 1;
      usual = i;
    }
    return usual;
  }

 private:
  std::size_t num_;
  std::vector<Likeness> all_;
};

// Of the runs of a campaign most are alike, and some the opposite or in another unit.
void DoubtRunsOf(const std::string& campaign,
                 const std::map<std::int64_t, std::vector<const Row*>>& by_run,
                 const std::array<bool, 3>& leans,
                 std::vector<Doubt>* doubts) {
  std::vector<std::string> names;
  std::vector<ReadingsByPlace> runs;
  for (const auto& [run, rows] : by_run) {
    names.push_back(fmt::format("{} (run {})", campaign, run));
    runs.push_back(ProfileOf(rows));
  }
  const RunsAlike alike(runs, leans);
  const auto usual = alike.Usual();
  if (!usual) return;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::size_t before = doubts->size();
    const Pair pair{names[*usual], names[k]};
    if (!DoubtUnits(pair, alike(*usual, k), doubts)) {
      DoubtSign(pair, alike(*usual, k), doubts);
    }
    if (doubts->size() > before) return;
  }
}

}  // namespace

void DoubtRuns(const RowTable& table, std::vector<Doubt>* doubts) {
  // Each run is held against each other one; thousands are repeats of single readings.
  constexpr std::size_t kFewestRuns = 3, kMostRuns = 300;
  using Key = std::tuple<std::string, std::string, std::array<long, 3>>;
  std::map<Key, std::map<std::int64_t, std::vector<const Row*>>> campaigns;
  for (const Row& row : table.rows) {
    if (!row.rep) continue;
    std::array<long, 3> n{};
    for (int axis = 0; axis < 3; ++axis) {
      n[axis] = Known(row.n[axis]) ? std::lround(1000 * row.n[axis]) : 0;
    }
    campaigns[{row.campaign, row.settings, n}][*row.rep].push_back(&row);
  }
  for (const auto& [key, by_run] : campaigns) {
    const std::array<long, 3>& n = std::get<2>(key);
    if (by_run.size() < kFewestRuns || by_run.size() > kMostRuns) continue;
    DoubtRunsOf(std::get<0>(key), by_run, {n[0] == 0, n[1] == 0, n[2] == 0}, doubts);
  }
}

// Campaigns under the same settings that measured along the same normal, held alike.
void DoubtCampaigns(const RowTable& table, std::vector<Doubt>* doubts) {
  using Key = std::tuple<std::array<long, 3>, std::string, std::array<long, 9>>;
  std::map<Key, std::map<std::string, std::vector<const Row*>>> groups;
  for (const Row& row : table.rows) {
    std::array<long, 3> n{};
    for (int axis = 0; axis < 3; ++axis) {
      n[axis] = Known(row.n[axis]) ? std::lround(1000 * row.n[axis]) : 0;
    }
    groups[{n, row.settings, HeldAs(row)}][row.campaign].push_back(&row);
  }
  for (const auto& [key, campaigns] : groups) {
    for (auto one = campaigns.begin(); one != campaigns.end(); ++one) {
      for (auto other = std::next(one); other != campaigns.end(); ++other) {
        const Pair pair{one->first, other->first};
        const ReadingsByPlace first = ProfileOf(one->second),
                              second = ProfileOf(other->second);
        if (DoubtUnits(pair, Compare(first, second, {}), doubts)) continue;
        const std::array<long, 3>& n = std::get<0>(key);
        DoubtSign(
            pair, Compare(first, second, {n[0] == 0, n[1] == 0, n[2] == 0}), doubts);
      }
    }
  }
}

}  // namespace caltwin
