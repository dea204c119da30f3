#include <array>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 1> kWhole = {""};
constexpr std::array<std::string_view, 1> kHeight = {"z"};
constexpr std::array<std::string_view, 2> kParts = {"nozzle", "plate"};
constexpr std::array<std::string_view, 2> kBodies = {"frame", "bed"};
constexpr std::array<std::string_view, 3> kChannels = {"z", "nozzle", "bed"};
constexpr std::array kEffects = {KindEffect{"missed_steps", kHeight},
                                 KindEffect{"frame_growth", kWhole},
                                 KindEffect{"frame_temperature", kBodies},
                                 KindEffect{"random_walk", kWhole},
                                 KindEffect{"probe_temperature", kWhole},
                                 KindEffect{"trigger_scatter", kWhole},
                                 KindEffect{"nozzle_temperature", kWhole},
                                 KindEffect{"ooze", kWhole},
                                 KindEffect{"switch_offset", kWhole},
                                 KindEffect{"station_change", kParts},
                                 KindEffect{"unknown", kChannels}};

// A printer of which only its head's height is followed.
class ZStationMachine final : public MachineKind {
 public:
  std::string_view name() const override { return "z_station"; }
  std::string_view about() const override {
    return "A printer's head over its endstop switch and bed, with a magnetic switch "
           "probe: "
           "what sets a nozzle's height. `caltwin run` and `calibrate` set it by "
           "Klipper's "
           "commands, `serve` is one, `simulate`, `diagnose` and `plan` measure one. A "
           "`station:` in a scenario puts one under any printer.";
  }
  std::string_view where() const override { return " at a printer's station"; }
  std::span<const KindEffect> effects() const override { return kEffects; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    machine->own = ReadZStationDrawing(map);
  }
};

}  // namespace

const MachineKind* ZStationKind() {
  static const ZStationMachine kind;
  return &kind;
}

}  // namespace caltwin
