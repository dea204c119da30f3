#include "calibration/kinds/z_station/procedures.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "calibration/estimate/touch_noise.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kProceduresPatience{120'000};

std::optional<double> After(const std::string& line, const std::string& key) {
  const std::size_t at = line.find(key);
  if (at == std::string::npos) return std::nullopt;
  const char* from = line.c_str() + at + key.size();
  char* end = nullptr;
  const double value = std::strtod(from, &end);
  return end == from || !std::isfinite(value) ? std::nullopt : std::optional(value);
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

}  // namespace

void FailZStation(const MachineFault& fault, ProcedureResult* result) {
  result->fault = fault.reply;
  result->ending = EndingOfFault(fault);
  result->messages.push_back(MachineSaid(fault.reply));
}

std::optional<ZCalibrationReading> ReadZCalibration(
    const std::vector<std::string>& lines) {
  // As first published in capitals; the extension of today, and Kalico's, print their
  // formula, whose `switch_offset=` is not the result.
  const auto told = [&](const char* capitals, const char* formula) {
    constexpr const char* kStart = "Z-CALIBRATION:";
    const auto value = After(lines, kStart, capitals);
    return value ? value : After(lines, kStart, formula);
  };
  const auto nozzle = told("NOZZLE=", "nozzle=");
  const auto on_switch = told("SWITCH=", "switch=");
  const auto probe = told("PROBE=", "probe=");
  const auto offset = told("OFFSET=", "new offset=");
  if (!nozzle || !on_switch || !probe || !offset) return std::nullopt;
  return ZCalibrationReading{*nozzle, *on_switch, *probe, *offset};
}

Expected<std::vector<std::string>> ZStationClient::Say(const std::string& line) {
  const std::vector<std::string> words = WordsOf(line);
  const bool calibrates = !words.empty() && words.front() == "CALIBRATE_Z";
  has_tried_ = has_tried_ || calibrates;
  auto answer = link_->Send(line, kProceduresPatience);
  if (!answer) return answer;
  for (std::string& said : *answer) said = WithoutMark(said);
  if (calibrates) {
    is_calibrated_ = true;
    last_ = ReadZCalibration(*answer);
    const bool homes_late =
        HomesWithin(macros_.before_switch_gcode) || HomesWithin(macros_.end_gcode);
    is_spoilt_ = homes_late;
  } else if (HomesZ(line)) {
    is_spoilt_ = is_calibrated_;
  }
  return answer;
}

ProcedureResult ZStationClient::Home() {
  ProcedureResult result;
  if (const auto homed = Say("G28"); !homed) FailZStation(homed.error(), &result);
  return result;
}

std::optional<double> ZStationClient::GcodeBase_mm() {
  const auto position = Say("GET_POSITION");
  return position ? After(*position, "gcode base:", "Z:") : std::nullopt;
}

std::optional<ZStationClient::Heights> ZStationClient::HeightsNow() {
  const auto position = Say("GET_POSITION");
  if (!position) return std::nullopt;
  // The base is in the position already, a mesh only in the toolhead's.
  const auto gcode_mm = After(*position, "gcode:", "Z:");
  const auto base_mm = After(*position, "gcode base:", "Z:");
  if (!gcode_mm || !base_mm) return std::nullopt;
  const auto toolhead_mm = After(*position, "toolhead:", "Z:");
  return Heights{.gcode_mm = *gcode_mm - *base_mm,
                 .mesh_mm = toolhead_mm ? *toolhead_mm - *gcode_mm : 0};
}

ProcedureResult RunZCalibration(ZStationClient* client,
                                std::optional<double> switch_offset_mm) {
  ProcedureResult result;
  const auto answer = client->Say("CALIBRATE_Z");
  if (!answer) {
    FailZStation(answer.error(), &result);
    return result;
  }
  const auto reading = ReadZCalibration(*answer);
  if (!reading) {
    FailZStation({.reply = fmt::format("Could not parse '{}' to CALIBRATE_Z",
                                       answer->empty() ? "" : answer->back())},
                 &result);
    return result;
  }
  result.messages.push_back(answer->back());
  const double used_mm = reading->SwitchOffset_mm();
  if (used_mm < -kPrintedHeights_mm) {
    FailZStation(
        {.reply = fmt::format("its figures contradict each other: this OFFSET was made "
                              "with a switch_offset of {:.3f}, below 0",
                              used_mm)},
        &result);
    return result;
  }
  if (switch_offset_mm && std::abs(used_mm - *switch_offset_mm) > kPrintedHeights_mm) {
    result.messages.push_back(
        fmt::format("this offset was made with switch_offset {:.3f}, not {:.3f}",
                    used_mm,
                    *switch_offset_mm));
  }
  const auto base_mm = client->GcodeBase_mm();
  if (base_mm && std::abs(*base_mm - reading->offset_mm) > kPrintedHeights_mm) {
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

ProcedureResult RunProbeAccuracy(ZStationClient* client, bool is_endstop, int samples) {
  constexpr double kWorn_mm = 0.01;
  ProcedureResult result;
  const auto answer = client->Say(fmt::format(
      "{} SAMPLES={}", is_endstop ? "PROBE_Z_ACCURACY" : "PROBE_ACCURACY", samples));
  if (!answer) {
    FailZStation(answer.error(), &result);
    return result;
  }
  const std::string start = "probe accuracy results";
  const auto sd_mm = After(*answer, start, "standard deviation ");
  const auto range_mm = After(*answer, start, "range ");
  if (!sd_mm || !range_mm || *sd_mm < 0 || *range_mm < 0) {
    FailZStation({.reply = fmt::format("Could not parse '{}'",
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

}  // namespace caltwin
