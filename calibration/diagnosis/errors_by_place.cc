#include "calibration/diagnosis/errors_by_place.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostPlaces = 800;

using Json = nlohmann::ordered_json;

// Of the axis that n lies along most.
int SenseOf(const Observed& observed, Eigen::Index i) {
  Eigen::Index along = 0;
  observed.at(i).n.cwiseAbs().maxCoeff(&along);
  const double dir = observed.row(i).dir[static_cast<std::size_t>(along)];
  if (!Known(dir) || dir == 0) return 0;
  return dir > 0 ? 1 : -1;
}

std::string KeyOf(const ErrorAtPlace& one) {
  return fmt::format("{} {:.3f} {:.3f} {}",
                     static_cast<int>(one.kind),
                     fmt::join(one.cmd_mm, " "),
                     fmt::join(one.n, " "),
                     one.sense);
}

// Less the mean of those rows of its campaign that are along the same direction.
void TakeMeansOff(const Observed& observed,
                  const std::set<std::int64_t>& out,
                  Eigen::VectorXd* fitted_mm) {
  std::map<std::string, std::vector<Eigen::Index>> groups;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    if (out.contains(observed.row(i).row)) continue;
    const Row& row = observed.row(i);
    const Vec3<double>& n = observed.at(i).n;
    groups[fmt::format("{}|{}|{}|{:.2f} {:.2f} {:.2f}",
                       row.campaign,
                       row.setup,
                       row.feature,
                       n.x(),
                       n.y(),
                       n.z())]
        .push_back(i);
  }
  for (const auto& [name, members] : groups) {
    const Eigen::VectorXd values_mm = (*fitted_mm)(members);
    (*fitted_mm)(members).array() -= values_mm.mean();
  }
}

Json NumbersOrNull(const std::array<double, 3>& values) {
  Json json = Json::array();
  for (const double value : values) {
    json.push_back(std::isfinite(value) ? Json(value) : Json());
  }
  return json;
}

}  // namespace

std::vector<ErrorAtPlace> ErrorsByPlace(const Observed& as_read,
                                        const Diagnosis& diagnosis) {
  if (diagnosis.residual_after_mm.size() != as_read.num_rows()) return {};
  const std::set<std::int64_t> out(diagnosis.outlier_rows.begin(),
                                   diagnosis.outlier_rows.end());
  Eigen::VectorXd fitted_mm =
      diagnosis.residual_before_mm - diagnosis.residual_after_mm;
  if (diagnosis.findings.empty()) {
    fitted_mm = as_read.residual_mm() - diagnosis.residual_after_mm;
    TakeMeansOff(as_read, out, &fitted_mm);
  }
  std::vector<ErrorAtPlace> errors;
  std::map<std::string, std::size_t> known;
  for (Eigen::Index i = 0; i < as_read.num_rows(); ++i) {
    const Row& row = as_read.row(i);
    const Vec3<double>& n = as_read.at(i).n;
    if (out.contains(row.row)) continue;
    const ErrorAtPlace here{.kind = row.kind,
                            .cmd_mm = row.cmd_mm,
                            .n = {n.x(), n.y(), n.z()},
                            .sense = SenseOf(as_read, i)};
    const auto [found, is_new] = known.try_emplace(KeyOf(here), errors.size());
    if (is_new) errors.push_back(here);
    ErrorAtPlace& place = errors[found->second];
    place.fitted_um += UmFromMm(fitted_mm[i]);
    ++place.rows;
  }
  for (ErrorAtPlace& place : errors) place.fitted_um /= place.rows;
  if (errors.size() > kMostPlaces) errors.clear();
  return errors;
}

Json ToJson(const std::vector<ErrorAtPlace>& errors) {
  Json all = Json::array();
  for (const ErrorAtPlace& one : errors) {
    all.push_back({{"is_touch", one.kind == RowKind::kTouch},
                   {"cmd_mm", NumbersOrNull(one.cmd_mm)},
                   {"n", NumbersOrNull(one.n)},
                   {"sense", one.sense},
                   {"rows", one.rows},
                   {"fitted_um", one.fitted_um}});
  }
  return all;
}

}  // namespace caltwin
