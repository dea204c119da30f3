#include <algorithm>
#include <array>

#include "calibration/kinds/motor_stage/procedures.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

struct NamedProcedure {
  std::string_view name;
  MotorResult (*run)(MotorAxes* axes, const MotorOptions& options);
};
constexpr std::array kProcedures = {NamedProcedure{"servo_home", RunServoHome},
                                    NamedProcedure{"stepper_home", RunStepperHome},
                                    NamedProcedure{"index_verify", RunIndexVerify},
                                    NamedProcedure{"travel_limits", RunTravelLimits},
                                    NamedProcedure{"axis_sync", RunAxisSync},
                                    NamedProcedure{"emergency_stop", RunEmergencyStop},
                                    NamedProcedure{"motor_backlash", RunMotorBacklash}};

}  // namespace

MotorResult RunMotorProcedure(std::string_view name,
                              const MotorOptions& options,
                              MotorAxes* axes) {
  const auto found = std::ranges::find(kProcedures, name, &NamedProcedure::name);
  Require(found != kProcedures.end(), "a procedure of motor axes is named");
  return found->run(axes, options);
}

}  // namespace caltwin
