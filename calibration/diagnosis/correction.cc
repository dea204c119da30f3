#include "calibration/diagnosis/correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/correction_text.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/screw_table.h"
#include "calibration/diagnosis/settings_of_rows.h"
#include "calibration/diagnosis/unseen_rows.h"
#include "sim/base/units.h"
#include "sim/effects/predict.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// The drive that the axis' letter stands for in settings.
std::string DriveOf(Axis axis, const Observed& observed) {
  return DriveName(observed.machine().kind->drive_map(), Index(axis));
}

// Of the drive alone, or of several alike ("scale.ab").
const BaselineLine* ScaleOf(Axis axis,
                            const Diagnosis& diagnosis,
                            const Observed& observed) {
  for (const BaselineLine& line : diagnosis.baseline) {
    const std::string_view name(line.name);
    if (!name.starts_with("scale.")) continue;
    if (name.substr(name.find('.')).find(DriveOf(axis, observed)) != name.npos) {
      return &line;
    }
  }
  return nullptr;
}

const Finding* Found(std::string_view cause,
                     std::string_view axis,
                     const Diagnosis& diagnosis) {
  for (const Finding& finding : diagnosis.findings) {
    if (finding.cause == cause && finding.axis == axis && finding.effect) {
      return &finding;
    }
  }
  return nullptr;
}

// What a belt of another pitch adds to what all do alike.
const Finding* PitchOf(Axis axis,
                       const Diagnosis& diagnosis,
                       const Observed& observed) {
  return Found("belt_pitch", DriveOf(axis, observed), diagnosis);
}

class Writer {
 public:
  Writer(ControllerKind controller,
         const Diagnosis& diagnosis,
         const Observed& observed,
         std::string name)
      : controller_(controller),
        name_(std::move(name)),
        diagnosis_(diagnosis),
        observed_(observed),
        out_(controller, diagnosis) {}

  std::vector<CorrectionFile> Make() {
    for (const Axis axis : kAxes) AddAxis(axis);
    AddSquareness();
    if (controller_ == ControllerKind::kKlipper) AddTwist();
    for (const Finding& finding : diagnosis_.findings) {
      if (!carried_.contains(&finding)) out_.LeaveOver(finding);
    }
    files_.insert(files_.begin(), {.text = out_.text()});
    return files_;
  }

 private:
  void AddAxis(Axis axis) {
    const bool has_table = controller_ == ControllerKind::kLinuxCnc && HasShape(axis);
    const BaselineLine* scale = ScaleOf(axis, diagnosis_, observed_);
    const BaselineLine* gap = out_.Fitted("backlash." + DriveOf(axis, observed_));
    if (controller_ == ControllerKind::kLinuxCnc && (scale || gap || has_table)) {
      out_.Add(fmt::format("[JOINT_{}]\n", Index(axis)));
    }
    if (controller_ == ControllerKind::kKlipper && scale) {
      out_.Add(fmt::format("[stepper_{}]\n", Name(axis)));
    }
    if (scale) AddScale(axis, *scale);
    if (has_table) {
      AddTable(axis);
    } else if (gap) {
      out_.SetPlay(CapitalLetter(axis), *gap);
    }
  }

  // Moves too far by s: steps/mm / (1 + s).
  void AddScale(Axis axis, const BaselineLine& scale) {
    const Finding* pitch = PitchOf(axis, diagnosis_, observed_);
    const double scale_ppm = out_.IsToBeSet(scale) ? scale.value : 0;
    if (pitch == nullptr && scale_ppm == 0) return;
    const double belt_ppm = pitch == nullptr ? 0 : pitch->effect->values[0];
    if (pitch != nullptr) carried_.insert(pitch);
    const auto i = static_cast<std::size_t>(Index(axis));
    const AxisDrawing& drawing = observed_.machine().axis(axis);
    const double set = SettingsOfRows(observed_).steps_per_mm[i];
    const double old = set > 0 ? set : drawing.steps_per_mm();
    std::string source =
        fmt::format("{} {:+.1f} +- {:.1f} ppm", scale.name, scale.value, scale.sd);
    if (pitch != nullptr) {
      source += fmt::format(", belt_pitch.{} {:+.1f} ppm", pitch->axis, belt_ppm);
    }
    out_.SetSteps(CapitalLetter(axis),
                  old,
                  (scale_ppm + belt_ppm) * 1e-6,
                  drawing.full_steps_per_rev * drawing.microsteps,
                  source);
  }

  // Acts along its own axis by position (and sense) alone, so a screw table holds it.
  static std::optional<Axis> ShapeAxis(const Finding& finding) {
    constexpr std::array<std::string_view, 4> kCauses = {
        "cyclic_lead", "pulley_eccentric", "pitch_progressive", "backlash_worn"};
    const auto axis = AxisNamed(finding.axis);
    if (!axis) return std::nullopt;
    if (finding.effect && std::ranges::find(kCauses, finding.cause) != kCauses.end()) {
      return axis;
    }
    const bool is_table = finding.map && finding.map->knots.size() == 1 &&
                          finding.map->covariates[0] == finding.axis;
    return is_table ? axis : std::nullopt;
  }
  bool HasShape(Axis axis) const {
    return std::ranges::any_of(diagnosis_.findings, [&](const Finding& finding) {
      return ShapeAxis(finding) == axis;
    });
  }

  static Injected EffectOf(const Finding& finding) {
    if (finding.effect) return *finding.effect;
    return {.effect = EffectIndex<PitchMap>(),
            .axis = finding.axis,
            .values = FlatMap(finding.map->values_um, finding.map->knots)};
  }

  void AddTable(Axis axis) {
    std::vector<Injected> effects;
    std::vector<std::string> sources;
    for (const Finding& finding : diagnosis_.findings) {
      if (ShapeAxis(finding) != axis) continue;
      const std::string name = fmt::format("{}.{}", finding.cause, finding.axis);
      carried_.insert(&finding);
      const UnseenRows unseen = WhatUnseenRowsSay(finding, diagnosis_.gain);
      if (!unseen.worse.empty())
        out_.Comment(fmt::format("{}: {}", name, unseen.worse));
      if (!unseen.is_recommended) continue;
      const Machine& machine = observed_.machine();
      if (ScrewTablePoints(machine, axis, {EffectOf(finding)}) == 0) {
        out_.Comment(
            fmt::format("{}: its wave needs more than the {} points that a screw "
                        "table of this travel has; it stays",
                        name,
                        kMostScrewTablePoints));
        continue;
      }
      effects.push_back(EffectOf(finding));
      sources.push_back(name);
    }
    const BaselineLine* gap = out_.Fitted("backlash." + Name(axis));
    if (effects.empty()) {
      if (gap) out_.SetPlay(CapitalLetter(axis), *gap);
      return;
    }
    if (gap) sources.push_back("backlash." + Name(axis));
    const std::string suffix = ScrewTableSuffix(axis);
    files_.push_back(
        {suffix,
         ScrewTableText(observed_.machine(), axis, effects, gap ? gap->value : 0)});
    out_.Add("COMP_FILE_TYPE = 0\n");
    out_.Set(fmt::format("COMP_FILE = {}{}", name_, suffix),
             fmt::format("mm, nominal, actual forwards, actual backwards; {}",
                         fmt::join(sources, " and ")));
  }

  // The tool goes by this times the other axis's travel: the slope of x on y, of x on
  // z, of y on z.
  void AddSquareness() {
    struct Pair {
      std::string_view axis;
      double sign;
    };
    constexpr std::array<Pair, 3> kPairs = {{{"C0Y", -1}, {"B0Z", 1}, {"A0Z", -1}}};
    std::array<double, 3> slopes{};
    std::vector<std::string> sources;
    std::vector<const Finding*> used;
    for (std::size_t i = 0; i < 3; ++i) {
      const Finding* finding = Found("squareness", kPairs[i].axis, diagnosis_);
      if (finding == nullptr) continue;
      slopes[i] = kPairs[i].sign * RadFromMrad(finding->effect->values[0]);
      sources.push_back(fmt::format("squareness.{} {:+.4f} +- {:.4f} mrad",
                                    finding->axis,
                                    finding->effect->values[0],
                                    finding->sds.empty() ? 0 : finding->sds[0]));
      used.push_back(finding);
    }
    // A turned beam is, beside a turned whole, Y turned the other way.
    if (const Finding* racked = Found("racking", "", diagnosis_)) {
      slopes[0] += RadFromMrad(racked->effect->values[0]);
      sources.push_back(fmt::format("racking {:+.4f} mrad", racked->effect->values[0]));
      used.push_back(racked);
    }
    if (used.empty() || controller_ == ControllerKind::kLinuxCnc) return;
    carried_.insert(used.begin(), used.end());
    const std::string source = fmt::format("{}", fmt::join(sources, ", "));
    const auto [xy, xz, yz] = slopes;
    constexpr double kHeight_mm = 100;
    if (controller_ == ControllerKind::kRrf) {
      out_.Set(fmt::format("M556 S{:g} X{:.4f} Y{:.4f} Z{:.4f}",
                           kHeight_mm,
                           -kHeight_mm * xy,
                           -kHeight_mm * yz,
                           -kHeight_mm * xz),
               fmt::format("mm over {:g} mm, {}", kHeight_mm, source));
    } else if (controller_ == ControllerKind::kMarlin) {
      out_.Set(fmt::format("M852 I{:.7f} J{:.7f} K{:.7f}", xy, xz, yz),
               "mm/mm, " + source);
    } else {
      // The first has the module loaded, the second is a profile of it.
      out_.Add("[skew_correction]\n[skew_correction caltwin]\n");
      out_.Set(
          fmt::format("xy_skew: {:.7f}\nxz_skew: {:.7f}\nyz_skew: {:.7f}", xy, xz, yz),
          "mm/mm, load with SKEW_PROFILE LOAD=caltwin; " + source);
    }
  }

  // How much lower a probe beside the nozzle reads because the beam is twisted.
  void AddTwist() {
    const Finding* finding = Found("axis_twist", "", diagnosis_);
    Vec3<double> off_mm = Vec3<double>::Zero();
    for (Eigen::Index i = 0; i < observed_.num_rows(); ++i) {
      const Vec3<double>& one_mm = observed_.at(i).probe_off_mm;
      if (std::abs(one_mm.y()) > std::abs(off_mm.y())) off_mm = one_mm;
    }
    if (finding == nullptr || off_mm.y() == 0) return;
    carried_.insert(finding);
    const AxisDrawing& x = observed_.machine().axis(Axis::kX);
    constexpr int kPoints = 3;
    std::vector<std::string> values;
    for (int k = 0; k < kPoints; ++k) {
      At at{.kind = RowKind::kPosition};
      at.q_mm.x() = x.min_mm + x.travel_mm() * k / (kPoints - 1);
      at.probe_off_mm = off_mm;
      const auto errors =
          ErrorsAt<double>(observed_.machine(), at, std::span(&*finding->effect, 1));
      values.push_back(fmt::format("{:.5f}", errors.motion_mm.z()));
    }
    out_.Add(
        fmt::format("[axis_twist_compensation]\ncompensation_start_x: {:g}\n"
                    "compensation_end_x: {:g}\n",
                    x.min_mm,
                    x.max_mm));
    out_.Set(fmt::format("z_compensations: {}", fmt::join(values, ", ")),
             fmt::format("mm, added to what a probe at y {:+g} mm reads; axis_twist "
                         "{:+.4f} mrad",
                         off_mm.y(),
                         finding->effect->values[0]));
  }

  ControllerKind controller_;
  std::string name_;
  const Diagnosis& diagnosis_;
  const Observed& observed_;
  CorrectionText out_;
  std::vector<CorrectionFile> files_{};
  std::set<const Finding*> carried_{};
};

}  // namespace

std::vector<Axis> AxesOfNewSteps(const Diagnosis& diagnosis, const Observed& observed) {
  std::vector<Axis> axes;
  for (const Axis axis : kAxes) {
    const BaselineLine* scale = ScaleOf(axis, diagnosis, observed);
    const bool has_pitch = PitchOf(axis, diagnosis, observed) != nullptr;
    if (scale != nullptr && (has_pitch || CorrectionText::IsTold(*scale))) {
      axes.push_back(axis);
    }
  }
  return axes;
}

std::vector<CorrectionFile> CorrectionOfAxes(ControllerKind controller,
                                             const Diagnosis& diagnosis,
                                             const Observed& observed,
                                             const std::string& name) {
  return Writer(controller, diagnosis, observed, name).Make();
}

std::vector<CorrectionFile> CorrectionFor(ControllerKind controller,
                                          const Diagnosis& diagnosis,
                                          const Observed& observed,
                                          const std::string& name) {
  return DiagnosedAs(observed.machine())
      .Correction(controller, diagnosis, observed, name);
}

}  // namespace caltwin
