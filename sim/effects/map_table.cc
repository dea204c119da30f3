#include "sim/effects/map_table.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/require.h"
#include "sim/effects/drive.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 18> kCovariates = {"x",
                                                          "y",
                                                          "z",
                                                          "t",
                                                          "temp",
                                                          "dir_x",
                                                          "dir_y",
                                                          "dir_z",
                                                          "since_rev",
                                                          "feed",
                                                          "load",
                                                          "theta",
                                                          "motor_a",
                                                          "motor_b",
                                                          "motor_c",
                                                          "dir_a",
                                                          "dir_b",
                                                          "dir_c"};

int AlongWhich(const Vec3<double>& n) {
  int most = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(n[k]) > std::abs(n[most])) most = k;
  }
  return most;
}

double LiveliestTemp_k(const At& at) {
  if (at.climate == nullptr) return kUnknown;
  double most_k = kLeastSwing_k, temp_k = kUnknown;
  for (const TemperatureLog& log : at.climate->logs) {
    if (log.swing_k() <= most_k) continue;
    most_k = log.swing_k();
    temp_k = log.At_k(at.t_s);
  }
  return temp_k;
}

}  // namespace

std::vector<double> FlatMap(const std::vector<double>& values,
                            const std::vector<std::vector<double>>& knots) {
  Require(!knots.empty() && knots.size() <= 2, "a map has one or two covariates");
  const std::size_t cells = knots[0].size() * (knots.size() == 2 ? knots[1].size() : 1);
  Require(values.size() == cells, "a map has one value for each knot");
  std::vector<double> flat = values;
  for (const auto& list : knots) flat.insert(flat.end(), list.begin(), list.end());
  flat.push_back(static_cast<double>(knots[0].size()));
  return flat;
}

MapTable TableOf(std::span<const double> flat, std::size_t num_covariates) {
  if (flat.size() < 2 || num_covariates == 0) {
    return {.values = {flat.begin(), flat.end()}};
  }
  const auto rows = static_cast<std::size_t>(flat.back());
  const std::size_t columns =
      num_covariates == 1 ? 1 : (flat.size() - 1 - rows) / (rows + 1);
  const auto part = [&](std::size_t from, std::size_t count) {
    const auto span = flat.subspan(from, count);
    return std::vector<double>(span.begin(), span.end());
  };
  MapTable table{.values = part(0, rows * columns)};
  table.knots.push_back(part(rows * columns, rows));
  if (num_covariates == 2) table.knots.push_back(part(rows * columns + rows, columns));
  return table;
}

std::string MapAxis(std::string_view channel, std::span<const std::string> covariates) {
  return fmt::format("{}{{{}}}", channel, fmt::join(covariates, ","));
}

MapWords WordsOf(std::string_view axis) {
  const std::size_t brace = axis.find('{');
  MapWords words{.channel = axis.substr(0, brace)};
  if (brace == std::string_view::npos) return words;
  std::string_view rest = axis.substr(brace + 1, axis.size() - brace - 2);
  while (!rest.empty() && words.num_covariates < 2) {
    const std::size_t comma = rest.find(',');
    words.covariates[words.num_covariates++] = rest.substr(0, comma);
    rest = comma == std::string_view::npos ? "" : rest.substr(comma + 1);
  }
  return words;
}

double CovariateAt(const At& at, std::string_view word) {
  if (const auto axis = AxisNamed(word)) return at.q_mm[Index(*axis)];
  if (word.starts_with("dir_")) {
    const auto drive = DriveNamed(word.substr(4));
    if (!drive) return kUnknown;
    if (!drive->is_motor) return at.dir[drive->index];
    if (drive->is_screw) {
      return at.screws ? at.screws->motor_dir[drive->index] : kUnknown;
    }
    const auto motor_dir = MotorDirOf(at);
    return motor_dir ? (*motor_dir)[drive->index] : kUnknown;
  }
  if (word.starts_with("motor_")) {
    const auto drive = DriveNamed(word.substr(6));
    const auto motors_mm = drive && drive->is_screw ? ScrewsOf_mm(at) : MotorsOf_mm(at);
    const bool is_there = drive && drive->is_motor && motors_mm;
    return is_there ? (*motors_mm)[drive->index] : kUnknown;
  }
  if (word == "t") return at.t_s;
  if (word == "temp") return LiveliestTemp_k(at);
  if (word == "feed") return at.feed_mm_s;
  if (word == "load") return at.load_n;
  if (word == "since_rev") return at.since_rev_mm[AlongWhich(at.n)];
  if (word == "theta") {
    constexpr double kLeastSideways = 0.5;
    if (std::hypot(at.n.x(), at.n.y()) < kLeastSideways) return kUnknown;
    return std::atan2(at.n.y(), at.n.x());
  }
  return kUnknown;
}

bool IsCovariate(std::string_view word) {
  return std::ranges::find(kCovariates, word) != kCovariates.end();
}

}  // namespace caltwin
