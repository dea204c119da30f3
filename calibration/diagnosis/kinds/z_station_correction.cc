#include "calibration/diagnosis/kinds/z_station_correction.h"

#include <optional>

#include <fmt/format.h>

#include "calibration/diagnosis/correction_text.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

// nullopt: the rows were measured with several.
std::optional<double> SwitchOffsetInForce_mm(const Observed& observed) {
  std::optional<double> in_force_mm;
  for (const auto& [id, settings] : observed.header().settings) {
    if (!settings.switch_offset_mm) continue;
    if (in_force_mm && *in_force_mm != *settings.switch_offset_mm) return std::nullopt;
    in_force_mm = settings.switch_offset_mm;
  }
  return in_force_mm ? in_force_mm : ZStationOf(observed.machine()).trigger_mm;
}

// What else it could be; empty: nothing.
std::string RivalOf(const Finding& finding) {
  constexpr double kLikely = 0.05;
  for (std::size_t i = 1; i < finding.candidates.size(); ++i) {
    const FindingCandidate& one = finding.candidates[i];
    if (one.structural || one.probability > kLikely) return one.cause;
  }
  return {};
}

std::string SwitchOffsetText(const FindingParameter& off_um,
                             std::optional<double> in_force_mm) {
  const std::string said =
      fmt::format("{:+.4f} +- {:.4f} mm, from the gap under the nozzle",
                  MmFromUm(off_um.value),
                  MmFromUm(off_um.sd));
  if (!in_force_mm) {
    return fmt::format(
        "# [z_calibration] switch_offset: change it by {}; the rows were "
        "measured with several\n",
        said);
  }
  const double off_mm = MmFromUm(off_um.value);
  if (*in_force_mm + off_mm < 0) {
    return fmt::format(
        "# switch_offset: it would be {:.4f}, and Klipper takes none below 0 (was "
        "{:.4f}: "
        "{}): does the body of the switch touch as it should?\n",
        *in_force_mm + off_mm,
        *in_force_mm,
        said);
  }
  return fmt::format("[z_calibration]\n# was {:.4f}: {}\nswitch_offset: {:.4f}\n",
                     *in_force_mm,
                     said,
                     *in_force_mm + off_mm);
}

}  // namespace

void RequireZCalibration(ControllerKind controller) {
  if (controller == ControllerKind::kKlipper) return;
  throw InputError({.file = "--for"},
                   fmt::format("{} has no switch_offset", FullName(controller)),
                   "klipper, with its z_calibration extension");
}

std::string ZStationCorrectionText(ControllerKind controller,
                                   const Diagnosis& diagnosis,
                                   const Observed& observed) {
  RequireZCalibration(controller);
  CorrectionText out(controller, diagnosis);
  bool is_set = false;
  for (const Finding& finding : diagnosis.findings) {
    if (finding.cause != SwitchOffset::kDeclaration.name) {
      out.LeaveOver(finding);
      continue;
    }
    const std::string rival = RivalOf(finding);
    if (!rival.empty()) {
      out.Comment(fmt::format("switch_offset: it may be {} as well, nothing to set yet",
                              rival));
    } else if (!finding.parameters.empty()) {
      out.Add(
          SwitchOffsetText(finding.parameters[0], SwitchOffsetInForce_mm(observed)));
    } else {
      out.LeaveOver(finding);
      continue;
    }
    is_set = true;
  }
  if (!is_set) out.Comment("switch_offset: nothing was found of it, nothing to set.");
  return out.text();
}

}  // namespace caltwin
