#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "calibration/facts/motion.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

/// One length: along which direction, from where to where, and how much too long.
struct Length {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero(), to_mm = from_mm, n = from_mm;
  double change_mm = 0;
  double sd_mm = kUnknown;
  std::int64_t row = 0;
};

// Two rows of one setup are a length from the first to the second.
std::vector<Length> LengthsOf(const std::vector<const Row*>& rows,
                              const DataHeader& header) {
  std::map<std::string, std::vector<const Row*>> setups;
  for (const Row* row : rows) {
    if (row->kind == RowKind::kPosition && !row->setup.empty()) {
      setups[row->campaign + "|" + row->setup].push_back(row);
    }
  }
  std::vector<Length> lengths;
  for (const auto& [key, both] : setups) {
    if (both.size() != 2) continue;
    Length length{.sd_mm = std::hypot(StatedSigma_mm(*both[0], header),
                                      StatedSigma_mm(*both[1], header)),
                  .row = both[1]->row};
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const auto at = [&](const Row* row) {
        return Known(row->cmd_mm[i]) ? row->cmd_mm[i] : 0;
      };
      length.from_mm[k] = at(both[0]);
      length.to_mm[k] = at(both[1]);
      length.n[k] = Known(both[1]->n[i]) ? both[1]->n[i] : 0;
    }
    length.change_mm = both[1]->value_mm - both[0]->value_mm;
    lengths.push_back(length);
  }
  return lengths;
}

struct PlaneWords {
  int first = 0, second = 1;
  const char* name = nullptr;
};
constexpr std::array kPlanes = {
    PlaneWords{0, 1, "C0Y"}, PlaneWords{0, 2, "B0Z"}, PlaneWords{1, 2, "A0Z"}};

// Squares measured one after the other whose two diagonals differ now this way, now
// that: no one angle.
void TellUnsteady(const std::vector<Length>& lengths,
                  const PlaneWords& plane,
                  Facts* facts) {
  constexpr double kLeast = 1e-3, kFewest = 4;
  constexpr double kSure = 3, kCalliper_mm = 0.05;  // What a diagonal is read to.
  double shortest_mm = HUGE_VAL;
  std::vector<double> angles;
  const Length* rising = nullptr;
  for (const Length& length : lengths) {
    const double a = length.n[plane.first], b = length.n[plane.second];
    const double span_mm = (length.to_mm - length.from_mm).norm();
    if (a * b > 0) rising = &length;
    if (a * b >= 0 || rising == nullptr) continue;
    shortest_mm = std::min(shortest_mm, span_mm);
    angles.push_back((length.change_mm - rising->change_mm) / span_mm);
    rising = nullptr;
  }
  const Average average = AverageOf(angles);
  const double least = std::max(kLeast, kSure * kCalliper_mm / shortest_mm);
  if (average.num < kFewest || average.sd < least) return;
  facts->not_determined.push_back(
      fmt::format("skew.{}{}", "XYZ"[plane.first], "XYZ"[plane.second]));
  const double least_mrad = MradFromRad(*std::ranges::min_element(angles));
  const double most_mrad = MradFromRad(*std::ranges::max_element(angles));
  facts->cannot.push_back(fmt::format("one angle between {} and {}: there is none",
                                      "XYZ"[plane.first],
                                      "XYZ"[plane.second]));
  facts->all.push_back(
      {.id = "contradiction",
       .axis = plane.name,
       .word = "squares",
       .figures = {{"least_mrad", least_mrad}, {"most_mrad", most_mrad}},
       .cause = "unknown",
       .cause_axis = std::string(1, "xyz"[plane.first]),
       .sentence = fmt::format(
           "There is no one angle between {} and {}: from square to square it goes "
           "from "
           "{:.1f} to {:.1f} mrad. The two sides settle anew each time; home each on a "
           "switch of its own, and enter no skew before",
           "XYZ"[plane.first],
           "XYZ"[plane.second],
           least_mrad,
           most_mrad),
       .is_answer = true});
}

// Of these, the lengths that lie in the plane, where there are enough of them and two
// go across it; else none.
std::vector<Length> InPlane(const std::vector<Length>& all, const PlaneWords& plane) {
  constexpr double kInPlane = 0.999, kDiagonal = 0.2;
  constexpr std::size_t kFewest = 3;
  std::vector<Length> lengths;
  int num_diagonal = 0;
  for (const Length& length : all) {
    const double a = length.n[plane.first], b = length.n[plane.second];
    if (std::hypot(a, b) < kInPlane) continue;
    num_diagonal += std::abs(a * b) > kDiagonal ? 1 : 0;
    lengths.push_back(length);
  }
  if (lengths.size() < kFewest || num_diagonal < 2) lengths.clear();
  return lengths;
}

struct Angle {
  double rad = 0;
  double sd_rad = kUnknown;
};

// Two scales and the angle from changes of length in one plane: n . E d,
// E = [[s1, -c], [0, s2]] (C0Y: dx = -c y; B0Z turns dx the other way).
std::optional<Angle> FitAngle(const std::vector<Length>& lengths,
                              const PlaneWords& plane) {
  const auto num = static_cast<Eigen::Index>(lengths.size());
  Eigen::MatrixXd columns(num, 3);
  Eigen::VectorXd changes(num), sds(num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const Length& length = lengths[static_cast<std::size_t>(i)];
    const Eigen::Vector3d d_mm = length.to_mm - length.from_mm;
    columns(i, 0) = length.n[plane.first] * d_mm[plane.first];
    columns(i, 1) = length.n[plane.second] * d_mm[plane.second];
    columns(i, 2) = (plane.first == 0 && plane.second == 2 ? 1 : -1) *
                    length.n[plane.first] * d_mm[plane.second];
    changes[i] = length.change_mm;
    sds[i] = length.sd_mm;
  }
  // Diagonals alone do not part the two scales.
  constexpr double kSingular = 1e-6;
  Eigen::MatrixXd normal = columns.transpose() * columns;
  if (EigenvaluesOf(normal)[0] < kSingular * normal.trace()) {
    columns.col(0) += columns.col(1);
    columns.col(1).setZero();
    normal = columns.transpose() * columns;
    normal(1, 1) = normal.trace();
  }
  if (EigenvaluesOf(normal)[0] < kSingular * normal.trace()) return std::nullopt;
  const Eigen::MatrixXd half = Cholesky(normal).SolveEach(columns.transpose());
  const Eigen::VectorXd sizes = half * changes;
  Angle angle{.rad = sizes[2],
              .sd_rad = (half.row(2).transpose().cwiseProduct(sds)).norm()};
  // Lengths measured more than once say by themselves how far they scatter.
  const double dof = static_cast<double>(num) - 3;
  if (!Known(angle.sd_rad) && dof >= 3) {
    const double left_mm2 = (changes - columns * sizes).squaredNorm();
    angle.sd_rad = std::sqrt(left_mm2 / dof) * half.row(2).norm();
  }
  return angle;
}

Fact SkewFact(const std::vector<Length>& lengths,
              const PlaneWords& plane,
              const Angle& angle) {
  const FactFigure figure{
      "angle_mrad", MradFromRad(angle.rad), MradFromRad(angle.sd_rad)};
  // As ISO 230-1 counts a turn about the third axis.
  const bool leans = (angle.rad > 0) == (plane.first == 0 && plane.second == 2);
  Fact fact{.id = "skew",
            .axis = plane.name,
            .word = fmt::format("{}{}", leans ? '+' : '-', "xyz"[plane.first]),
            .figures = {figure},
            .cause = "squareness",
            .cause_axis = plane.name,
            .parameters = {figure},
            .is_answer = true};
  if (Known(angle.sd_rad)) {
    fact.sigmas = std::abs(angle.rad) / std::max(angle.sd_rad, 1e-12);
  }
  for (const Length& length : lengths) fact.rows.push_back(length.row);
  fact.sentence = fmt::format(
      "The lengths fit together only if {} and {} are out of square by {} ({}), {} "
      "leaning towards {}{}: the two diagonals differ{}",
      "XYZ"[plane.first],
      "XYZ"[plane.second],
      WithSd(MradFromRad(std::abs(angle.rad)), MradFromRad(angle.sd_rad), "mrad"),
      WithSd(DegFromRad(std::abs(angle.rad)), DegFromRad(angle.sd_rad), "degrees"),
      "XYZ"[plane.second],
      leans ? '+' : '-',
      "XYZ"[plane.first],
      Known(angle.sd_rad)
          ? fmt::format(" by {:.0f} times their uncertainty", fact.sigmas)
          : ". Its uncertainty is not known: no length was measured twice");
  return fact;
}

}  // namespace

void FactsOfLengths(const std::vector<const Row*>& rows,
                    const DataHeader& header,
                    Facts* facts) {
  constexpr double kSure = 4;
  const std::vector<Length> all = LengthsOf(rows, header);
  for (const PlaneWords& plane : kPlanes) {
    const std::vector<Length> lengths = InPlane(all, plane);
    if (lengths.empty()) continue;
    const std::optional<Angle> angle = FitAngle(lengths, plane);
    if (!angle) continue;
    if (Known(angle->sd_rad) && std::abs(angle->rad) < kSure * angle->sd_rad) {
      TellUnsteady(lengths, plane, facts);
    } else {
      facts->all.push_back(SkewFact(lengths, plane, *angle));
    }
  }
}

}  // namespace caltwin
