#include "tools/commands/kinds/under_test.h"

#include <memory>

#include "scenarios/interrupt.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/in_force.h"

namespace caltwin {
namespace {

MachineUnderTest DeltaUnderTest(const TwinOptions& options, const MachineFile& file) {
  const auto twin =
      std::make_shared<const DeltaPerformConfig>(MakeDeltaConfig(file, options));
  const Measurer measure = [twin](const MeasuredSession& session,
                                  std::size_t already_read) {
    DeltaPerformConfig now = *twin;
    now.header = session.header;
    now.seed += already_read;
    now.already_read = already_read;
    now.interrupted = InterruptRequested;
    return PerformDelta(now, session.table.rows);
  };
  SettingsInForce settings;
  for (int i = 0; i < kNumTowers; ++i) {
    settings.steps_per_mm[TowerName(i)] =
        file.machine.settings.steps_per_mm[static_cast<std::size_t>(i)];
  }
  return {.machine = options.machine, .settings = settings, .measure = measure};
}

}  // namespace

std::optional<MachineUnderTest> UnderTestAsKind(const TwinOptions& options,
                                                const MachineFile& file) {
  if (file.machine.kind == DeltaKind()) return DeltaUnderTest(options, file);
  return std::nullopt;
}

}  // namespace caltwin
