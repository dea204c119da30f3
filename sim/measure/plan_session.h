#pragma once

#include <string>
#include <vector>

#include "sim/base/rng.h"
#include "sim/measure/plan.h"
#include "sim/measure/plan_weather.h"

namespace caltwin {

/// Follows a machine through its measuring session, as far as commands say: where its
/// axes stand, in which sense each moved last and how far since it turned round, what
/// time it is, how warm. Campaigns tell it where to go and what to read.
class MeasuringSession {
 public:
  MeasuringSession(const Plan& plan, const Machine& machine, std::uint64_t seed);

  /// Begins a campaign: after this, readings are its own.
  void Begin(const PlannedCampaign& campaign, const std::string& instrument);
  /// References every axis: a new homing session.
  void Home();
  void Wait(double s);
  /// Spindle and bed are switched on at given times, and off [s, from now].
  void Heat(const HeatPlan& plan);
  /// A heater holds it at that from now on.
  void HoldAt(Sensor sensor, double temp_c);
  /// A straight move of the axes.
  void MoveTo(const Vec3<double>& q_mm, double feed_mm_s);
  void Rapid(const Vec3<double>& q_mm);
  /// Of a bed on screws: how much higher than the others' each screw is told to
  /// stand, whatever its axes do.
  void SetScrews(const Vec3<double>& raised_mm);

  /// A gauge reads at standstill where the axes have just gone: kind, n, setup, feature
  /// and what else the campaign knows are in `row`.
  void ReadGauge(Row row, double dwell_s);
  /// The probe touches `row.cmd_mm` along -n: a quick touch, 2 mm back, and the touch
  /// that counts, at `row.feed_mm_s`.
  void Touch(Row row);

  /// Certificate of what is touched, for the header; of a plan that says more, that.
  const CertifiedArtefact& Certify(const std::string& id, CertifiedArtefact artefact);

  /// Throws InputError, naming the campaign, unless the axes can stand there.
  void RequireReach(const Vec3<double>& q_mm) const;
  /// A fault of this campaign's options.
  [[noreturn]] void Fail(const std::string& text, const std::string& hint) const;

  const Machine& machine() const { return machine_; }
  /// Chance of this campaign alone.
  Rng* rng() { return &rng_; }
  const std::string& campaign() const { return campaign_.name; }
  Vec3<double> Middle_mm() const;
  double now_s() const { return t_s_; }
  std::size_t num_rows() const { return session_.rows.size(); }
  PlannedSession Done() &&;

 private:
  void Finish(Row row);

  const Plan& plan_;
  const Machine& machine_;
  std::uint64_t seed_;
  PlannedCampaign campaign_{};
  Rng rng_;
  Weather weather_;
  PlannedSession session_{};
  double t_s_ = 0;
  int homings_ = 0;
  Vec3<double> q_mm_;
  Vec3<double> last_dir_ = Vec3<double>::Zero();  ///< Of the last move alone.
  Vec3<double> sense_ = Vec3<double>::Zero();     ///< In which each moved last.
  Vec3<double> since_rev_mm_ = Vec3<double>::Zero();
  Vec3<double> motor_dir_ = Vec3<double>::Zero();  ///< Where motors are no axes.
  Vec3<double> screw_dir_ = Vec3<double>::Zero();  ///< Of a bed's, beside motors.
  Vec3<double> raised_mm_ = Vec3<double>::Zero();  ///< As SetScrews has them.
};

/// Puts a list in an order of chance.
template <typename T>
void Shuffle(std::vector<T>* items, Rng* rng) {
  for (std::size_t i = items->size(); i > 1; --i) {
    const auto k = static_cast<std::size_t>(rng->Uniform() * static_cast<double>(i));
    std::swap((*items)[i - 1], (*items)[k]);
  }
}

}  // namespace caltwin
