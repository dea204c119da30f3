#include "scenarios/z_offset_link.h"

#include <cmath>
#include <cstdio>

namespace caltwin {
namespace {

// What the controller says of its G-code height.
std::optional<double> GcodeHeight_mm(ZOffsetClient* client) {
  const auto position = client->Say("GET_POSITION");
  if (!position) return std::nullopt;
  // The base is in the position already.
  std::optional<double> z_mm, base_mm;
  for (const std::string& line : *position) {
    double read_mm = 0;
    if (std::sscanf(line.c_str(), "gcode: X:%*f Y:%*f Z:%lf", &read_mm) == 1) {
      z_mm = read_mm;
    }
    if (std::sscanf(line.c_str(), "gcode base: X:%*f Y:%*f Z:%lf", &read_mm) == 1) {
      base_mm = read_mm;
    }
  }
  if (!z_mm || !base_mm) return std::nullopt;
  return *z_mm - *base_mm;
}

}  // namespace

Expected<std::vector<std::string>> KlipperZWire::Send(
    std::string_view line, std::chrono::milliseconds /*patience*/) {
  const Reply reply = klipper_->Execute(line);
  if (!reply.error) return reply.lines;
  return tl::unexpected(
      MachineFault{.reply = reply.lines.empty() ? "!!" : reply.lines.back()});
}

std::optional<FeelerReading> ReadFeeler(const KlipperZ& klipper,
                                        const ZStationTwin& twin,
                                        ZOffsetClient* client) {
  constexpr double kLeaf_mm = 0.01;
  const auto gcode_mm = GcodeHeight_mm(client);
  const auto nought_mm = klipper.CarriageAtNought_mm(klipper.at_mm());
  if (!gcode_mm || !nought_mm) return std::nullopt;
  const double gap_mm = twin.Gap_mm(*nought_mm + *gcode_mm, klipper.at_mm());
  return FeelerReading{*gcode_mm, std::round(gap_mm / kLeaf_mm) * kLeaf_mm};
}

}  // namespace caltwin
