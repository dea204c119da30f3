#include "sim/measure/plan_session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

constexpr double kHoming_s = 25;
constexpr double kTouchOverhead_s = 0.5;
constexpr double kStandOff_mm = 4;
constexpr double kRetract_mm = 2;
constexpr double kStill_mm = 1e-9;  // Below this an axis has not moved.

double MostFeed_mm_s(const Machine& machine, const Vec3<double>& travel_mm) {
  double most_mm_s = 1e9;
  const double length_mm = travel_mm.norm();
  for (const Axis axis : kAxes) {
    const double part = std::abs(travel_mm[Index(axis)]) / length_mm;
    if (part > kStill_mm) {
      most_mm_s = std::min(most_mm_s, machine.axis(axis).max_feed_mm_s / part);
    }
  }
  return most_mm_s;
}

}  // namespace

MeasuringSession::MeasuringSession(const Plan& plan,
                                   const Machine& machine,
                                   std::uint64_t seed)
    : plan_(plan), machine_(machine), seed_(seed), rng_(seed, 0, "plan") {
  session_.header.machine = plan.machine;
  session_.header.instruments = plan.instruments;
  session_.header.tip_radius_mm = machine.settings.tip_radius_mm;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    const std::string name = machine.delta ? TowerName(Index(axis)) : Name(axis);
    Transmission& transmission = session_.header.transmission[name];
    (drawing.is_belt ? transmission.pulley_mm_per_rev : transmission.lead_mm) =
        drawing.lead_mm;
    transmission.full_steps_per_mm = drawing.full_steps_per_rev / drawing.lead_mm;
  }
  if (machine.triple_z) {
    for (int i = 0; i < kNumScrews; ++i) {
      const ScrewDrawing& screw = machine.triple_z->screws[static_cast<std::size_t>(i)];
      Transmission& transmission = session_.header.transmission[ScrewName(i)];
      transmission.lead_mm = screw.lead_mm;
      transmission.full_steps_per_mm = screw.full_steps_per_rev / screw.lead_mm;
    }
  }
  Home();
}

void MeasuringSession::Begin(const PlannedCampaign& campaign,
                             const std::string& instrument) {
  campaign_ = campaign;
  rng_ = Rng(seed_, 0, "plan." + campaign.name);
  session_.header.campaigns[campaign.name] = {.instrument = instrument,
                                              .plan = campaign.id,
                                              .options = campaign.options.AsWritten()};
  Instruments& instruments = session_.header.instruments;
  if (!instruments.contains(instrument)) instruments[instrument].kind = instrument;
}

void MeasuringSession::Home() {
  t_s_ += kHoming_s;
  ++homings_;
  if (machine_.delta) {
    q_mm_ = {0, 0, machine_.delta->settings.endstop_mm[0]};
    sense_ = last_dir_ = {0, 0, 1};
    motor_dir_.setConstant(-1);
    since_rev_mm_.setConstant(q_mm_[2] / 2);
    return;
  }
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine_.axis(axis);
    const int i = Index(axis);
    q_mm_[i] = drawing.home_mm();
    sense_[i] = drawing.home == HomeEnd::kMin ? -1 : 1;
    since_rev_mm_[i] = drawing.travel_mm() / 2;
  }
  last_dir_ = sense_;
}

void MeasuringSession::Wait(double s) {
  t_s_ += s;
}

void MeasuringSession::Heat(const HeatPlan& plan) {
  weather_.Heat(t_s_, plan);
}

void MeasuringSession::HoldAt(Sensor sensor, double temp_c) {
  weather_.Hold(sensor, t_s_, temp_c);
}

void MeasuringSession::MoveTo(const Vec3<double>& q_mm, double feed_mm_s) {
  const Vec3<double> travel_mm = q_mm - q_mm_;
  const double length_mm = travel_mm.norm();
  if (length_mm < kStill_mm) return;
  for (int i = 0; i < 3; ++i) {
    const double gone_mm = std::abs(travel_mm[i]);
    last_dir_[i] = gone_mm < kStill_mm ? 0 : std::copysign(1, travel_mm[i]);
    if (last_dir_[i] == 0) continue;
    since_rev_mm_[i] = last_dir_[i] == sense_[i] ? since_rev_mm_[i] + gone_mm : gone_mm;
    sense_[i] = last_dir_[i];
  }
  if (machine_.delta) {
    const DeltaModel<double>& settings = machine_.delta->settings;
    // At the end of the move: a carriage may turn back within it.
    constexpr double kLast_mm = 0.01;
    const Vec3<double> just_before_mm =
        q_mm - travel_mm * (std::min(kLast_mm, length_mm) / length_mm);
    const Vec3<double> moved_mm =
        DeltaMotors_mm(settings, q_mm) - DeltaMotors_mm(settings, just_before_mm);
    for (int i = 0; i < kNumTowers; ++i) {
      motor_dir_[i] =
          std::abs(moved_mm[i]) < kStill_mm ? 0 : std::copysign(1, moved_mm[i]);
    }
  }
  // As the nozzle's height over the bed grows, the screws go down.
  if (machine_.triple_z) motor_dir_.setConstant(-last_dir_[2]);
  const double feed =
      std::min(std::max(feed_mm_s, kStill_mm), MostFeed_mm_s(machine_, travel_mm));
  t_s_ += length_mm / feed + feed / machine_.axis(Axis::kX).acceleration_mm_s2;
  q_mm_ = q_mm;
}

void MeasuringSession::Rapid(const Vec3<double>& q_mm) {
  MoveTo(q_mm, 1e9);
}

void MeasuringSession::SetScrews(const Vec3<double>& raised_mm) {
  const Vec3<double> moved_mm = raised_mm - raised_mm_;
  for (int i = 0; i < kNumScrews; ++i) {
    motor_dir_[i] =
        std::abs(moved_mm[i]) < kStill_mm ? 0 : std::copysign(1, moved_mm[i]);
  }
  const double feed_mm_s = machine_.axis(Axis::kZ).max_feed_mm_s;
  t_s_ += moved_mm.cwiseAbs().maxCoeff() / feed_mm_s;
  raised_mm_ = raised_mm;
}

void MeasuringSession::Finish(Row row) {
  row.row = static_cast<std::int64_t>(session_.rows.size()) + 1;
  row.campaign = campaign_.name;
  row.home = fmt::format("{}", homings_);
  // Clocks of measuring programs show tenths of a second.
  row.t_s = std::round(t_s_ * 10) / 10;
  weather_.Write(row.t_s, &row);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    row.dir[k] = last_dir_[i];
    row.since_rev_mm[k] = std::round(since_rev_mm_[i] * 1e6) / 1e6;
  }
  if (machine_.delta) {
    const Vec3<double> motors_mm = DeltaMotors_mm<double>(
        machine_.delta->settings, {row.cmd_mm[0], row.cmd_mm[1], row.cmd_mm[2]});
    for (int i = 0; i < kNumTowers; ++i) {
      const auto k = static_cast<std::size_t>(i);
      row.motor_mm[k] = std::round(motors_mm[i] * 1e6) / 1e6;
      row.motor_dir[k] = motor_dir_[i];
    }
  }
  if (machine_.triple_z) {
    for (int i = 0; i < kNumScrews; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double told_mm = machine_.triple_z->top_mm - row.cmd_mm[2] + raised_mm_[i];
      row.motor_mm[k] = std::round(told_mm * 1e6) / 1e6;
      row.motor_dir[k] = motor_dir_[i];
    }
  }
  session_.rows.push_back(std::move(row));
}

void MeasuringSession::ReadGauge(Row row, double dwell_s) {
  for (int i = 0; i < 3; ++i) row.cmd_mm[static_cast<std::size_t>(i)] = q_mm_[i];
  Wait(dwell_s);
  Finish(std::move(row));
}

void MeasuringSession::Touch(Row row) {
  row.kind = RowKind::kTouch;
  Vec3<double> contact_mm;
  Vec3<double> n;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    n[i] = row.n[k];
    const double offset_mm = Known(row.probe_off_mm[k]) ? row.probe_off_mm[k] : 0;
    contact_mm[i] =
        row.cmd_mm[k] + machine_.settings.tip_radius_mm * row.n[k] - offset_mm;
  }
  RequireReach(contact_mm);
  Rapid(contact_mm + kStandOff_mm * n);
  MoveTo(contact_mm, machine_.probe.speeds_mm_s.front());
  MoveTo(contact_mm + kRetract_mm * n, machine_.probe.speeds_mm_s.front());
  MoveTo(contact_mm, row.feed_mm_s);
  Wait(kTouchOverhead_s);
  Finish(std::move(row));
  MoveTo(contact_mm + kStandOff_mm * n, machine_.axis(Axis::kZ).max_feed_mm_s);
}

const CertifiedArtefact& MeasuringSession::Certify(const std::string& id,
                                                   CertifiedArtefact artefact) {
  const auto said = plan_.artefacts.find(id);
  if (said != plan_.artefacts.end()) {
    const auto drawn_mm = artefact.sizes_mm;
    artefact = said->second;
    if (artefact.sizes_mm.empty()) artefact.sizes_mm = drawn_mm;
  }
  return session_.header.artefacts.try_emplace(id, std::move(artefact)).first->second;
}

void MeasuringSession::RequireReach(const Vec3<double>& q_mm) const {
  if (machine_.delta) {
    const Vec3<double> motors_mm = DeltaMotors_mm(machine_.delta->settings, q_mm);
    if (motors_mm.allFinite() && (motors_mm.array() > 0).all()) return;
    Fail(
        fmt::format("would take the nozzle to ({:.3f}, {:.3f}, {:.3f}) mm, beyond what "
                    "its rods reach",
                    q_mm[0],
                    q_mm[1],
                    q_mm[2]),
        "choose a smaller radius or height");
  }
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine_.axis(axis);
    const double q = q_mm[Index(axis)];
    if (q >= drawing.min_mm - kStill_mm && q <= drawing.max_mm + kStill_mm) continue;
    Fail(fmt::format("would take {} to {:.3f} mm, beyond its travel of {} to {} mm",
                     Name(axis),
                     q,
                     drawing.min_mm,
                     drawing.max_mm),
         "choose another place or a smaller extent");
  }
}

void MeasuringSession::Fail(const std::string& text, const std::string& hint) const {
  throw InputError(
      campaign_.place, fmt::format("campaign '{}' {}", campaign_.name, text), hint);
}

Vec3<double> MeasuringSession::Middle_mm() const {
  if (machine_.delta) return Vec3<double>::Zero();
  return {machine_.axis(Axis::kX).mid_mm(),
          machine_.axis(Axis::kY).mid_mm(),
          machine_.axis(Axis::kZ).mid_mm()};
}

PlannedSession MeasuringSession::Done() && {
  session_.duration_s = t_s_;
  return std::move(session_);
}

}  // namespace caltwin
