#include "sim/twin/twin.h"

#include <utility>

#include "sim/base/units.h"
#include "sim/effects/injected.h"
#include "sim/twin/fast_plant.h"
#include "sim/twin/instruments.h"
#include "sim/twin/physics_plant.h"

namespace caltwin {
namespace {

Built MakeBuilt(const TwinConfig& config) {
  Built built{.machine = config.machine,
              .effects = config.effects,
              .artefacts = config.artefacts};
  const auto probe = config.instruments.find("probe");
  if (probe != config.instruments.end()) {
    built.probe_sigma_mm = MmFromUm(probe->second.sigma_um);
  }
  built.Prepare();
  return built;
}

}  // namespace

std::unique_ptr<TwinPlant> MakeTwinPlant(const TwinConfig& config) {
  if (config.fidelity == Fidelity::kFast) {
    return std::make_unique<FastPlant>(MakeBuilt(config), config.seed, config.sample);
  }
  return std::make_unique<PhysicsPlant>(MakeBuilt(config), config.seed, config.sample);
}

std::string ToString(Fidelity fidelity) {
  return fidelity == Fidelity::kPhysics ? "physics" : "fast";
}

struct Twin::Parts {
  explicit Parts(const TwinConfig& twin_config)
      : config(twin_config),
        plant(MakeTwinPlant(config)),
        firmware(config.machine, config.settings, config.firmware, plant.get()),
        link(&firmware),
        gauge(config.instruments, plant.get(), &firmware, config.seed, config.sample),
        person(plant.get(), &firmware) {}

  TwinConfig config;
  std::unique_ptr<TwinPlant> plant;
  Firmware firmware;
  EmulatedLink link;
  TwinGauge gauge;
  TwinOperator person;
};

Twin::Twin(const TwinConfig& config) : parts_(std::make_unique<Parts>(config)) {}
Twin::~Twin() = default;
Twin::Twin(Twin&&) noexcept = default;

Link& Twin::link() {
  return parts_->link;
}
Gauge& Twin::gauge() {
  return parts_->gauge;
}
Operator& Twin::person() {
  return parts_->person;
}
const TwinConfig& Twin::config() const {
  return parts_->config;
}
const Built& Twin::built() const {
  return parts_->plant->built();
}
Settings Twin::settings() const {
  return parts_->firmware.settings();
}
double Twin::machine_time_s() const {
  return parts_->firmware.machine_time_s();
}
int Twin::touches() const {
  return static_cast<int>(triggers().size());
}

const std::vector<TrueTrigger>& Twin::triggers() const {
  return parts_->plant->triggers();
}

Vec3<double> Twin::TipPosition_mm() const {
  return parts_->plant->Tip_mm();
}

Vec3<double> Twin::PositionError_mm(const Vec3<double>& q_mm,
                                    const Vec3<double>& dir) const {
  const Settings& settings = parts_->firmware.settings();
  At at = built().now;
  at.kind = RowKind::kPosition;
  at.on_table = false;
  at.q_mm = q_mm;
  at.dir = dir;
  if (at.drives) at.drives->dir = DrivesOf(at.drives->map, dir).cwiseSign();
  for (int i = 0; i < 3; ++i) {
    at.steps_per_mm[i] = settings.steps_per_mm[i];
    at.compensation_mm[i] = settings.backlash_mm[i];
  }
  return ErrorsAt<double>(parts_->config.machine, at, parts_->config.effects).motion_mm;
}

}  // namespace caltwin
