#include "calibration/diagnosis/correction_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/diagnosis/extension.h"
#include "sim/effects/catalog.h"

namespace caltwin {

CorrectionText::CorrectionText(ControllerKind controller, const Diagnosis& diagnosis)
    : controller_(controller),
      diagnosis_(diagnosis),
      is_gcode_(IsSetByGcode(controller)) {
  Comment(
      fmt::format("Correction for {}, by `caltwin diagnose`.", FullName(controller)));
}

void CorrectionText::Comment(const std::string& words) {
  text_ += fmt::format("{} {}\n", is_gcode_ ? ";" : "#", words);
}

void CorrectionText::Set(const std::string& setting, const std::string& source) {
  if (is_gcode_) {
    text_ += fmt::format("{} ; {}\n", setting, source);
    return;
  }
  Comment(source);
  text_ += setting + "\n";
}

const BaselineLine* CorrectionText::Fitted(std::string_view name) const {
  const auto found = std::ranges::find(diagnosis_.baseline, name, &BaselineLine::name);
  return found == diagnosis_.baseline.end() ? nullptr : &*found;
}

bool CorrectionText::IsTold(const BaselineLine& line, double believed) {
  constexpr double kSure_sds = 3;
  return line.is_determined && std::abs(line.value - believed) >= kSure_sds * line.sd;
}

bool CorrectionText::IsToBeSet(const BaselineLine& line) {
  if (IsTold(line)) return true;
  Comment(
      line.is_determined
          ? fmt::format("{} {:+.4g} +- {:.2g} {}: not told from 0, nothing to set",
                        line.name,
                        line.value,
                        line.sd,
                        line.unit)
          : fmt::format("{}: not determined by these rows, nothing to set", line.name));
  return false;
}

void CorrectionText::SetSteps(char letter,
                              double old_per_mm,
                              double error,
                              double steps_a_turn,
                              const std::string& source) {
  const double steps_per_mm = old_per_mm / (1 + error);
  const std::string was = fmt::format("was {:.6g}: {}", old_per_mm, source);
  if (controller_ == ControllerKind::kKlipper) {
    Set(fmt::format("rotation_distance: {:.7g}", steps_a_turn / steps_per_mm),
        "mm a turn; steps/mm " + was);
  } else if (controller_ == ControllerKind::kLinuxCnc) {
    Set(fmt::format("SCALE = {:.7g}", steps_per_mm), "steps/mm, " + was);
  } else {
    Set(fmt::format("M92 {}{:.7g}", letter, steps_per_mm), "steps/mm, " + was);
  }
}

void CorrectionText::SetPlay(char letter, const BaselineLine& play) {
  if (!IsToBeSet(play)) return;
  const std::string source =
      fmt::format("mm, {} {:.4f} +- {:.4f} mm", play.name, play.value, play.sd);
  if (controller_ == ControllerKind::kKlipper) {
    Comment(source + ": Klipper has no backlash compensation; mend the drive");
  } else if (play.value < 0) {
    Comment(source +
            ": a gap that leads is none; is a sign or a sense reversed, or is there "
            "compensation already?");
  } else if (controller_ == ControllerKind::kLinuxCnc) {
    Set(fmt::format("BACKLASH = {:.4f}", play.value), source);
  } else {
    // Marlin corrects by the fraction F, 0 unless it is given.
    const bool is_marlin = controller_ == ControllerKind::kMarlin;
    Set(fmt::format("M425 {}{}{:.4f}", is_marlin ? "F1 " : "", letter, play.value),
        source);
  }
}

void CorrectionText::LeaveOver(const Finding& finding) {
  // LinuxCNC has no mesh.
  const bool has_mesh = controller_ != ControllerKind::kLinuxCnc;
  if (has_mesh && finding.cause.starts_with("bed_")) {
    Comment(fmt::format(
        "{}: a mesh carries it: {}, after these settings",
        SaidOf(finding),
        controller_ == ControllerKind::kKlipper ? "BED_MESH_CALIBRATE" : "G29"));
    return;
  }
  const auto effect = FindEffect(finding.cause);
  Comment(fmt::format("{}: no line for {} is written for this. {}",
                      SaidOf(finding),
                      FullName(controller_),
                      effect ? EffectAt(*effect).words.action : std::string_view{}));
}

std::string SaidOf(const Finding& finding) {
  std::string said = finding.map ? KeyOf(finding) : finding.cause;
  if (!finding.map && !finding.axis.empty()) said += "." + finding.axis;
  for (const FindingParameter& parameter : finding.parameters) {
    said += fmt::format(
        ", {} {:+.4g} +- {:.2g}", parameter.name, parameter.value, parameter.sd);
  }
  return said;
}

}  // namespace caltwin
