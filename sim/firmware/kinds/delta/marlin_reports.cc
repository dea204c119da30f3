// What it tells of itself.

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/firmware/kinds/delta/marlin.h"

namespace caltwin {

std::optional<Reply> MarlinDelta::Tell(const GcodeCommand& command) const {
  if (command.Is('M', 115)) {
    const std::string about =
        "FIRMWARE_NAME:Marlin (caltwin) PROTOCOL_VERSION:1.0 MACHINE_TYPE:Delta "
        "EXTRUDER_COUNT:1";
    return Reply{.lines = {about,
                           "Cap:EEPROM:1",
                           "Cap:AUTOREPORT_TEMP:0",
                           "Cap:AUTOLEVEL:1",
                           "Cap:Z_PROBE:1",
                           "Cap:LEVELING_DATA:1",
                           "Cap:EMERGENCY_PARSER:0"}};
  }
  if (command.Is('M', 20) || command.Is('M', 21) || command.Is('M', 27)) {
    return Reply{.lines = {"echo:No SD card"}};
  }
  if (command.Is('M', 105))
    return Reply{.lines = {"T:0.00 /0.00 B:0.00 /0.00 @:0 B@:0"}};
  if (command.Is('M', 92)) {
    return Reply{.lines = {fmt::format("echo: M92 X{:.2f} Y{:.2f} Z{:.2f}",
                                       steps_per_mm_[0],
                                       steps_per_mm_[1],
                                       steps_per_mm_[2])}};
  }
  // Waiting, and what printing needs besides: nothing here is warm, or turns.
  constexpr std::array kAccepted = {17,  18,  82,  83,  84,  104, 106, 107,
                                    108, 109, 110, 113, 117, 140, 155, 190,
                                    201, 203, 204, 205, 211, 220, 221, 400};
  if (command.letter == 'M' &&
      std::ranges::find(kAccepted, command.code) != kAccepted.end())
    return Reply{};
  return std::nullopt;
}

Reply MarlinDelta::Switches() const {
  // Backed off, a switch is open again.
  const auto end = [&](std::size_t i) {
    const bool is_home = is_homed_ && at_mm_[2] >= height_mm_ - kAtEnd_mm;
    const bool is_at_end = settings_.endstop_mm[i] - height_mm_ < kAtEnd_mm;
    return is_home && is_at_end ? "TRIGGERED" : "open";
  };
  return {.lines = {"Reporting endstop status",
                    fmt::format("x_max: {}", end(0)),
                    fmt::format("y_max: {}", end(1)),
                    fmt::format("z_max: {}", end(2)),
                    "z_probe: open"}};
}

Reply MarlinDelta::Position() const {
  // Counts are carriage heights times steps, as Marlin's forward kinematics has them.
  const Vec3<double> motors = DeltaMotors_mm(settings_, at_mm_);
  std::array<long, 3> counts{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double arm = settings_.arm_mm[i], radius = settings_.radius_mm[i];
    const double height = settings_.endstop_mm[i] +
                          std::sqrt(arm * arm - radius * radius) -
                          motors[static_cast<Eigen::Index>(i)];
    counts[i] = std::lround(height * steps_per_mm_[i]);
  }
  return {
      .lines = {fmt::format("X:{:.2f} Y:{:.2f} Z:{:.2f} E:0.00 Count A:{} B:{} C:{}",
                            at_mm_[0],
                            at_mm_[1],
                            at_mm_[2],
                            counts[0],
                            counts[1],
                            counts[2])}};
}

std::vector<std::string> MarlinDelta::GeometryLines() const {
  const double arm = MeanOfTowers(settings_.arm_mm);
  const auto trim_deg = [&](std::size_t i) {
    return DegFromRad(settings_.angle_rad[i] - drawn_.angle_rad[i]);
  };
  return {fmt::format("echo:  M665 L{:.4f} R{:.4f} H{:.4f} S200.00 X{:.4f} Y{:.4f} "
                      "Z{:.4f} A{:.4f} B{:.4f} C{:.4f}",
                      arm,
                      settings_.radius_mm[0],
                      height_mm_,
                      trim_deg(0),
                      trim_deg(1),
                      trim_deg(2),
                      settings_.arm_mm[0] - arm,
                      settings_.arm_mm[1] - arm,
                      settings_.arm_mm[2] - arm),
          fmt::format("echo:  M666 X{:.4f} Y{:.4f} Z{:.4f}",
                      height_mm_ - settings_.endstop_mm[0],
                      height_mm_ - settings_.endstop_mm[1],
                      height_mm_ - settings_.endstop_mm[2])};
}

Reply MarlinDelta::Report() const {
  Reply reply{.lines = {"echo:  G21    ; Units in mm (mm)"}};
  for (const std::string& line : GeometryLines()) reply.lines.push_back(line);
  reply.lines.push_back(fmt::format("echo:  M851 X{:.2f} Y{:.2f} Z{:.2f}",
                                    probe_offset_mm_[0],
                                    probe_offset_mm_[1],
                                    probe_offset_mm_[2]));
  return reply;
}

}  // namespace caltwin
