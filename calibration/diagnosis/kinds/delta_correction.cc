#include "calibration/diagnosis/kinds/delta_correction.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/diagnosis/as_found.h"
#include "calibration/diagnosis/correction_text.h"
#include "calibration/diagnosis/extension.h"
#include "calibration/diagnosis/kinds/delta_lines.h"
#include "calibration/diagnosis/settings_of_rows.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

class DeltaWriter {
 public:
  DeltaWriter(ControllerKind controller,
              const Diagnosis& diagnosis,
              const Observed& observed)
      : controller_(controller),
        diagnosis_(diagnosis),
        observed_(observed),
        out_(controller, diagnosis),
        found_(DeltaWithBaseline(observed, diagnosis.baseline)),
        radius_mm_(DeltaOf(observed.machine()).print_radius_mm) {
    // Nought is where touches trigger: what gives way first is no height of the bed.
    found_.bed.height_mm -= observed.machine().probe.pretravel_mm;
    TurnBuild(observed.effects(), &found_.build);
    for (const Finding& finding : diagnosis.findings) {
      if (finding.effect) TurnBuild(std::span(&*finding.effect, 1), &found_.build);
    }
  }

  std::string Make() {
    out_.Comment("Built minus drawn, one by one; together they are known better:");
    for (const BaselineLine& line : diagnosis_.baseline) {
      if (KnobsOfLine(line.name, 0, DeltaOf(observed_.machine())).empty()) continue;
      out_.Comment(
          fmt::format("  {} {:+.4g} +- {:.2g} {}{}",
                      line.name,
                      line.value,
                      line.sd,
                      line.unit,
                      line.is_determined ? "" : ", not determined by these rows"));
    }
    SetBelts();
    if (IsGeometryTold()) {
      AddGeometry();
    } else {
      out_.Comment("geometry: not told from what the firmware has, nothing to set");
      if (controller_ == ControllerKind::kKlipper) out_.Add(WithBelts(""));
    }
    for (const Finding& finding : diagnosis_.findings) AddFinding(finding);
    return out_.text();
  }

 private:
  // Steps/mm of the towers whose belts are told, which are right then: what moves too
  // far by s gets steps/mm / (1 + s).
  void SetBelts() {
    const Settings settings = SettingsOfRows(observed_);
    const BaselineLine* scale = out_.Fitted("scale");
    const bool is_scale = scale != nullptr && CorrectionText::IsTold(*scale);
    std::string words;
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      const std::string tower = TowerName(static_cast<int>(i));
      const bool is_found =
          std::ranges::any_of(diagnosis_.findings, [&](const Finding& finding) {
            return finding.cause == "belt_pitch" && finding.axis == tower;
          });
      if (!is_scale && !is_found) continue;
      const AxisDrawing& drawing = observed_.machine().axes[i];
      const double set = settings.steps_per_mm[i];
      const double old = set > 0 ? set : drawing.steps_per_mm();
      steps_per_mm_[i] = old / (1 + found_.build.belt_scale[i]);
      words += fmt::format(" {}{:.7g}", "XYZ"[i], steps_per_mm_[i]);
      out_.Comment(
          fmt::format("steps/mm of tower {} were {:.6g}: its belt moves {:+.1f} ppm "
                      "too far",
                      tower,
                      old,
                      PpmFromFraction(found_.build.belt_scale[i])));
      found_.build.belt_scale[i] = 0;
    }
    if (!words.empty() && IsSetByGcode(controller_)) out_.Add("M92" + words + "\n");
  }

  // Whether any number of the geometry, or of the bed's plane that it has to follow, is
  // told from what the firmware has.
  bool IsGeometryTold() const {
    DeltaBuild<double> believed = DeltaOf(observed_.machine()).Build();
    believed.model = DeltaOf(observed_.machine()).settings;
    const DeltaBuild<double> drawn = DeltaOf(observed_.machine()).Build();
    const bool is_line =
        std::ranges::any_of(diagnosis_.baseline, [&](const BaselineLine& line) {
          const auto turns = KnobsOfLine(line.name, 1, DeltaOf(observed_.machine()));
          if (turns.empty() || line.name == "scale") return false;
          return CorrectionText::IsTold(
              line, KnobValue(turns[0].knob, believed, {}, drawn) / turns[0].by);
        });
    return is_line || std::ranges::any_of(diagnosis_.findings, TurnsGeometry);
  }

  static bool TurnsGeometry(const Finding& finding) {
    return finding.effect && finding.cause != "belt_pitch" &&
           !TurnsOf(*finding.effect).empty();
  }

  void AddGeometry() {
    const DeltaDrawing& delta = DeltaOf(observed_.machine());
    const DeltaModel<double> best = BestDeltaSettings(found_.build,
                                                      found_.bed,
                                                      delta.settings,
                                                      radius_mm_,
                                                      {.has_radius_per_tower = false});
    const auto off = [&](const DeltaModel<double>& settings) {
      return DeltaAccuracyOf(found_.build, found_.bed, settings, radius_mm_);
    };
    const DeltaAccuracy before = off(delta.settings), after = off(best);
    out_.Comment(
        fmt::format("heights over the bed, {:g} mm around: {:.1f} um rms off with "
                    "the settings of the machine file, {:.1f} with these; sizes "
                    "{:+.2f} and {:+.2f} um/mm, as far as the values above are true",
                    radius_mm_,
                    UmFromMm(before.z_rms_mm),
                    UmFromMm(after.z_rms_mm),
                    UmFromMm(before.xy_scale),
                    UmFromMm(after.xy_scale)));
    if (controller_ == ControllerKind::kKlipper) {
      out_.Add(WithBelts(AsKlipper(best)));
    } else {
      out_.Add(controller_ == ControllerKind::kRrf ? AsRrf(best, delta.model)
                                                   : AsMarlin(best, delta.model));
    }
  }

  // printer.cfg with the belts' pitch at the head of each tower's section.
  std::string WithBelts(std::string cfg) const {
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      if (steps_per_mm_[i] <= 0) continue;
      const std::string section =
          fmt::format("[stepper_{}]\n", TowerName(static_cast<int>(i)));
      if (cfg.find(section) == std::string::npos) cfg += section;
      const AxisDrawing& drawing = observed_.machine().axes[i];
      cfg.insert(cfg.find(section) + section.size(),
                 fmt::format("rotation_distance: {:.7g}\n",
                             drawing.full_steps_per_rev * drawing.microsteps /
                                 steps_per_mm_[i]));
    }
    return cfg;
  }

  void AddFinding(const Finding& finding) {
    if (finding.cause == "belt_pitch") return;
    if (TurnsGeometry(finding)) {
      out_.Comment(fmt::format(
          "{}: three rods have no number for it; the settings above do what they can",
          KeyOf(finding)));
      return;
    }
    out_.LeaveOver(finding);
  }

  ControllerKind controller_;
  const Diagnosis& diagnosis_;
  const Observed& observed_;
  CorrectionText out_;
  FoundDelta found_;
  double radius_mm_;
  std::array<double, kNumTowers> steps_per_mm_{};  ///< New ones; 0: as they are.
};

}  // namespace

void RequireDeltaGeometry(ControllerKind controller) {
  if (controller == ControllerKind::kLinuxCnc) {
    throw InputError({.file = "--for"},
                     "LinuxCNC's delta kinematics have no numbers for endstops, tower "
                     "angles and unlike rods",
                     "rrf, klipper or marlin");
  }
}

std::string DeltaCorrectionText(ControllerKind controller,
                                const Diagnosis& diagnosis,
                                const Observed& observed) {
  RequireDeltaGeometry(controller);
  return DeltaWriter(controller, diagnosis, observed).Make();
}

}  // namespace caltwin
