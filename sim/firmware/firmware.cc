#include "sim/firmware/firmware.h"

#include <utility>

#include "sim/base/require.h"
#include "sim/firmware/parts.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

Reply Refuse(const std::string& words) {
  return {.lines = {"Error: " + words}, .error = true};
}

void Append(Reply more, Reply* reply) {
  for (std::string& line : more.lines) reply->lines.push_back(std::move(line));
  reply->error = reply->error || more.error;
}

Firmware::Parts::Parts(const Machine& drawn,
                       const Settings& believed,
                       const FirmwareOptions& chosen,
                       Plant* driven)
    : machine(drawn),
      initial_settings(believed),
      settings(believed),
      options(chosen),
      plant(driven),
      motion(machine, &settings, driven) {
  lines_left = kMostLines;
  Start();
}

Firmware::Firmware(const Machine& machine,
                   const Settings& settings,
                   const FirmwareOptions& options,
                   Plant* plant) {
  Require(plant != nullptr, "the firmware has a plant");
  Require(!options.leadscrews || machine.kind->num_z_motors() == 3,
          "a bed that stands on screws has three");
  parts_ = std::make_unique<Parts>(machine, settings, options, plant);
}
Firmware::~Firmware() = default;
Firmware::Firmware(Firmware&&) noexcept = default;

Reply Firmware::Execute(std::string_view line) {
  return parts_->Execute(line);
}

Reply Firmware::FinishMoves() {
  parts_->motion.Finish();
  return parts_->Execute("");
}

bool Firmware::halted() const {
  return parts_->is_halted();
}

double Firmware::machine_time_s() const {
  return parts_->motion.time_s();
}

const Settings& Firmware::settings() const {
  return parts_->settings;
}

Vec3<double> Firmware::position_mm() const {
  return parts_->motion.counted_mm();
}

const Motors& Firmware::motor_steps() const {
  return parts_->motion.motor_steps();
}

Vec3<double> Firmware::direction() const {
  return parts_->motion.senses();
}

bool Firmware::is_homed(Axis axis) const {
  return parts_->motion.is_homed(axis);
}

const Pivots<double>& Firmware::leadscrews_mm() const {
  return parts_->bed.leadscrews.value().at_mm;
}

Vec3<double> Firmware::raised_mm() const {
  return parts_->Raised_mm();
}

const std::vector<ProbedPoint>& Firmware::probed() const {
  return parts_->bed.probed;
}

const std::map<std::string, std::string>& Firmware::files() const {
  return parts_->options.files;
}

void Firmware::WriteFile(const std::string& path, const std::string& text) {
  parts_->Store(path, text, /*appends=*/false);
}

}  // namespace caltwin
