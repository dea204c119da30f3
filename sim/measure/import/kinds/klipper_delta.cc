#include "sim/measure/import/kinds/klipper_delta.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_mesh.h"

namespace caltwin {
namespace {

constexpr std::string_view kSection = "delta_calibrate";
constexpr int kMost = 999;
constexpr double kFarthest_steps = 1e8;
constexpr double kHighest_mm = 1000;

/// Counts of the three towers; a fault where they are not three numbers in bounds.
std::optional<Vec3<double>> CountsOf(const PrinterCfg& cfg,
                                     const std::string& key,
                                     const Place& beside,
                                     Faults* faults) {
  const CfgSetting* setting = cfg.Find(kSection, key);
  if (setting == nullptr) {
    faults->Add(beside,
                fmt::format("[{}] {} is missing", kSection, key),
                "every height and distance has the counts of its three towers");
    return std::nullopt;
  }
  const auto numbers = cfg.Numbers(kSection, key, 3, faults);
  if (!numbers) return std::nullopt;
  const bool is_near = std::ranges::all_of(
      *numbers, [](double count) { return std::abs(count) < kFarthest_steps; });
  if (!is_near) {
    faults->Add(PlaceOf(setting->value, cfg.name()),
                fmt::format("[{}] {}: more than 1e8 steps", kSection, key));
    return std::nullopt;
  }
  return Vec3<double>((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

/// Calls `take(place, number, counts of each key)` for prefix0, prefix1, ...
template <typename Take>
void ForEach(const PrinterCfg& cfg,
             const std::string& prefix,
             const std::vector<std::string>& suffixes,
             Faults* faults,
             const Take& take) {
  for (int i = 0; i < kMost; ++i) {
    const std::string key = fmt::format("{}{}", prefix, i);
    const CfgSetting* setting = cfg.Find(kSection, key);
    if (setting == nullptr) return;
    const Place place = PlaceOf(setting->value, cfg.name());
    const auto number = cfg.Number(kSection, key, -kHighest_mm, kHighest_mm, faults);
    std::vector<Vec3<double>> counts;
    for (const std::string& suffix : suffixes) {
      const auto one = CountsOf(cfg, key + suffix, place, faults);
      if (one) counts.push_back(*one);
    }
    if (number && counts.size() == suffixes.size()) take(place, *number, counts);
  }
}

Vec3<double> StepsOf(const KlipperGeometry& geometry) {
  return {
      geometry.drive[0].step_mm, geometry.drive[1].step_mm, geometry.drive[2].step_mm};
}

void ReadTouches(const PrinterCfg& cfg, KlipperCalibration* read, Faults* faults) {
  for (const bool is_manual : {false, true}) {
    ForEach(cfg,
            is_manual ? "manual_height" : "height",
            {"_pos"},
            faults,
            [&](const Place& place, double height_mm, const auto& counts) {
              read->touches.push_back({.counts = counts[0],
                                       .height_mm = height_mm,
                                       .is_manual = is_manual,
                                       .place = place});
            });
  }
  ForEach(cfg,
          "distance",
          {"_pos1", "_pos2"},
          faults,
          [&](const Place& place, double length_mm, const auto& counts) {
            if (length_mm <= 0) {
              faults->Add(place, fmt::format("a distance of {:g} mm", length_mm));
              return;
            }
            read->distances.push_back(
                {.length_mm = length_mm, .from_mm = counts[0], .to_mm = counts[1]});
          });
}

void RequireSteps(const KlipperCalibration& read, const PrinterCfg& cfg) {
  for (int i = 0; i < kNumTowers; ++i) {
    if (Known(read.geometry.drive[static_cast<std::size_t>(i)].step_mm)) continue;
    const double likely_mm = LikelyStep_mm(read.geometry, read.touches);
    throw InputError(
        cfg.PlaceOfSection("stepper_" + TowerName(i)),
        fmt::format("the motor step of tower {} is not stated: counts are not lengths",
                    TowerName(i)),
        fmt::format(
            "rotation_distance and microsteps (or step_distance) are missing. "
            "Give the step yourself with --step-mm{}",
            likely_mm > 0
                ? fmt::format(": the touch nearest to the middle suggests {:.3g}, if "
                              "the saved endstops are those of the touches",
                              likely_mm)
                : ""));
  }
}

// People change microsteps and keep what was saved: a power of two of the step, by the
// touch nearest to the middle.
double StepFactorOf(const KlipperCalibration& read) {
  constexpr double kAlike = 0.05;
  const double ratio =
      LikelyStep_mm(read.geometry, read.touches) / read.geometry.drive[0].step_mm;
  if (!(ratio > 0)) return 1;
  const double factor = std::exp2(std::round(std::log2(ratio)));
  return std::abs(ratio / factor - 1) < kAlike ? factor : 1;
}

/// Turns counts into travel, and refuses what the saved geometry cannot reach.
void Convert(KlipperCalibration* read, Faults* faults) {
  const Vec3<double> steps_mm = read->step_factor * StepsOf(read->geometry);
  for (KlipperTouch& touch : read->touches) {
    touch.motors_mm = touch.counts.cwiseProduct(steps_mm);
    if (!DeltaNozzle_mm(read->geometry.model, touch.motors_mm).allFinite()) {
      faults->Add(touch.place,
                  "the saved geometry cannot stand there: its arms do not meet",
                  "the motor step, or the geometry, is another machine's");
    }
  }
  for (KlipperDistance& distance : read->distances) {
    distance.from_mm = distance.from_mm.cwiseProduct(steps_mm).eval();
    distance.to_mm = distance.to_mm.cwiseProduct(steps_mm).eval();
  }
}

Row RowOf(const KlipperTouch& touch, const KlipperGeometry& geometry) {
  const Vec3<double> nozzle_mm = DeltaNozzle_mm(geometry.model, touch.motors_mm);
  const Vec3<double> motors_mm =
      DeltaMotors_mm<double>(geometry.model, {nozzle_mm[0], nozzle_mm[1], 0});
  Row row{.campaign = touch.is_manual ? "manual_heights" : "delta_calibrate",
          .kind = RowKind::kTouch,
          .setup = "bed",
          .settings = "saved",
          .place = touch.place};
  row.cmd_mm = {nozzle_mm[0], nozzle_mm[1], 0};
  row.motor_mm = {motors_mm[0], motors_mm[1], motors_mm[2]};
  row.dir[2] = -1;
  row.motor_dir = {1, 1, 1};
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = nozzle_mm[2] - touch.height_mm;
  row.extra = {fmt::format("{:g}", touch.height_mm),
               fmt::format("{:.3f}", touch.counts[0]),
               fmt::format("{:.3f}", touch.counts[1]),
               fmt::format("{:.3f}", touch.counts[2])};
  return row;
}

void Explain(const KlipperCalibration& read, Imported* imported) {
  const DeltaModel<double>& model = read.geometry.model;
  imported->recognised = {
      fmt::format("a saved delta calibration: {} touches, {} distances on a print",
                  read.touches.size(),
                  read.distances.size()),
      fmt::format("saved: delta radius {:.6f}, arms {:.6f} {:.6f} {:.6f}, endstops "
                  "{:.6f} {:.6f} {:.6f} mm, angles {:.6f} {:.6f} {:.6f} deg",
                  model.radius_mm[0],
                  model.arm_mm[0],
                  model.arm_mm[1],
                  model.arm_mm[2],
                  model.endstop_mm[0],
                  model.endstop_mm[1],
                  model.endstop_mm[2],
                  DegFromRad(model.angle_rad[0]),
                  DegFromRad(model.angle_rad[1]),
                  DegFromRad(model.angle_rad[2])),
      fmt::format("a motor step is {:g} mm", read.geometry.drive[0].step_mm)};
  const double microsteps = read.geometry.drive[0].microsteps;
  if (read.step_factor != 1) {
    imported->warnings.push_back(fmt::format(
        "the saved counts are of other microsteps than the file has{}: they were "
        "changed since, and the travel is reckoned with those of the counts. Put them "
        "back, or run DELTA_CALIBRATE again: Klipper would take the counts for lengths "
        "{:g} times {}",
        Known(microsteps)
            ? fmt::format(
                  " ({:g} in place of {:g})", microsteps / read.step_factor, microsteps)
            : "",
        std::max(read.step_factor, 1 / read.step_factor),
        read.step_factor < 1 ? "as long" : "as short"));
  }
  imported->assumed = read.geometry.assumed;
  imported->assumed.emplace_back(
      "value = height by the saved geometry - height at the trigger; motor_ is the "
      "travel to the nominal point on the bed, counts stand in columns of their own");
  imported->assumed.emplace_back(
      "the saved geometry may be newer than the touches: then it has been moved by "
      "hand "
      "or fitted to others");
}

DataHeader HeaderOf(const KlipperGeometry& geometry, const std::string& machine) {
  DataHeader header{.machine = machine};
  for (int i = 0; i < kNumTowers; ++i) {
    const KlipperDrive& drive = geometry.drive[static_cast<std::size_t>(i)];
    header.settings["saved"].steps_per_mm[TowerName(i)] = 1 / drive.step_mm;
    Transmission& transmission = header.transmission[TowerName(i)];
    if (Known(drive.rotation_distance_mm)) {
      transmission.pulley_mm_per_rev = drive.rotation_distance_mm;
      transmission.full_steps_per_mm = drive.full_steps_per_mm;
    }
  }
  if (!Known(geometry.drive[0].rotation_distance_mm)) header.transmission.clear();
  return header;
}

}  // namespace

double LikelyStep_mm(const KlipperGeometry& geometry,
                     const std::vector<KlipperTouch>& touches) {
  double spread = 0, step_mm = kUnknown;
  for (const KlipperTouch& touch : touches) {
    const double mean = touch.counts.mean();
    const double uneven = touch.counts.maxCoeff() - touch.counts.minCoeff();
    if (mean <= 0 || (Known(step_mm) && uneven >= spread)) continue;
    spread = uneven;
    step_mm = (geometry.model.endstop_mm[0] - touch.height_mm) / mean;
  }
  return step_mm;
}

KlipperCalibration ReadKlipperCalibration(const std::string& text,
                                          const std::string& name,
                                          const ImportOptions& options) {
  const PrinterCfg cfg(text, name);
  Faults faults;
  KlipperCalibration read;
  ReadTouches(cfg, &read, &faults);
  if (read.touches.empty() && faults.empty()) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no saved delta calibration stands here",
                     "it is the block that SAVE_CONFIG writes after DELTA_CALIBRATE: "
                     "#*# [delta_calibrate] with height0, height0_pos and so on");
  }
  const auto geometry = ReadKlipperGeometry(cfg, options.step_mm, &faults);
  faults.ThrowIfAny();
  read.geometry = *geometry;
  RequireSteps(read, cfg);
  if (!options.step_mm) read.step_factor = StepFactorOf(read);
  Convert(&read, &faults);
  faults.ThrowIfAny();
  return read;
}

Imported ReadKlipperDelta(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options) {
  const KlipperCalibration read = ReadKlipperCalibration(text, name, options);
  Imported imported;
  imported.table.extra_columns = {"height_mm", "count_a", "count_b", "count_c"};
  for (const KlipperTouch& touch : read.touches) {
    imported.table.rows.push_back(RowOf(touch, read.geometry));
    if (!options.campaign.empty())
      imported.table.rows.back().campaign = options.campaign;
  }
  const std::string machine = MachineNameOf(name);
  imported.machine_yaml =
      DeltaMachineYaml({.source = std::filesystem::path(name).filename().string(),
                        .name = machine,
                        .model = read.geometry.model,
                        .drive = read.geometry.drive,
                        .print_radius_mm = read.geometry.print_radius_mm});
  imported.header = HeaderOf(read.geometry, "");
  Explain(read, &imported);
  return imported;
}

Imported ReadMeshesOfPrinter(const std::string& text,
                             const std::string& name,
                             const ImportOptions& options) {
  Imported imported = ReadKlipperMesh(text, name, options);
  if (text.find("#*# [delta_calibrate]") == std::string::npos) return imported;
  try {
    Imported saved = ReadKlipperDelta(text, name, options);
    imported.recognised.push_back(
        saved.recognised.front() +
        ", not among these rows: caltwin import klipper-delta reads it");
    imported.warnings.insert(
        imported.warnings.end(), saved.warnings.begin(), saved.warnings.end());
  } catch (const InputError&) {
    // Deltas that were never calibrated have meshes too.
  }
  return imported;
}

}  // namespace caltwin
