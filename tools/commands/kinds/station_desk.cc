#include <iostream>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "calibration/kinds/z_station/catalog.h"
#include "sim/base/input_error.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "tools/commands/kinds/desks.h"
#include "tools/commands/kinds/simulated_station.h"

namespace caltwin {
namespace {

bool HasStation(const std::optional<MachineFile>& file) {
  return file && file->machine.Own<ZStationDrawing>() != nullptr;
}

// A link whose lines the engine's idea of the station hears too.
class HeardByClient final : public Link {
 public:
  explicit HeardByClient(ZStationClient* client) : client_(client) {}
  Expected<std::vector<std::string>> Send(
      std::string_view line, std::chrono::milliseconds /*patience*/) override {
    return client_->Say(std::string(line));
  }

 private:
  ZStationClient* client_;
};

// A nozzle's height: the twin z_station, or a printer with Klipper's z_calibration on a
// wire (its own port: serial:/tmp/printer). Homes first. Without --apply the offset
// that was in force before is put back.
class StationDesk final : public Desk {
 public:
  StationDesk(const CalibrateOptions& options,
              const TwinOptions& papers,
              const std::optional<MachineFile>& file)
      : Desk(options, papers) {
    // A wire's bed is probed where z_station's is, unless --machine says another.
    if (HasStation(file)) bed_at_mm_ = ZStationOf(file->machine).bed_at_mm;
    if (!is_twin()) return;
    twin_ = std::make_shared<SimulatedStation>(TwinOptionsOf(options.link));
    Desk::Take(twin_, &twin_->link());
  }

  void Connect(Link* link) override {
    client_.emplace(link);
    heard_.emplace(&*client_);
    bench_.link = &*heard_;
    own_ = bench_.kept.Put(ZStationDesk{
        .client = &*client_,
        .hands = {.gap_mm = [this](double height_mm) { return Gap_mm(height_mm); },
                  .wipe = [this] { return Wipe(); },
                  .say =
                      [](const std::string& why) {
                        std::cerr << why << "\n";
                      }},
        .bed_at_mm = bed_at_mm_});
  }

  std::optional<ProcedureResult> Begin() override {
    ProcedureResult homed = client_->Home();
    own_->offset_before_mm = client_->GcodeBase_mm();
    return homed;
  }

  void End() override {
    const auto& before_mm = own_->offset_before_mm;
    if (!client_->has_tried() || own_->stays || !before_mm) return;
    const auto set = client_->Say(fmt::format("SET_GCODE_OFFSET Z={:.6f}", *before_mm));
    if (set) return;
    std::cerr << fmt::format(
        "the offset of before, {:.6f}, could not be put back: {}\n",
        *before_mm,
        set.error().reply);
  }

 private:
  bool Wipe() {
    if (twin_) {
      twin_->Wipe();
      return true;
    }
    const auto done =
        bench_.person->Do({.text = "Wipe the nozzle: nothing may hang under its tip."});
    if (!done) std::cerr << done.error().reply << "\n";
    return done.has_value();
  }

  std::optional<double> Gap_mm(double height_mm) {
    if (twin_) return twin_->Gap_mm(&*client_);
    const auto read_mm = bench_.gauge->Read_mm(fmt::format("feeler.{:g}", height_mm));
    if (!read_mm) std::cerr << read_mm.error().reply << "\n";
    return read_mm ? std::optional(*read_mm) : std::nullopt;
  }

  Eigen::Vector2d bed_at_mm_ = ZStationDrawing{}.bed_at_mm;
  std::shared_ptr<SimulatedStation> twin_{};
  std::optional<ZStationClient> client_{};
  std::optional<HeardByClient> heard_{};
  ZStationDesk* own_ = nullptr;  ///< The bench's.
};

void RefuseStationDesk(const CalibrateOptions& options,
                       const TwinOptions& /*papers*/,
                       const std::optional<MachineFile>& file) {
  if (!options.axis.empty()) {
    throw InputError({.file = "--axis"}, "a nozzle's height is along z alone");
  }
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "calibrating a nozzle's height writes no rows",
                     "`caltwin run --record` of a scenario does; --transcript keeps "
                     "each line");
  }
  if (!options.bench.empty()) {
    throw InputError({.file = "--bench"}, "a nozzle's height needs no artefacts");
  }
  if (!IsTwin(options)) return;
  if (HasStation(file)) return;
  throw InputError({.file = options.link},
                   "this twin has no endstop switch and magnetic probe",
                   "twin:z_station has; a scenario with `station:` puts one under any "
                   "printer");
}

std::unique_ptr<Desk> MakeStationDesk(const CalibrateOptions& options,
                                      const TwinOptions& papers,
                                      const std::optional<MachineFile>& file) {
  return std::make_unique<StationDesk>(options, papers, file);
}

}  // namespace

constinit const DeskKind kStationDesk{
    .kind = "z_station", .refuse = RefuseStationDesk, .make = MakeStationDesk};

}  // namespace caltwin
