#include "calibration/z_offset/procedures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/touch_noise.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kPatience{120'000};
constexpr double kPrinted_mm = 0.0011;  // Three decimals, three of them.
constexpr double kFeelerStep_mm = 0.01;
// Of an offset: three means of five touches that scatter by 1 um each (0.77 um), and a
// step's rounding. Nobody tells this procedure of a switch that scatters more.
constexpr double kMachine_mm = 0.001;

std::optional<double> After(const std::string& line, const std::string& key) {
  const std::size_t at = line.find(key);
  if (at == std::string::npos) return std::nullopt;
  const char* from = line.c_str() + at + key.size();
  char* end = nullptr;
  const double value = std::strtod(from, &end);
  return end == from ? std::nullopt : std::optional(value);
}

std::optional<double> After(const std::vector<std::string>& lines,
                            const std::string& start,
                            const std::string& key) {
  for (const std::string& line : lines) {
    if (line.starts_with(start)) return After(line, key);
  }
  return std::nullopt;
}

// "G28", "Z" of "  g28 z ; home".
std::vector<std::string> WordsOf(const std::string& line) {
  std::istringstream text(line.substr(0, line.find(';')));
  std::vector<std::string> words;
  for (std::string word; text >> word;) {
    for (char& c : word) {
      c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
    words.push_back(word);
  }
  return words;
}

// All axes, or Z among them.
bool HomesZ(const std::string& line) {
  const std::vector<std::string> words = WordsOf(line);
  if (words.empty() || words.front() != "G28") return false;
  return words.size() == 1 ||
         std::any_of(words.begin() + 1, words.end(), [](auto& word) {
           return word.starts_with('Z');
         });
}

// Klipper's own port begins what it says with "// ".
std::string WithoutMark(const std::string& line) {
  return line.starts_with("// ") ? line.substr(3) : line;
}

bool HomesWithin(const std::string& macro) {
  std::istringstream lines(macro);
  for (std::string line; std::getline(lines, line);) {
    if (HomesZ(line)) return true;
  }
  return false;
}

void Fail(const MachineFault& fault, ProcedureResult* result) {
  result->fault = fault.reply;
  result->ending = fault.reply.find("No trigger") != std::string::npos
                       ? Ending::kNoTrigger
                   : fault.kind == MachineFault::Kind::kLinkLost ? Ending::kLinkLost
                                                                 : Ending::kRefused;
  result->messages.push_back("the machine said: " + fault.reply);
}

}  // namespace

std::optional<ZCalibrationReading> ReadZCalibration(
    const std::vector<std::string>& lines) {
  constexpr const char* kStart = "Z-CALIBRATION:";
  const auto endstop = After(lines, kStart, "ENDSTOP=");
  const auto nozzle = After(lines, kStart, "NOZZLE=");
  const auto on_switch = After(lines, kStart, "SWITCH=");
  const auto probe = After(lines, kStart, "PROBE=");
  const auto offset = After(lines, kStart, "OFFSET=");
  if (!endstop || !nozzle || !on_switch || !probe || !offset) return std::nullopt;
  return ZCalibrationReading{*endstop, *nozzle, *on_switch, *probe, *offset};
}

Expected<std::vector<std::string>> ZOffsetClient::Say(const std::string& line) {
  auto answer = link_->Send(line, kPatience);
  if (!answer) return answer;
  for (std::string& said : *answer) said = WithoutMark(said);
  const std::vector<std::string> words = WordsOf(line);
  if (!words.empty() && words.front() == "CALIBRATE_Z") {
    is_calibrated_ = true;
    if (const auto read = ReadZCalibration(*answer)) {
      switch_offset_mm_ = read->SwitchOffset_mm();
    }
    const bool homes_late =
        HomesWithin(macros_.before_switch_gcode) || HomesWithin(macros_.end_gcode);
    is_spoilt_ = Mutant("z_end_gcode_not_read", homes_late, false);
  } else if (HomesZ(line)) {
    is_spoilt_ = is_calibrated_;
  }
  return answer;
}

ProcedureResult ZOffsetClient::Home() {
  ProcedureResult result;
  if (const auto homed = Say("G28"); !homed) Fail(homed.error(), &result);
  return result;
}

std::optional<double> ZOffsetClient::GcodeBase_mm() {
  const auto position = Say("GET_POSITION");
  return position ? After(*position, "gcode base:", "Z:") : std::nullopt;
}

ProcedureResult RunZCalibration(ZOffsetClient* client,
                                std::optional<double> switch_offset_mm) {
  ProcedureResult result;
  const auto answer = client->Say("CALIBRATE_Z");
  if (!answer) {
    Fail(answer.error(), &result);
    return result;
  }
  const auto reading = ReadZCalibration(*answer);
  if (!reading) {
    Fail({.reply = fmt::format("Could not parse '{}' to CALIBRATE_Z",
                               answer->empty() ? "" : answer->back())},
         &result);
    return result;
  }
  result.messages.push_back(answer->back());
  const double used_mm = reading->SwitchOffset_mm();
  if (switch_offset_mm && std::abs(used_mm - *switch_offset_mm) > kPrinted_mm) {
    result.messages.push_back(
        fmt::format("this offset was made with switch_offset {:.3f}, not {:.3f}",
                    used_mm,
                    *switch_offset_mm));
  }
  const auto base_mm = client->GcodeBase_mm();
  if (base_mm && std::abs(*base_mm - reading->offset_mm) > kPrinted_mm) {
    result.messages.push_back(
        fmt::format("GET_POSITION has {:.6f} for it: somebody adjusted it", *base_mm));
  }
  result.steps.push_back({.procedure = "z_calibration",
                          .variant = "corrected",
                          .name = "gcode_offset.z",
                          .before = 0,
                          .after = reading->offset_mm,
                          .verdict = Verdict::kApplied,
                          .message = "probe - (switch - nozzle + switch_offset)"});
  result.observability.push_back(
      {.statement =
           "the offset takes ooze on the nozzle and a wrong switch_offset for the "
           "bed's height: a gap measured under the nozzle tells their sum, after a "
           "calibration with the nozzle wiped switch_offset alone",
       .blind_direction = {{"ooze", std::sqrt(0.5)},
                           {"switch_offset", -std::sqrt(0.5)}}});
  return result;
}

ProcedureResult RunProbeAccuracy(ZOffsetClient* client, bool is_endstop, int samples) {
  constexpr double kWorn_mm = 0.01;
  ProcedureResult result;
  const auto answer = client->Say(fmt::format(
      "{} SAMPLES={}", is_endstop ? "PROBE_Z_ACCURACY" : "PROBE_ACCURACY", samples));
  if (!answer) {
    Fail(answer.error(), &result);
    return result;
  }
  const std::string start = "probe accuracy results";
  const auto sd_mm = After(*answer, start, "standard deviation ");
  const auto range_mm = After(*answer, start, "range ");
  if (!sd_mm || !range_mm) {
    Fail({.reply = fmt::format("Could not parse '{}'",
                               answer->empty() ? "" : answer->back())},
         &result);
    return result;
  }
  result.messages.push_back(answer->back());
  // Klipper divides by n; of n normal numbers n - 1 tell the scatter.
  const int dof = std::max(samples - 1, 1);
  const double scatter_um = UmFromMm(*sd_mm) * std::sqrt(1 + 1.0 / dof);
  result.estimates.push_back({.name = is_endstop ? "endstop_scatter" : "probe_scatter",
                              .unit = "um",
                              .value = scatter_um,
                              .sd = scatter_um * ScatterSdFactor(dof),
                              .identifiable = samples > 2});
  result.messages.push_back(
      *sd_mm > kWorn_mm
          ? fmt::format(
                "{:.1f} um from touch to touch: worn, dirty or loose; an offset of "
                "{} samples is uncertain by {:.1f} um",
                UmFromMm(*sd_mm),
                samples,
                UmFromMm(*sd_mm) / std::sqrt(samples))
          : fmt::format("{:.1f} um from touch to touch", UmFromMm(*sd_mm)));
  return result;
}

namespace {

constexpr std::array kHeights_mm = {5.0, 3.0, 1.0, 0.5, 0.3, 0.1};
constexpr double kTooNear_mm = 0.02;

// How much wider the last gap was than its height; nullopt: `result` says why.
std::optional<double> Descend(ZOffsetClient* client,
                              const FeelerHands& hands,
                              ProcedureResult* result) {
  double off_mm = 0;
  for (std::size_t i = 0; i < kHeights_mm.size(); ++i) {
    const double height_mm = kHeights_mm[i];
    if (const auto moved = client->Say(fmt::format("G0 Z{}", height_mm)); !moved) {
      Fail(moved.error(), result);
      return std::nullopt;
    }
    const auto gap_mm = hands.gap_mm(height_mm);
    if (!gap_mm) {
      Fail({.reply = "nobody measured the gap"}, result);
      return std::nullopt;
    }
    if (*gap_mm <= 0) {
      Fail({.reply = fmt::format("a gap of {:.3f} mm at Z{}: the nozzle is on the bed",
                                 *gap_mm,
                                 height_mm)},
           result);
      return std::nullopt;
    }
    off_mm = *gap_mm - height_mm;
    result->messages.push_back(
        fmt::format("at Z{}: a gap of {:.3f} mm", height_mm, *gap_mm));
    if (i + 1 == kHeights_mm.size()) break;
    const double down_mm =
        Mutant("z_descent_looks_not_ahead", height_mm - kHeights_mm[i + 1], 0.0);
    if (*gap_mm - down_mm < kTooNear_mm) {
      result->messages.push_back(
          fmt::format("Z{} is left out: it would end on the bed", kHeights_mm[i + 1]));
      break;
    }
  }
  return off_mm;
}

// The calibration that the descent goes by; false: there is none.
bool Prepare(ZOffsetClient* client,
             const SwitchOffsetOptions& options,
             const FeelerHands& hands,
             ProcedureResult* result) {
  if (options.is_as_published) {
    if (client->is_calibrated() && !client->is_spoilt()) return true;
    Fail({.reply = client->is_spoilt()
                       ? "Z was homed after CALIBRATE_Z: run z_calibration again first"
                       : "there is no offset to go by: run z_calibration first"},
         result);
    return false;
  }
  if (!hands.wipe()) {
    Fail({.reply = "nobody wiped the nozzle: plastic on it looks like switch_offset"},
         result);
    return false;
  }
  const ProcedureResult calibrated = RunZCalibration(client, options.in_force_mm);
  result->messages.insert(
      result->messages.end(), calibrated.messages.begin(), calibrated.messages.end());
  result->steps = calibrated.steps;
  result->ending = calibrated.ending;
  result->fault = calibrated.fault;
  if (calibrated.ending != Ending::kDone) return false;
  if (!client->is_spoilt()) return true;
  Fail({.reply = "its own macros home Z: this calibration holds nothing"}, result);
  return false;
}

}  // namespace

ProcedureResult RunSwitchOffset(ZOffsetClient* client,
                                const SwitchOffsetOptions& options,
                                const FeelerHands& hands) {
  ProcedureResult result;
  if (!Prepare(client, options, hands, &result)) return result;
  const auto in_force_mm =
      options.in_force_mm ? options.in_force_mm : client->switch_offset_mm();
  if (!in_force_mm) {
    Fail({.reply = "which switch_offset is in force is not known"}, &result);
    return result;
  }
  const auto off_mm = Descend(client, hands, &result);
  if (!off_mm) return result;
  // A nozzle that hangs too high needs a greater switch_offset.
  // One reading in whole leaves, however often it is taken: heights are multiples too.
  Uncertain told =
      WithBudget(*in_force_mm + *off_mm,
                 {{.input = "touches and steps of the machine", .u = kMachine_mm},
                  {.input = "feeler gauge's step",
                   .u = kFeelerStep_mm / std::sqrt(12.0),
                   .is_rectangular = true}});
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
  result.messages.push_back(fmt::format(
      "switch_offset {:.3f} should be {:.3f}", *in_force_mm, *in_force_mm + *off_mm));
  return result;
}

}  // namespace caltwin
