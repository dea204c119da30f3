#include "calibration/diagnosis/observed.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/rounding.h"
#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/effects/gap_sense.h"
#include "sim/effects/injected.h"
#include "sim/effects/predict.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/in_force.h"

namespace caltwin {
namespace {

bool IsInside(const DataHeader& header, std::string_view artefact) {
  const auto found = header.artefacts.find(std::string(artefact));
  return found != header.artefacts.end() &&
         (found->second.type == "ring" || found->second.type == "pocket");
}

double MedianDeviation(std::vector<double> values) {
  const double median = Median(values);
  for (double& value : values) value = std::abs(value - median);
  return Median(values);
}

// Travel since the reversal up to the nominal point, of touches that count it up to the
// trigger: a reading would else explain itself, travel being the longer the later it
// triggers. They count so if that makes the travels of a setup more alike; then those
// that differ by no more than readings do have travelled the same.
void CountTravelToNominal(const std::vector<Row>& rows, std::vector<At>* at) {
  constexpr double kAlike = 10;  // Of the median deviation.
  for (int axis = 0; axis < 3; ++axis) {
    std::map<std::tuple<std::string, double>, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const At& where = (*at)[i];
      if (where.kind != RowKind::kTouch || !Known(where.since_rev_mm[axis])) continue;
      groups[{rows[i].setup, where.dir[axis]}].push_back(i);
    }
    for (const auto& [key, members] : groups) {
      std::vector<double> to_trigger_mm, to_nominal_mm;
      for (const std::size_t i : members) {
        const double d_mm = (*at)[i].since_rev_mm[axis];
        to_trigger_mm.push_back(d_mm);
        to_nominal_mm.push_back(d_mm + rows[i].value_mm * std::abs((*at)[i].n[axis]));
      }
      const double deviation_mm = MedianDeviation(to_nominal_mm);
      if (deviation_mm >= MedianDeviation(to_trigger_mm)) continue;
      const double median_mm = Median(to_nominal_mm);
      for (std::size_t k = 0; k < members.size(); ++k) {
        if (std::abs(to_nominal_mm[k] - median_mm) > kAlike * deviation_mm) continue;
        (*at)[members[k]].since_rev_mm[axis] = median_mm;
      }
    }
  }
}

}  // namespace

Observed::Observed(RowTable table,
                   DataHeader header,
                   Machine machine,
                   std::vector<Injected> effects)
    : table_(std::make_shared<const RowTable>(std::move(table))),
      header_(std::make_shared<const DataHeader>(std::move(header))),
      surroundings_(std::make_shared<const Surroundings>(table_->rows)),
      machine_(std::move(machine)),
      effects_(std::move(effects)),
      model_(effects_),
      pretravel_mm_(Vec3<double>::Constant(machine_.probe.pretravel_mm)),
      turns_(drawn_turns()) {
  for (const Axis axis : kAxes) {
    pretravel_mm_[Index(axis)] =
        BuiltValue(machine_, effects_, EffectIndex<ProbePretravel>(), Name(axis), 0);
  }
  for (const Row& row : table_->rows) {
    At at = AtOf(row, machine_, InForce(*header_, machine_, row.settings));
    surroundings_->Complete(row, &at);
    at.inside = IsInside(*header_, at.artefact);
    at_.push_back(at);
    dir_.push_back(at.dir);
    auto known = std::ranges::find(campaigns_, row.campaign);
    if (known == campaigns_.end()) {
      known = campaigns_.insert(campaigns_.end(), row.campaign);
    }
    campaign_of_.push_back(static_cast<int>(known - campaigns_.begin()));
  }
  CountTravelToNominal(table_->rows, &at_);
  Linearise();
}

std::vector<double> Observed::drawn_turns() const {
  return std::vector<double>(DiagnosedAs(machine_).TurnSds().size());
}

Observed Observed::With(const std::vector<Injected>& more) const {
  Observed copy = *this;
  copy.effects_.insert(copy.effects_.end(), more.begin(), more.end());
  copy.model_.insert(copy.model_.end(), more.begin(), more.end());
  copy.Linearise();
  return copy;
}

Observed Observed::AtFitted(const Eigen::VectorXd& left_mm,
                            const BaselinePoint& point) const {
  Observed copy = *this;
  copy.turns_ = point.turns.empty() ? drawn_turns() : point.turns;
  for (const Axis axis : kAxes) {
    const double pretravel_mm = point.pretravel_mm[Index(axis)];
    if (!Known(pretravel_mm)) continue;
    copy.pretravel_mm_[Index(axis)] = pretravel_mm;
    copy.model_.push_back({.effect = EffectIndex<ProbePretravel>(),
                           .axis = Name(axis),
                           .values = {pretravel_mm}});
  }
  for (Eigen::Index i = 0; i < num_rows(); ++i) {
    At& where = copy.at_[static_cast<std::size_t>(i)];
    if (where.kind == RowKind::kTouch) where.q_mm -= left_mm[i] * where.n;
    if (!machine_.kind->moves_along_axes()) continue;
    where.dir = dir_[static_cast<std::size_t>(i)];
    const Vec3<double> lost_mm =
        ErrorsAt<double>(machine_, where, effects_).lost_motion_mm;
    where.dir = GapSense(where, lost_mm + point.gap_mm);
  }
  copy.Linearise();
  return copy;
}

Observed Observed::AtNominal() const {
  Eigen::VectorXd values_mm(num_rows());
  for (Eigen::Index i = 0; i < num_rows(); ++i) values_mm[i] = row(i).value_mm;
  return AtFitted(values_mm, {});
}

void Observed::Linearise() {
  std::vector<Injected> model = model_;
  placed_ = DiagnosedAs(machine_).Place(*this, &at_, &model);
  const auto n = static_cast<Eigen::Index>(at_.size());
  residual_mm_.resize(n);
  true_q_mm_.resize(at_.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto errors = ErrorsAt<double>(machine_, at(i), model);
    true_q_mm_[static_cast<std::size_t>(i)] = at(i).q_mm + errors.motion_mm;
    residual_mm_[i] = row(i).value_mm - Value_mm(at(i), errors);
  }
}

Eigen::VectorXd Observed::Change_mm(const Injected& effect) const {
  const Stage stage = EffectAt(effect.effect).stage;
  const bool is_drive = stage == Stage::kDrive;
  Eigen::VectorXd change(num_rows());
  for (Eigen::Index i = 0; i < num_rows(); ++i) {
    const At& where = at(i);
    if (stage == Stage::kFrame && where.screws && where.screws->is_fixed) {
      change[i] = 0;
      continue;
    }
    const Asked<double> asked{
        .p = effect.values,
        .axis = effect.axis,
        .machine = machine_,
        .at = where,
        .q_mm = is_drive ? where.q_mm : true_q_mm_[static_cast<std::size_t>(i)]};
    Errors<double> errors;
    AddErrors(effect.effect, asked, &errors);
    errors.motion_mm -= TakenByPlay_mm(where, errors.lost_motion_mm);
    errors.motion_mm += MotionOfMotors_mm(where, errors);
    change[i] =
        ReadWith_mm(where, errors, /*pretravel_mm=*/0.0, /*tip_radius_cfg_mm=*/0.0);
  }
  return change;
}

double Observed::StatedSigma_mm(Eigen::Index i) const {
  if (Known(row(i).sigma_mm) && row(i).sigma_mm > 0) return row(i).sigma_mm;
  std::string id = at(i).kind == RowKind::kTouch ? "probe" : "";
  const auto campaign = header_->campaigns.find(row(i).campaign);
  if (campaign != header_->campaigns.end() && !campaign->second.instrument.empty()) {
    id = campaign->second.instrument;
  }
  const auto instrument = header_->instruments.find(id);
  if (instrument == header_->instruments.end()) return kUnknown;
  const Instrument& stated = instrument->second;
  // A reading rounded to a step is uncertain by the step over sqrt(12).
  const double sigma_um = std::hypot(stated.sigma_um,
                                     stated.resolution_um / 3.4641,
                                     UmFromMm(RoundingSigma_mm(*this, i)));
  return sigma_um > 0 ? MmFromUm(sigma_um) : kUnknown;
}

Extent Observed::ExtentOf() const {
  Extent extent;
  if (at_.empty()) return extent;
  extent.q_min_mm = extent.q_max_mm = at_.front().q_mm;
  if (const auto motors_mm = MotorsOf_mm(at_.front())) {
    extent.motor_min_mm = extent.motor_max_mm = *motors_mm;
  }
  for (const At& at : at_) {
    if (const auto motors_mm = MotorsOf_mm(at)) {
      extent.motor_min_mm = extent.motor_min_mm.cwiseMin(*motors_mm);
      extent.motor_max_mm = extent.motor_max_mm.cwiseMax(*motors_mm);
    }
    extent.q_min_mm = extent.q_min_mm.cwiseMin(at.q_mm);
    extent.q_max_mm = extent.q_max_mm.cwiseMax(at.q_mm);
    extent.times_s.push_back(at.t_s);
  }
  std::ranges::sort(extent.times_s);
  const auto repeated = std::ranges::unique(extent.times_s);
  extent.times_s.erase(repeated.begin(), repeated.end());
  extent.t_min_s = extent.times_s.front();
  // The order of rows stands for their times, but says nothing of seconds.
  extent.t_max_s = has_times() ? extent.times_s.back() : extent.t_min_s;
  return extent;
}

}  // namespace caltwin
