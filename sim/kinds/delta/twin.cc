#include "sim/kinds/delta/twin.h"

#include "sim/base/input_error.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

// Of a touch inside the firmware: travel, descent and lift; with E, the probe stowed
// and deployed.
constexpr double kG33Touch_s = 3, kG33Stow_s = 2;

}  // namespace

DeltaTwin::DeltaTwin(const DeltaTwinConfig& config)
    : config_(config),
      plant_(config_.machine,
             config_.built,
             config_.fidelity == Fidelity::kPhysics,
             config_.seed,
             config_.sample),
      rows_(config_.machine, config_.built.scatter_mm, &record_),
      calliper_(
          config_.built.build, config_.calliper_sigma_mm, config_.seed, config_.sample),
      marlin_(DeltaOf(config_.machine).model,
              config_.settings,
              TowerStepsPerMm(config_.machine),
              &plant_,
              [this](const GcodeCommand& words, DeltaModel<double>* settings) {
                return AnswerG33(words, settings);
              }),
      wire_(&marlin_) {
  marlin_.SetMeshRadius_mm(DeltaOf(config_.machine).print_radius_mm);
  marlin_.SetWitness(
      [this](const DeltaModel<double>& settings, const Vec3<double>& counted_mm) {
        rows_.Add(settings, counted_mm);
      });
}

double DeltaTwin::machine_time_s() const {
  return marlin_.machine_time_s() + kG33Touch_s * g33_touches_ +
         kG33Stow_s * g33_stows_;
}

void DeltaTwin::BeginRecord(const std::string& campaign) {
  rows_.Begin(campaign);
  rows_.SetOffset(marlin_.probe_offset_mm());
}

std::vector<std::string> DeltaTwin::AnswerG33(const GcodeCommand& words,
                                              DeltaModel<double>* settings) {
  if (!g33_) return {"Unknown command: G33"};
  const TouchOfBed touch = [this](
                               const DeltaModel<double>& at, double x_mm, double y_mm) {
    ++g33_touches_;
    return marlin_.Touch(at, x_mm, y_mm);
  };
  const int before = g33_touches_;
  try {
    G33Answer answer = g33_(words, *settings, marlin_.probe_offset_mm(), touch);
    if (answer.stows) g33_stows_ += g33_touches_ - before;
    *settings = answer.settings;
    said_mm_ = answer.said_mm;
    return std::move(answer.lines);
  } catch (const InputError& implausible) {
    return {implausible.what()};
  }
}

}  // namespace caltwin
