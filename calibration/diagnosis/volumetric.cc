#include "calibration/diagnosis/volumetric.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/as_found.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/settings_of_rows.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/effects/map_table.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr int kPoses = 300;
constexpr double kChanged_sds = 2;
constexpr double kMostTerms = 12;  // Of a table: what the search fits it by.

bool IsMotion(const Injected& effect) {
  if (EffectAt(effect.effect).bucket != Bucket::kMotion) return false;
  const std::string_view channel = WordsOf(effect.axis).channel;
  return effect.effect != EffectIndex<UnknownMap>() || DriveNamed(channel);
}

// Motion at every pose, three numbers each, less their mean.
using Field = Eigen::Matrix3Xd;

Field Centred(Field field) {
  field.colwise() -= field.rowwise().mean().eval();
  return field;
}

double Rms_mm(const Field& field) {
  return std::sqrt(field.colwise().squaredNorm().mean());
}

class Volume {
 public:
  /// `as_drawn`: where the firmware's steps/mm were those of the drawing.
  Volume(const Observed& observed, std::uint64_t seed, bool as_drawn = false)
      : machine_(observed.machine()) {
    Settings settings = SettingsOfRows(observed);
    for (const Axis axis : kAxes) {
      const auto i = static_cast<std::size_t>(Index(axis));
      if (as_drawn) settings.steps_per_mm[i] = machine_.axis(axis).steps_per_mm();
    }
    Rng rng(seed, 0, "volumetric");
    const auto n = static_cast<double>(observed.num_rows());
    for (int k = 0; k < kPoses; ++k) {
      At at = observed.at(static_cast<Eigen::Index>(rng.Uniform() * n));
      at.kind = RowKind::kPosition;
      at.probe_off_mm.setZero();
      at.since_rev_mm.setConstant(kUnknown);
      placed_.push_back(
          DiagnosedAs(machine_).PoseAnywhere(observed, settings, &rng, &at));
      poses_.push_back(at);
    }
  }

  Field Motion_mm(const std::vector<Injected>& effects) const {
    Field field(3, kPoses);
    for (int k = 0; k < kPoses; ++k) {
      field.col(k) =
          ErrorsAt<double>(machine_, poses_[static_cast<std::size_t>(k)], effects)
              .motion_mm;
    }
    return field;
  }

 private:
  const Machine& machine_;
  std::vector<At> poses_{};
  std::vector<std::shared_ptr<const void>> placed_{};  ///< What poses point into.
};

// What the baseline line would be had nothing been fitted.
double Believed(const BaselineLine& line, const Observed& observed) {
  const std::string_view name(line.name);
  if (!name.starts_with("scale.")) return 0;
  const auto drive = DriveIndex(observed.machine().kind->drive_map(),
                                name.substr(name.find('.') + 1, 1));
  if (!drive) return 0;
  const auto k = static_cast<std::size_t>(*drive);
  const double set = SettingsOfRows(observed).steps_per_mm[k];
  return set > 0 ? PpmFromFraction(set / observed.machine().axes[k].steps_per_mm() - 1)
                 : 0;
}

bool IsMotion(const BaselineLine& line) {
  return line.name.starts_with("scale.") || line.name.starts_with("backlash.");
}

// How far each parameter's standard deviation moves the tool, summed in squares.
class Left {
 public:
  Left(const Volume& volume, const Field& as_found)
      : volume_(volume), as_found_(as_found) {}
  void Add(const std::vector<Injected>& by_one_sd) {
    const double rms_mm = Rms_mm(Centred(volume_.Motion_mm(by_one_sd) - as_found_));
    square_mm2_ += rms_mm * rms_mm;
  }
  // A table's own: sigma^2 terms / rows.
  void AddTable(const Finding& finding, double noise_mm) {
    const double terms =
        std::min(kMostTerms, static_cast<double>(finding.map->values_um.size()));
    square_mm2_ += noise_mm * noise_mm * terms / std::max(finding.rows, 1);
  }
  // What positions left out say that a table misses between its places.
  void AddBetween(const GainFigures& gain) {
    if (gain.positions.groups == 0) return;
    const double missed_mm2 =
        std::pow(gain.positions.after_mm, 2) - std::pow(gain.noise_floor_mm, 2);
    square_mm2_ += std::max(missed_mm2, 0.0);
  }
  double rms_mm() const { return std::sqrt(square_mm2_); }

 private:
  const Volume& volume_;
  const Field& as_found_;
  double square_mm2_ = 0;
};

struct Lines {
  std::vector<BaselineLine> changed{};
  std::vector<Injected> effects{};
};

Lines ChangedLines(const Observed& observed, const Diagnosis& diagnosis) {
  Lines lines{.effects = observed.effects()};
  for (const BaselineLine& line : diagnosis.baseline) {
    const double change = std::abs(line.value - Believed(line, observed));
    // Nor is what these rows leave open, whose sd is not known.
    if (!IsMotion(line) || !(change > kChanged_sds * line.sd)) continue;
    if (BuildIn(line, observed.machine(), &lines.effects))
      lines.changed.push_back(line);
  }
  return lines;
}

}  // namespace

std::optional<VolumetricGain> VolumetricGainOf(const Observed& observed,
                                               const Diagnosis& diagnosis,
                                               std::uint64_t seed) {
  const Lines lines = ChangedLines(observed, diagnosis);
  std::vector<Injected> all = lines.effects;
  std::vector<std::pair<const Finding*, std::size_t>> moving;
  for (const Finding& finding : diagnosis.findings) {
    const auto effect = EffectOf(finding);
    if (!effect || !IsMotion(*effect)) continue;
    moving.emplace_back(&finding, all.size());
    all.push_back(*effect);
  }
  if (moving.empty()) return std::nullopt;
  const Volume volume(observed, seed);
  const Field as_found = volume.Motion_mm(all);
  const Field found = Centred(as_found - volume.Motion_mm(lines.effects));
  Left left(volume, as_found);
  for (const BaselineLine& line : lines.changed) {
    std::vector<Injected> moved = all;
    BaselineLine by_one_sd = line;
    by_one_sd.value = Believed(line, observed) + line.sd;
    if (BuildIn(by_one_sd, observed.machine(), &moved)) left.Add(moved);
  }
  const bool has_table =
      std::ranges::any_of(moving, [](const auto& each) { return !each.first->effect; });
  if (has_table) left.AddBetween(diagnosis.gain);
  for (const auto& [finding, at] : moving) {
    if (!finding->effect) left.AddTable(*finding, diagnosis.gain.noise_floor_mm);
    for (std::size_t p = 0; finding->effect && p < finding->sds.size(); ++p) {
      if (!std::isfinite(finding->sds[p])) continue;
      std::vector<Injected> moved = all;
      moved[at].values[p] += finding->sds[p];
      left.Add(moved);
    }
  }
  // What the model holds already is no error of its own; wrong steps/mm are one.
  const Field modelled =
      Volume(observed, seed, /*as_drawn=*/true).Motion_mm(observed.effects());
  return VolumetricGain{.poses = kPoses,
                        .before_mm = Rms_mm(Centred(as_found - modelled)),
                        .after_mm = left.rms_mm(),
                        .findings_mm = Rms_mm(found),
                        .findings_max_mm = found.colwise().norm().maxCoeff()};
}

nlohmann::ordered_json VolumetricJson(const std::optional<VolumetricGain>& gain) {
  if (!gain) return nullptr;
  return {{"rms_um_before", UmFromMm(gain->before_mm)},
          {"rms_um_after", UmFromMm(gain->after_mm)},
          {"findings_rms_um", UmFromMm(gain->findings_mm)},
          {"findings_max_um", UmFromMm(gain->findings_max_mm)},
          {"poses", gain->poses}};
}

std::string VolumetricText(const std::optional<VolumetricGain>& gain) {
  if (!gain) return "";
  return fmt::format(
      "At {} poses in the travel that nobody measured the tool is off by {:.1f} um "
      "rms; "
      "corrected by what was found, {:.1f}, as far as its standard deviations tell "
      "(the "
      "findings alone move it by {:.1f} um rms, {:.1f} at most).\n",
      gain->poses,
      UmFromMm(gain->before_mm),
      UmFromMm(gain->after_mm),
      UmFromMm(gain->findings_mm),
      UmFromMm(gain->findings_max_mm));
}

}  // namespace caltwin
