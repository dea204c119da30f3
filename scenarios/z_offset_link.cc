#include "scenarios/z_offset_link.h"

#include <cmath>

namespace caltwin {
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
  const auto heights = client->HeightsNow();
  const auto nought_mm = klipper.CarriageAtNought_mm(klipper.at_mm());
  if (!heights || !nought_mm) return std::nullopt;
  const double gap_mm = twin.Gap_mm(*nought_mm + heights->gcode_mm, klipper.at_mm());
  return FeelerReading{heights->gcode_mm + heights->mesh_mm,
                       std::round(gap_mm / kLeaf_mm) * kLeaf_mm};
}

}  // namespace caltwin
