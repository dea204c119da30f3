#include "scenarios/delta_twin.h"

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

// Of a touch inside the firmware: travel, descent and lift; with E, the probe stowed
// and deployed.
constexpr double kG33Touch_s = 3, kG33Stow_s = 2;

}  // namespace

DeltaTwin::DeltaTwin(const DeltaTwinConfig& config)
    : config_(config),
      simulated_(config_.machine,
                 config_.built,
                 config_.fidelity == Fidelity::kPhysics,
                 config_.seed,
                 config_.sample),
      plant_(&simulated_, config_.machine, config_.built.scatter_mm, &record_),
      calliper_(
          config_.built.build, config_.calliper_sigma_mm, config_.seed, config_.sample),
      marlin_(config_.machine.delta->model,
              config_.settings,
              TowerStepsPerMm(config_.machine),
              &plant_,
              [this](const GcodeCommand& words, DeltaModel<double>* settings) {
                return AnswerG33(words, settings);
              }),
      wire_(&marlin_) {
  marlin_.SetMeshRadius_mm(config_.machine.delta->print_radius_mm);
}

double DeltaTwin::machine_time_s() const {
  return marlin_.machine_time_s() + kG33Touch_s * g33_touches_ +
         kG33Stow_s * g33_stows_;
}

void DeltaTwin::BeginRecord(const std::string& campaign) {
  plant_.Begin(campaign);
  plant_.SetOffset(marlin_.probe_offset_mm());
}

std::vector<std::string> DeltaTwin::AnswerG33(const GcodeCommand& words,
                                              DeltaModel<double>* settings) {
  G33Options options{.probe_offset_mm = marlin_.probe_offset_mm(),
                     .variant = g33_variant_};
  options.printable_radius_mm = config_.machine.delta->print_radius_mm;
  try {
    options = ReadG33(words, options);
  } catch (const InputError& implausible) {
    return {implausible.what()};
  }
  const DeltaProbe probe = [this](
                               const DeltaModel<double>& at, double x_mm, double y_mm) {
    ++g33_touches_;
    return plant_.Touch(at, x_mm, y_mm);
  };
  const int before = g33_touches_;
  const DeltaOutcome outcome = CalibrateG33(probe, *settings, options);
  if (options.engages_probe) g33_stows_ += g33_touches_ - before;
  *settings = outcome.settings;
  said_mm_ = outcome.said_mm;
  return outcome.messages;
}

DeltaCalliper DeltaTwin::Calliper() {
  return {.rod_mm = [this](int rod) { return calliper_.Rod_mm(rod); },
          .between_mm =
              [this](const Vec3<double>& from_mm, const Vec3<double>& to_mm) {
                return calliper_.Between_mm(from_mm, to_mm);
              },
          .sigma_mm = config_.calliper_sigma_mm};
}

}  // namespace caltwin
