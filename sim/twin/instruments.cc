#include "sim/twin/instruments.h"

#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

tl::unexpected<MachineFault> Refused(const std::string& text) {
  return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, text});
}

// "laser.x" -> {"laser", "x"}; "calliper.block.x" -> {"calliper", "block.x"}.
std::pair<std::string, std::string> SplitAtDot(const std::string& id) {
  const std::size_t dot = id.find('.');
  if (dot == std::string::npos) return {id, ""};
  return {id.substr(0, dot), id.substr(dot + 1)};
}

}  // namespace

TwinGauge::TwinGauge(Instruments instruments,
                     TwinPlant* plant,
                     Firmware* firmware,
                     std::uint64_t seed,
                     std::uint64_t sample)
    : instruments_(std::move(instruments)),
      plant_(plant),
      firmware_(firmware),
      seed_(seed),
      sample_(sample) {}

Expected<double> TwinGauge::Truth_mm(const std::string& id) {
  const Reply finished = firmware_->FinishMoves();
  if (finished.error || firmware_->halted()) {
    return tl::unexpected(
        MachineFault{MachineFault::Kind::kAlarm,
                     fmt::format("{}", fmt::join(finished.lines, "\n"))});
  }
  const auto [kind, what] = SplitAtDot(id);
  if (kind == "laser" || kind == "dial") {
    const auto axis = AxisNamed(what);
    if (!axis)
      return Refused(fmt::format("'{}' is no axis that a {} can read", what, kind));
    return plant_->Tip_mm()[Index(*axis)];
  }
  if (id == "calliper.tip") return 2 * plant_->built().probe.tip_radius_mm;
  if (kind == "calliper") {
    const auto [artefact_id, letter] = SplitAtDot(what);
    for (const Artefact& artefact : plant_->built().standing) {
      const auto axis = AxisNamed(letter);
      if (artefact.id == artefact_id && axis) return artefact.size_mm[Index(*axis)];
    }
  }
  return Refused(
      fmt::format("there is no gauge '{}'; there are laser.x, dial.x, "
                  "calliper.ARTEFACT.x, calliper.tip",
                  id));
}

double TwinGauge::Reading_mm(const std::string& id, double truth_mm) {
  const std::string kind = SplitAtDot(id).first;
  auto declared = instruments_.find(id);
  if (declared == instruments_.end()) declared = instruments_.find(kind);
  if (declared == instruments_.end()) return truth_mm;
  Rng& rng = noise_.try_emplace(id, seed_, sample_, "gauge." + id).first->second;
  const double reading_mm =
      truth_mm + MmFromUm(declared->second.sigma_um) * rng.Normal();
  const double step_mm = MmFromUm(declared->second.resolution_um);
  return step_mm > 0 ? std::round(reading_mm / step_mm) * step_mm : reading_mm;
}

Expected<double> TwinGauge::Read_mm(std::string_view id) {
  const std::string name(id);
  const auto truth_mm = Truth_mm(name);
  if (!truth_mm) return truth_mm;
  const auto zero = zeros_mm_.find(name);
  return Reading_mm(name, *truth_mm - (zero == zeros_mm_.end() ? 0 : zero->second));
}

Expected<void> TwinGauge::Zero(std::string_view id) {
  const std::string name(id);
  const auto truth_mm = Truth_mm(name);
  if (!truth_mm) return tl::unexpected(truth_mm.error());
  if (SplitAtDot(name).first != "dial") return Refused("only a dial can be zeroed");
  zeros_mm_[name] = *truth_mm;
  return {};
}

TwinOperator::TwinOperator(TwinPlant* plant, Firmware* firmware)
    : plant_(plant), firmware_(firmware) {}

Expected<void> TwinOperator::Do(const Act& act) {
  firmware_->FinishMoves();
  if (act.kind == Act::Kind::kConfirm || act.kind == Act::Kind::kOther) return {};
  if (act.kind == Act::Kind::kFitStylus) {
    if (act.artefact != "ball" && act.artefact != "disc") {
      return Refused(
          fmt::format("there is no stylus '{}': ball or disc", act.artefact));
    }
    plant_->Change(plant_->built().artefacts,
                   act.artefact == "disc" ? Stylus::kDisc : Stylus::kBall);
    return {};
  }
  std::vector<Artefact> artefacts = plant_->built().artefacts;
  const auto axis = AxisNamed(std::string(1, act.axis));
  for (Artefact& artefact : artefacts) {
    if (artefact.id != act.artefact || artefact.type != ArtefactType::kBlock123 ||
        !axis) {
      continue;
    }
    const Vec3<double> drawn_mm = BlockLying(*axis, act.length_mm);
    artefact.size_mm = drawn_mm;
    plant_->Change(artefacts, plant_->built().stylus);
    return {};
  }
  return Refused(fmt::format("there is no 1-2-3 block '{}' to turn", act.artefact));
}

}  // namespace caltwin
