#include "calibration/kinds/z_station/switch_offset.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/touch_noise.h"

namespace caltwin {
namespace {

constexpr std::array kHeights_mm = {5.0, 3.0, 1.0, 0.5, 0.3, 0.1};
constexpr double kTooNear_mm = 0.02;
constexpr double kFeelerStep_mm = 0.01;
// A step of Z and the three decimals that are printed.
constexpr double kMachine_mm = 0.0005;

// As published; and before that one from which neither a switch_offset, none being
// below 0, nor a bed mesh lets the nozzle down to the bed.
std::vector<double> HeightsFrom_mm(double in_force_mm, double mesh_mm) {
  std::vector<double> heights_mm(kHeights_mm.begin(), kHeights_mm.end());
  const double safe_mm = std::ceil(in_force_mm - std::min(mesh_mm, 0.0)) + 1;
  if (safe_mm > heights_mm.front()) {
    heights_mm.insert(heights_mm.begin(), safe_mm);
  }
  return heights_mm;
}

std::optional<double> Measured_mm(double height_mm,
                                  const FeelerHands& hands,
                                  ProcedureResult* result) {
  const auto gap_mm = hands.gap_mm(height_mm);
  if (!gap_mm || !std::isfinite(*gap_mm)) {
    FailZStation({.reply = "nobody measured the gap"}, result);
    return std::nullopt;
  }
  if (*gap_mm <= 0) {
    FailZStation(
        {.reply = fmt::format("a gap of {:.3f} mm at Z{}: the nozzle is on the bed",
                              *gap_mm,
                              height_mm)},
        result);
    return std::nullopt;
  }
  result->messages.push_back(
      fmt::format("at Z{}: a gap of {:.3f} mm", height_mm, *gap_mm));
  return gap_mm;
}

/// A gap, and the height that was commanded for it.
struct SwitchOffsetGap {
  double height_mm = 0, gap_mm = 0;
  double off_mm() const { return gap_mm - height_mm; }
};

// Whether a step down narrowed the gap by as much, but for what a person with feeler
// gauges may be off: leaves, and a part of what is measured by many of them.
bool Agree(const SwitchOffsetGap& above, const SwitchOffsetGap& here) {
  constexpr double kLeaves_mm = 0.05, kPart = 0.05;
  const double may_mm = kLeaves_mm + kPart * above.height_mm;
  return std::abs(here.off_mm() - above.off_mm()) <= may_mm;
}

// The gap at a height; nullopt: `result` says why. Measured once more where it
// contradicts the one above.
std::optional<SwitchOffsetGap> GapAt(double height_mm,
                                     const SwitchOffsetGap* above,
                                     ZStationClient* client,
                                     const FeelerHands& hands,
                                     ProcedureResult* result) {
  if (const auto moved = client->Say(fmt::format("G0 Z{}", height_mm)); !moved) {
    FailZStation(moved.error(), result);
    return std::nullopt;
  }
  auto gap_mm = Measured_mm(height_mm, hands, result);
  if (!gap_mm) return std::nullopt;
  if (!above || Agree(*above, {height_mm, *gap_mm}))
    return SwitchOffsetGap{height_mm, *gap_mm};
  const std::string why = fmt::format(
      "from Z{} to Z{} the gap went from {:.3f} to {:.3f} mm: measured once more",
      above->height_mm,
      height_mm,
      above->gap_mm,
      *gap_mm);
  result->messages.push_back(why);
  if (hands.say) hands.say(why);
  gap_mm = Measured_mm(height_mm, hands, result);
  if (!gap_mm) return std::nullopt;
  if (Agree(*above, {height_mm, *gap_mm})) return SwitchOffsetGap{height_mm, *gap_mm};
  FailZStation(
      {.reply = fmt::format(
           "the gaps contradict each other: {:.3f} mm at Z{}, {:.3f} mm at Z{}",
           above->gap_mm,
           above->height_mm,
           *gap_mm,
           height_mm)},
      result);
  return std::nullopt;
}

// To where CALIBRATE_Z probes the bed, well over it.
std::optional<ZStationClient::Heights> GoOverTheBed(double in_force_mm,
                                                    const Eigen::Vector2d& at_mm,
                                                    ZStationClient* client,
                                                    ProcedureResult* result) {
  constexpr double kMesh_mm = 10;  // No mesh is deeper.
  const double safe_mm = HeightsFrom_mm(in_force_mm, 0).front() + kMesh_mm;
  for (const std::string& line :
       {std::string("G90"),
        fmt::format("G0 Z{}", safe_mm),
        fmt::format("G0 X{:.3f} Y{:.3f}", at_mm[0], at_mm[1])}) {
    if (const auto moved = client->Say(line); moved) continue;
    FailZStation({.reply = "the nozzle did not get over the bed (" + line + ")"},
                 result);
    return std::nullopt;
  }
  return client->HeightsNow().value_or(ZStationClient::Heights{});
}

// A mesh is 0 at its own point of reference, which need not be where the bed is probed.
void TellMesh(double mesh_mm, ProcedureResult* result) {
  if (std::abs(mesh_mm) < kMachine_mm) return;
  result->messages.push_back(fmt::format(
      "the bed mesh moves the nozzle by {:+.3f} mm where CALIBRATE_Z probes the bed, "
      "and the first layer with it: taken off here. Have its "
      "relative_reference_index at that place",
      mesh_mm));
}

// How much wider the last gap was than its height; nullopt: `result` says why.
std::optional<double> Descend(double in_force_mm,
                              const SwitchOffsetOptions& options,
                              ZStationClient* client,
                              const FeelerHands& hands,
                              ProcedureResult* result) {
  const auto over = GoOverTheBed(in_force_mm, options.at_mm, client, result);
  if (!over) return std::nullopt;
  const std::vector<double> heights_mm = HeightsFrom_mm(in_force_mm, over->mesh_mm);
  SwitchOffsetGap gap;
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    const SwitchOffsetGap* const above =
        options.is_as_published || i == 0 ? nullptr : &gap;
    const auto next = GapAt(heights_mm[i], above, client, hands, result);
    if (!next) return std::nullopt;
    gap = *next;
    if (i + 1 == heights_mm.size()) break;
    const double down_mm = heights_mm[i] - heights_mm[i + 1];
    if (gap.gap_mm - down_mm < kTooNear_mm) {
      result->messages.push_back(
          fmt::format("Z{} is left out: it would end on the bed", heights_mm[i + 1]));
      break;
    }
  }
  // A mesh may fade with height: as it is where the last gap was measured.
  const double mesh_mm = client->HeightsNow().value_or(*over).mesh_mm;
  client->Say(fmt::format("G0 Z{}", heights_mm.front()));
  if (options.is_as_published) return gap.off_mm();
  TellMesh(mesh_mm, result);
  return gap.off_mm() - mesh_mm;
}

/// What a descent goes by: the offset in force less the mean of the calibrations, and
/// how much one of them scatters.
struct Footing {
  double beyond_mean_mm = 0;
  double sd_mm = 0;
  int count = 1;
};

// As published: the calibration that is there.
std::optional<Footing> AsItStands(ZStationClient* client, ProcedureResult* result) {
  std::string why;
  if (client->is_spoilt()) {
    why = "Z was homed after CALIBRATE_Z: run z_calibration again first";
  } else if (!client->is_calibrated() || !client->last()) {
    why = "there is no offset to go by: run z_calibration first";
  } else if (const auto base_mm = client->GcodeBase_mm();
             base_mm &&
             std::abs(*base_mm - client->last()->offset_mm) > kPrintedHeights_mm) {
    why = fmt::format(
        "the offset in force is {:.6f}, CALIBRATE_Z had {:.6f}: somebody "
        "adjusted it, run z_calibration again first",
        *base_mm,
        client->last()->offset_mm);
  }
  if (why.empty()) return Footing{};
  FailZStation({.reply = why}, result);
  return std::nullopt;
}

// Wiped, and calibrated several times.
std::optional<Footing> Calibrated(ZStationClient* client,
                                  const SwitchOffsetOptions& options,
                                  const FeelerHands& hands,
                                  ProcedureResult* result) {
  if (!hands.wipe()) {
    FailZStation(
        {.reply = "nobody wiped the nozzle: plastic on it looks like switch_offset"},
        result);
    return std::nullopt;
  }
  std::vector<double> offsets_mm;
  ProcedureResult one;
  for (int i = 0; i < options.calibrations; ++i) {
    one = RunZCalibration(client, options.in_force_mm);
    if (one.ending != Ending::kDone) break;
    offsets_mm.push_back(client->last()->offset_mm);
  }
  result->messages = one.messages;
  result->steps = one.steps;
  result->ending = one.ending;
  result->fault = one.fault;
  if (one.ending != Ending::kDone) return std::nullopt;
  if (client->is_spoilt()) {
    FailZStation({.reply = "its own macros home Z: this calibration holds nothing"},
                 result);
    return std::nullopt;
  }
  return Footing{.beyond_mean_mm = offsets_mm.back() - Mean(offsets_mm),
                 .sd_mm = Scatter(offsets_mm),
                 .count = options.calibrations};
}

// One reading in whole leaves, however often it is taken: heights are multiples too.
Uncertain Told(double value_mm, const Footing& footing) {
  const auto count = static_cast<double>(footing.count);
  return WithBudget(value_mm,
                    {{.input = "scatter of the calibrations",
                      .u = footing.sd_mm / std::sqrt(count),
                      .dof = std::max(1.0, count - 1)},
                     {.input = "steps of the machine", .u = kMachine_mm},
                     {.input = "feeler gauge's step",
                      .u = kFeelerStep_mm / std::sqrt(12.0),
                      .is_rectangular = true}});
}

}  // namespace

ProcedureResult RunSwitchOffset(ZStationClient* client,
                                const SwitchOffsetOptions& options,
                                const FeelerHands& hands) {
  ProcedureResult result;
  const auto footing = options.is_as_published
                           ? AsItStands(client, &result)
                           : Calibrated(client, options, hands, &result);
  if (!footing) return result;
  const double in_force_mm =
      options.in_force_mm.value_or(client->last()->SwitchOffset_mm());
  const auto wider_mm = Descend(in_force_mm, options, client, hands, &result);
  if (!wider_mm) return result;
  // A nozzle that hangs too high needs a greater switch_offset; what the last
  // calibration was higher than their mean is none of it.
  const double should_mm = in_force_mm + *wider_mm - footing->beyond_mean_mm;
  Uncertain told = Told(should_mm, *footing);
  if (options.is_as_published) {
    // What hangs under the nozzle is in it, and nobody knows how much.
    told.sd = 0;
    told.budget = {};
    result.observability.push_back(
        {.statement = "switch_offset + ooze only: a nozzle that is wiped before it is "
                      "calibrated tells them (variant: corrected)",
         .blind_direction = {{"ooze", std::sqrt(0.5)},
                             {"switch_offset", -std::sqrt(0.5)}}});
  }
  result.estimates.push_back({.name = "switch_offset",
                              .unit = "mm",
                              .value = told.value,
                              .sd = told.sd,
                              .identifiable = true,
                              .budget = told.budget});
  result.messages.push_back(
      fmt::format("switch_offset {:.3f} should be {:.3f}", in_force_mm, should_mm));
  if (should_mm < 0) {
    result.messages.push_back(
        {"Klipper takes none below 0: does the body of the switch touch as it should?",
         Message::Kind::kToDo});
  }
  return result;
}

}  // namespace caltwin
