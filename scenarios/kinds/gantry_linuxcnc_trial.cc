#include "scenarios/kinds/gantry_linuxcnc_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/position_error.h"
#include "sim/base/units.h"
#include "sim/controllers/linuxcnc/config.h"
#include "sim/kinds/cartesian/linuxcnc.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;
constexpr double kSeen_mm = 0.002;
constexpr int kPlaces = 9;
/// From so far away a place is come to, and so far from its ends an axis is looked at.
constexpr double kRun_up_mm = 5, kMargin_mm = 10;

/// A place to go to; whether the tip is looked at there.
struct Stop {
  Vec3<double> at_mm;
  bool is_looked_at = false;
};

Vec3<double> Middle_mm(const Machine& machine) {
  Vec3<double> at_mm;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    // Well off the table.
    const double share = axis == Axis::kZ ? 0.8 : 0.5;
    at_mm[Index(axis)] = drawn.min_mm + share * drawn.travel_mm();
  }
  return at_mm;
}

// Places that are no round number of any table's, each from below and from above.
std::vector<Stop> Places(const Machine& machine) {
  constexpr double kOff = 0.37;
  const Vec3<double> middle_mm = Middle_mm(machine);
  std::vector<Stop> stops;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    const double travel_mm = drawn.travel_mm() - 2 * kMargin_mm;
    for (const double sense : {1.0, -1.0}) {
      for (int i = 0; i < kPlaces; ++i) {
        Vec3<double> at_mm = middle_mm;
        at_mm[Index(axis)] =
            drawn.min_mm + kMargin_mm + travel_mm * (i + kOff) / kPlaces;
        Vec3<double> from_mm = at_mm;
        from_mm[Index(axis)] -= sense * kRun_up_mm;
        stops.push_back({from_mm});
        stops.push_back({at_mm, /*is_looked_at=*/true});
      }
    }
  }
  return stops;
}

PlacesReached Summed(const std::vector<Vec3<double>>& errors_mm) {
  Vec3<double> mean_mm = Vec3<double>::Zero();
  for (const Vec3<double>& error_mm : errors_mm) mean_mm += error_mm;
  mean_mm /= static_cast<double>(errors_mm.size());
  double squares = 0, most_mm = 0;
  for (const Vec3<double>& error_mm : errors_mm) {
    const double off_mm = (error_mm - mean_mm).norm();
    squares += off_mm * off_mm;
    most_mm = std::max(most_mm, off_mm);
  }
  return {.zero_shift_mm = mean_mm.norm(),
          .rms_mm = std::sqrt(squares / static_cast<double>(errors_mm.size())),
          .p95_mm = P95AboutMean_mm(errors_mm),
          .most_mm = most_mm};
}

}  // namespace

GantryLinuxCncTrial::GantryLinuxCncTrial(Built built,
                                         std::uint64_t seed,
                                         std::unique_ptr<Board> board,
                                         const SteppedGantry* plant,
                                         UnderLinuxCnc asked)
    : LinuxCncTrial(built.machine, std::move(board), std::move(asked)),
      built_(std::move(built)),
      seed_(seed),
      plant_(plant) {}

PlacesReached GantryLinuxCncTrial::ReachedBefore() const {
  SteppedGantry machine(built_, seed_);
  std::vector<Vec3<double>> errors_mm;
  for (const Stop& stop : Places(built_.machine)) {
    Motors steps(3);
    for (const Axis axis : kAxes) {
      const auto i = static_cast<std::size_t>(Index(axis));
      steps[Index(axis)] =
          std::round((stop.at_mm[Index(axis)] - built_.machine.axis(axis).home_mm()) *
                     built_.machine.settings.steps_per_mm[i]);
    }
    machine.Follow(steps);
    if (stop.is_looked_at) errors_mm.push_back(machine.Tip_mm() - stop.at_mm);
  }
  return Summed(errors_mm);
}

std::optional<PlacesReached> GantryLinuxCncTrial::ReachedAfter() {
  constexpr std::chrono::minutes kPatience{10};
  // Whatever the lines before have left in force.
  if (!link()->Send("G21 G90 G40 G49 G80 G94", kPatience)) return std::nullopt;
  std::vector<Vec3<double>> errors_mm;
  const double safe_mm = Middle_mm(built_.machine)[Index(Axis::kZ)];
  if (!link()->Send(fmt::format("G53 G0 Z{:.6f}", safe_mm), kPatience)) {
    return std::nullopt;
  }
  for (const Stop& stop : Places(built_.machine)) {
    const std::string line = fmt::format(
        "G53 G0 X{:.6f} Y{:.6f} Z{:.6f}", stop.at_mm[0], stop.at_mm[1], stop.at_mm[2]);
    if (!link()->Send(line, kPatience)) return std::nullopt;
    if (stop.is_looked_at) errors_mm.push_back(plant_->Tip_mm() - stop.at_mm);
  }
  return Summed(errors_mm);
}

void GantryLinuxCncTrial::Finish(RunResult* result) {
  LinuxCncTrial::Finish(result);
  before_ = ReachedBefore();
  if (!link()->has_failed()) after_ = ReachedAfter();
}

TrueEnd GantryLinuxCncTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                 RunResult* result) {
  if (!after_) {
    result->messages.emplace_back(
        "LinuxCNC could not be sent anywhere at the end: how true its places are is "
        "not known");
    return {.told_wrong = true};
  }
  result->messages.push_back(fmt::format(
      "the tip is {:.1f} um (p95) from where LinuxCNC sends it, {:.1f} at most, but "
      "for a "
      "shift of the zero by {:.1f} um; with steps/mm alone it would be {:.1f} um",
      UmFromMm(after_->p95_mm),
      UmFromMm(after_->most_mm),
      UmFromMm(after_->zero_shift_mm),
      UmFromMm(before_->p95_mm)));
  return {.figure =
              TrueFigure{.before = before_->p95_mm,
                         .after = after_->p95_mm,
                         .noise = kSeen_mm,
                         .is_met = after_->p95_mm <=
                                   std::max(kRecovered * before_->p95_mm, kSeen_mm)}};
}

double GantryLinuxCncTrial::Figure(const std::string& name,
                                   const RunResult& /*result*/) {
  if (!after_) return std::numeric_limits<double>::quiet_NaN();
  if (name == "position_error_mm.p95") return after_->p95_mm;
  if (name == "position_error_mm.rms") return after_->rms_mm;
  if (name == "position_error_mm.most") return after_->most_mm;
  if (name == "zero_shift_mm") return after_->zero_shift_mm;
  return std::numeric_limits<double>::quiet_NaN();
}

std::unique_ptr<KindTrial> BeginGantryUnderLinuxCnc(const Scenario& scenario,
                                                    const Chance& chance) {
  const TwinConfig config = MakeTwinConfig(
      scenario,
      {.fidelity = chance.fidelity, .seed = chance.seed, .sample = chance.sample});
  const auto probe = config.instruments.find("probe");
  Machine machine = config.machine;
  machine.settings = config.settings;
  Built built{.machine = machine,
              .effects = config.effects,
              .probe_sigma_mm = probe == config.instruments.end()
                                    ? 0
                                    : MmFromUm(probe->second.sigma_um)};
  built.Prepare();
  UnderLinuxCnc asked = *scenario.linuxcnc;
  auto& files = asked.options.files;
  if (files.empty()) {
    files = linuxcnc::ConfigFiles(
        machine.name, LinuxCncJointsOfGantry(machine), "dummy", "caltwin");
  }
  files.insert(files.end(), asked.more_files.begin(), asked.more_files.end());
  auto plant = std::make_unique<SteppedGantry>(built, config.seed);
  const SteppedGantry* const seen = plant.get();
  auto board = std::make_unique<PlantBoard>(WiringOfGantry(machine), std::move(plant));
  return std::make_unique<GantryLinuxCncTrial>(
      std::move(built), config.seed, std::move(board), seen, std::move(asked));
}

}  // namespace caltwin
