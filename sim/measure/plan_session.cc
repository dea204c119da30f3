#include "sim/measure/plan_session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr double kHoming_s = 25;
constexpr double kTouchOverhead_s = 0.5;
constexpr double kStandOff_mm = 4;
constexpr double kRetract_mm = 2;

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
  for (const DrawnDrive& drive : machine.kind->Drives(machine)) {
    Transmission& transmission = session_.header.transmission[drive.name];
    (drive.is_belt ? transmission.pulley_mm_per_rev : transmission.lead_mm) =
        drive.lead_mm;
    transmission.full_steps_per_mm = drive.full_steps_per_rev / drive.lead_mm;
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
  const Homed homed = machine_.kind->AtHome(machine_);
  q_mm_ = homed.q_mm;
  sense_ = last_dir_ = homed.sense;
  since_rev_mm_ = homed.since_rev_mm;
  motor_dir_ = homed.motor_sense.value_or(motor_dir_);
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
  motor_dir_ = machine_.kind->MotorSenses(machine_, q_mm_, q_mm).value_or(motor_dir_);
  screw_dir_.setConstant(-last_dir_[2]);
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
  for (int i = 0; i < 3; ++i) {
    screw_dir_[i] =
        std::abs(moved_mm[i]) < kStill_mm ? 0 : std::copysign(1, moved_mm[i]);
  }
  if (machine_.kind->drive_map() == nullptr) motor_dir_ = screw_dir_;
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
  const Vec3<double> cmd_mm(row.cmd_mm[0], row.cmd_mm[1], row.cmd_mm[2]);
  if (const auto motors = machine_.kind->Motors_mm(machine_, cmd_mm, raised_mm_)) {
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      row.motor_mm[k] = std::round((*motors)[i] * 1e6) / 1e6;
      row.motor_dir[k] = motor_dir_[i];
    }
  }
  if (const auto screws = machine_.kind->Screws_mm(machine_, cmd_mm, raised_mm_)) {
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      row.screw_mm[k] = std::round((*screws)[i] * 1e6) / 1e6;
      row.screw_dir[k] = screw_dir_[i];
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
  if (const auto why = machine_.kind->WhyNotAt(machine_, q_mm)) {
    Fail(why->text, why->hint);
  }
}

void MeasuringSession::Fail(const std::string& text, const std::string& hint) const {
  throw InputError(
      campaign_.place, fmt::format("campaign '{}' {}", campaign_.name, text), hint);
}

Vec3<double> MeasuringSession::Middle_mm() const {
  return machine_.kind->Middle_mm(machine_);
}

PlannedSession MeasuringSession::Done() && {
  session_.duration_s = t_s_;
  return std::move(session_);
}

}  // namespace caltwin
