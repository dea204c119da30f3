#include "scenarios/kinds/z_station_wire.h"

#include <cmath>

#include <fmt/format.h>

namespace caltwin {

std::optional<FeelerReading> ReadFeeler(const KlipperZ& klipper,
                                        const ZStationTwin& twin,
                                        ZStationClient* client) {
  constexpr double kLeaf_mm = 0.01;
  const auto heights = client->HeightsNow();
  const auto nought_mm = klipper.CarriageAtNought_mm(klipper.at_mm());
  if (!heights || !nought_mm) return std::nullopt;
  const double gap_mm = twin.Gap_mm(*nought_mm + heights->gcode_mm, klipper.at_mm());
  return FeelerReading{heights->gcode_mm + heights->mesh_mm,
                       std::round(gap_mm / kLeaf_mm) * kLeaf_mm};
}

Expected<std::vector<std::string>> StationHands::Send(
    std::string_view line, std::chrono::milliseconds /*patience*/) {
  return client_->Say(std::string(line));
}

Expected<double> StationHands::Read_mm(std::string_view id) {
  if (id != "feeler") {
    return tl::unexpected(MachineFault{
        .reply = fmt::format("Error: there is no gauge '{}', but a feeler", id)});
  }
  const auto read = ReadFeeler(*klipper_, *twin_, client_);
  if (read) return read->gap_mm;
  return tl::unexpected(
      MachineFault{.reply = "Error: the controller does not say where the nozzle is"});
}

Expected<void> StationHands::Zero(std::string_view /*id*/) {
  return tl::unexpected(MachineFault{.reply = "Error: a feeler gauge has no zero"});
}

Expected<void> StationHands::Do(const Act& act) {
  if (act.text.find("wipe") != std::string::npos ||
      act.text.find("Wipe") != std::string::npos) {
    twin_->Wipe();
    return {};
  }
  return tl::unexpected(
      MachineFault{.reply = "Error: the hands at a station only wipe the nozzle"});
}

}  // namespace caltwin
