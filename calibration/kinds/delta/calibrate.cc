#include "calibration/kinds/delta/calibrate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/procedures.h"
#include "calibration/kinds/delta/setting_names.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/base/units.h"
#include "sim/link/gcode.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kCalibratePatience{60'000};

// The words behind `name` in a line such as "echo:  M665 L250.00 R130.00".
std::optional<GcodeCommand> CommandIn(const std::string& line, char letter, int code) {
  const std::size_t at = line.find(fmt::format("{}{} ", letter, code));
  if (at == std::string::npos) return std::nullopt;
  try {
    const GcodeLine parsed = ParseGcode(line.substr(at));
    if (parsed.commands.size() == 1) return parsed.commands[0];
  } catch (const InputError&) {  // No such command, then.
  }
  return std::nullopt;
}

void TakeGeometry(const GcodeCommand& m665,
                  const DeltaModel<double>& drawn,
                  double* height_mm,
                  DeltaModel<double>* settings) {
  *height_mm = m665.Number('H').value_or(*height_mm);
  const double arm_mm = m665.Number('L').value_or(MeanOfTowers(drawn.arm_mm));
  for (std::size_t i = 0; i < 3; ++i) {
    settings->radius_mm[i] = m665.Number('R').value_or(drawn.radius_mm[i]);
    settings->arm_mm[i] = arm_mm + m665.Number("ABC"[i]).value_or(0);
    settings->angle_rad[i] =
        drawn.angle_rad[i] + RadFromDeg(m665.Number("XYZ"[i]).value_or(0));
  }
}

class DeltaCalibration {
 public:
  DeltaCalibration(const DeltaStep& step, const DeltaBench& bench)
      : step_(step), bench_(bench), drawn_(DeltaOf(bench.machine).model) {}

  ProcedureResult Perform() {
    const auto believed = Believed();
    if (!believed) {
      End(believed.error());
    } else if (step_.name == "g33") {
      RunG33(*believed);
    } else {
      RunHere(*believed);
    }
    return std::move(result_);
  }

 private:
  Expected<BelievedDelta> Believed() const {
    if (bench_.believed) return bench_.believed();
    return ReadBelievedDelta(bench_.link, drawn_);
  }

  void End(const MachineFault& fault) {
    result_.ending = EndingOfFault(fault);
    result_.fault = fault.reply;
  }

  Expected<void> Ask(const std::string& what) const {
    return bench_.person->Do({.kind = Act::Kind::kConfirm, .text = what});
  }

  // Runs inside the controller, which takes what it finds.
  void RunG33(const BelievedDelta& believed) {
    if (const auto blind = BlindnessOfG33(step_.points)) {
      result_.observability.push_back(*blind);
    }
    DeltaLinkProbe wire(bench_.link, drawn_, believed.settings);
    const std::string line = fmt::format("G33 P{}{}", step_.points, step_.words);
    const auto agreed =
        Ask(fmt::format("{} sets what it finds by itself. Run it?", line));
    const auto answers = wire.Say(agreed.has_value() ? line : AsDryRun(line));
    result_.messages.assign(answers.begin(), answers.end());
    if (wire.fault()) {
      End(*wire.fault_itself());
      return;
    }
    if (!agreed) {
      result_.ending = Ending::kRefused;
      result_.messages.push_back(agreed.error().reply + "; G33 was run dry (V0)");
      return;
    }
    wire.Say("M500");
    const auto now = Believed();
    if (!now) {
      End(now.error());
      return;
    }
    AddSteps(believed.settings, now->settings, Verdict::kApplied, "");
  }

  static std::string AsDryRun(std::string line) {
    if (const std::size_t at = line.find(" V"); at != std::string::npos) {
      line.erase(at, line.find(' ', at + 1) - at);
    }
    return line + " V0";
  }

  // Runs at this end of the wire.
  void RunHere(const BelievedDelta& believed) {
    DeltaLinkProbe wire(bench_.link, drawn_, believed.settings);
    std::optional<DeltaRows> rows;
    if (bench_.record != nullptr) {
      rows.emplace(bench_.machine, bench_.probe_sigma_mm, bench_.record);
      rows->Begin(step_.name);
      rows->SetOffset(believed.probe_offset_mm);
    }
    const DeltaProbe probe =
        [&, touch = wire.AsProbe()](
            const DeltaModel<double>& settings, double x_mm, double y_mm) {
          auto motors_mm = touch(settings, x_mm, y_mm);
          result_.touches += motors_mm ? 1 : 0;
          if (rows && motors_mm) rows->Add(settings, *motors_mm);
          return motors_mm;
        };
    std::optional<DeltaJointFit> fit;
    const DeltaOutcome outcome =
        PerformDeltaStep(step_,
                         bench_.probe_sigma_mm,
                         bench_.machine,
                         {.probe = probe, .calliper = Calliper()},
                         believed.settings,
                         &fit);
    result_.messages.assign(outcome.messages.begin(), outcome.messages.end());
    result_.figures = {{"said_mm", outcome.said_mm},
                       {"tilt_x", outcome.tilt_x},
                       {"tilt_y", outcome.tilt_y}};
    if (bench_.fit != nullptr) *bench_.fit = fit;
    if (wire.fault()) {
      End(*wire.fault_itself());
    } else if (wire.was_out_of_reach()) {
      result_.ending = Ending::kNoTrigger;
      result_.messages.emplace_back("a touch found no bed; nothing is set");
    } else if (unread_ > 0) {
      result_.ending = Ending::kRefused;
      result_.fault = fmt::format(
          "{} readings of the calliper were not given; nothing is set", unread_);
    } else {
      if (fit) AddEstimates(*fit);
      result_.estimates.insert(
          result_.estimates.end(), outcome.estimates.begin(), outcome.estimates.end());
      result_.correlations = outcome.correlations;
      Set(believed.settings, outcome, &wire);
    }
  }

  // The person's, whose missing readings are counted.
  DeltaCalliper Calliper() {
    const auto counted = [this](std::optional<double> read_mm) {
      unread_ += read_mm ? 0 : 1;
      return read_mm;
    };
    return {
        .rod_mm = [this,
                   counted](int rod) { return counted(bench_.calliper.rod_mm(rod)); },
        .between_mm =
            [this, counted](const Vec3<double>& from_mm, const Vec3<double>& to_mm) {
              return counted(bench_.calliper.between_mm(from_mm, to_mm));
            },
        .sigma_mm = bench_.calliper.sigma_mm};
  }

  void Set(const DeltaModel<double>& before,
           const DeltaOutcome& outcome,
           DeltaLinkProbe* wire) {
    if (!outcome.is_done) {
      result_.ending = Ending::kUnconverged;
      result_.messages.emplace_back("it did not succeed by its own judgement");
    }
    const std::string lines = AsMarlin(outcome.settings, drawn_);
    const bool is_changed = lines != AsMarlin(before, drawn_);
    if (!is_changed && outcome.mesh.nodes == 0) return;
    const auto agreed =
        Ask(fmt::format("Send and store (M500)\n{}{}?",
                        lines,
                        outcome.mesh.nodes > 0 ? "and a mesh (M421, M420)" : ""));
    if (!agreed) {
      if (result_.ending == Ending::kDone) result_.ending = Ending::kRefused;
      AddSteps(before, outcome.settings, Verdict::kRefused, agreed.error().reply);
      return;
    }
    wire->Set(outcome.settings);
    if (outcome.mesh.nodes > 0) wire->Set(outcome.mesh);
    wire->Say("M500");
    if (wire->fault()) {
      End(*wire->fault_itself());
      return;
    }
    AddSteps(before,
             bench_.believed ? bench_.believed().settings : outcome.settings,
             Verdict::kApplied,
             "");
  }

  void AddSteps(const DeltaModel<double>& before,
                const DeltaModel<double>& after,
                Verdict verdict,
                const std::string& message) {
    const auto add = [&](const std::string& name, double was, double is) {
      result_.steps.push_back({.procedure = step_.name,
                               .variant = step_.variant,
                               .name = name,
                               .before = was,
                               .after = is,
                               .verdict = verdict,
                               .message = message});
    };
    for (const char* name : kDeltaSettingNames) {
      const double was = *DeltaSettingNamed(before, drawn_, name);
      const double is = *DeltaSettingNamed(after, drawn_, name);
      if (was != is) add(name, was, is);
    }
    // What M665 A B C and Z set beside the mean rod and the angles of towers a and b.
    const auto add_trim = [&](const std::string& name, double was, double is) {
      constexpr double kRounding = 1e-9;
      if (std::abs(is - was) > kRounding) add(name, was, is);
    };
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      add_trim(fmt::format("arm_length.{}", "abc"[i]),
               before.arm_mm[i] - MeanOfTowers(before.arm_mm),
               after.arm_mm[i] - MeanOfTowers(after.arm_mm));
    }
    const double drawn_rad = drawn_.angle_rad[2];
    add_trim("tower_angle.c",
             DegFromRad(before.angle_rad[2] - drawn_rad),
             DegFromRad(after.angle_rad[2] - drawn_rad));
  }

  // Of what is a setting, its value; of the rest, built less drawn.
  void AddEstimates(const DeltaJointFit& fit) {
    constexpr double kSaidNothing = 0.9;  // Of the prior's standard deviation.
    for (const DeltaEstimate& estimate : fit.estimates) {
      const DeltaKnob& knob = kDeltaKnobs[static_cast<std::size_t>(estimate.knob)];
      const auto set = DeltaSettingNamed(fit.build.model, drawn_, knob.name);
      result_.estimates.push_back(
          {.name = std::string(knob.name),
           .unit = std::string(knob.unit),
           .value = set.value_or(estimate.value),
           .sd = estimate.sd,
           .identifiable = estimate.sd_over_prior < kSaidNothing,
           .is_setting = set.has_value()});
    }
  }

  const DeltaStep& step_;
  const DeltaBench& bench_;
  const DeltaModel<double>& drawn_;
  ProcedureResult result_{};
  int unread_ = 0;
};

}  // namespace

Expected<BelievedDelta> ReadBelievedDelta(Link* link, const DeltaModel<double>& drawn) {
  const auto answer = link->Send("M503", kCalibratePatience);
  if (!answer) return tl::unexpected(answer.error());
  BelievedDelta believed{.settings = drawn};
  double height_mm = 0;
  std::optional<GcodeCommand> m665, m666;
  for (const std::string& line : *answer) {
    if (auto command = CommandIn(line, 'M', 665)) m665 = std::move(command);
    if (auto command = CommandIn(line, 'M', 666)) m666 = std::move(command);
    const auto m851 = CommandIn(line, 'M', 851);
    for (int i = 0; m851 && i < 3; ++i) {
      believed.probe_offset_mm[i] = m851->Number("XYZ"[i]).value_or(0);
    }
  }
  if (!m665 || !m666) {
    return tl::unexpected(
        MachineFault{.reply = "M503 was answered without M665 and M666: a delta is "
                              "calibrated in Marlin's dialect"});
  }
  TakeGeometry(*m665, drawn, &height_mm, &believed.settings);
  for (std::size_t i = 0; i < 3; ++i) {
    believed.settings.endstop_mm[i] = height_mm - m666->Number("XYZ"[i]).value_or(0);
  }
  return believed;
}

ProcedureResult CalibrateDelta(const DeltaStep& step, const DeltaBench& bench) {
  return DeltaCalibration(step, bench).Perform();
}

}  // namespace caltwin
