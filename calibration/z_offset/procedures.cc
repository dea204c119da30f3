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
// A step of Z and the three decimals that are printed.
constexpr double kMachine_mm = 0.0005;

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
  const std::vector<std::string> words = WordsOf(line);
  const bool calibrates = !words.empty() && words.front() == "CALIBRATE_Z";
  has_tried_ = has_tried_ || calibrates;
  auto answer = link_->Send(line, kPatience);
  if (!answer) return answer;
  for (std::string& said : *answer) said = WithoutMark(said);
  if (calibrates) {
    is_calibrated_ = true;
    last_ = ReadZCalibration(*answer);
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
  if (used_mm < -kPrinted_mm) {
    Fail(
        {.reply = fmt::format("its figures contradict each other: this OFFSET was made "
                              "with a switch_offset of {:.3f}, below 0",
                              used_mm)},
        &result);
    return result;
  }
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
  if (!sd_mm || !range_mm || *sd_mm < 0 || *range_mm < 0) {
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

// As published; and before that one from which no switch_offset, none being below 0,
// lets the nozzle down to the bed.
std::vector<double> HeightsFrom_mm(double in_force_mm) {
  std::vector<double> heights_mm(kHeights_mm.begin(), kHeights_mm.end());
  const double safe_mm = std::ceil(in_force_mm) + 1;
  if (Mutant("z_descent_first_step_blind", safe_mm > heights_mm.front(), false)) {
    heights_mm.insert(heights_mm.begin(), safe_mm);
  }
  return heights_mm;
}

// The gap at a height; nullopt: `result` says why.
std::optional<double> GapAt_mm(double height_mm,
                               ZOffsetClient* client,
                               const FeelerHands& hands,
                               ProcedureResult* result) {
  if (const auto moved = client->Say(fmt::format("G0 Z{}", height_mm)); !moved) {
    Fail(moved.error(), result);
    return std::nullopt;
  }
  const auto gap_mm = hands.gap_mm(height_mm);
  if (!gap_mm || !std::isfinite(*gap_mm)) {
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
  result->messages.push_back(
      fmt::format("at Z{}: a gap of {:.3f} mm", height_mm, *gap_mm));
  return gap_mm;
}

// How much wider the last gap was than its height; nullopt: `result` says why.
std::optional<double> Descend(double in_force_mm,
                              const Eigen::Vector2d& at_mm,
                              ZOffsetClient* client,
                              const FeelerHands& hands,
                              ProcedureResult* result) {
  const std::vector<double> heights_mm = HeightsFrom_mm(in_force_mm);
  for (const std::string& line :
       {std::string("G90"),
        fmt::format("G0 Z{}", heights_mm.front()),
        fmt::format("G0 X{:.3f} Y{:.3f}", at_mm[0], at_mm[1])}) {
    if (const auto moved = client->Say(line); moved) continue;
    Fail({.reply = "the nozzle did not get over the bed (" + line + ")"}, result);
    return std::nullopt;
  }
  double off_mm = 0;
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    const auto gap_mm = GapAt_mm(heights_mm[i], client, hands, result);
    if (!gap_mm) return std::nullopt;
    off_mm = *gap_mm - heights_mm[i];
    if (i + 1 == heights_mm.size()) break;
    const double down_mm =
        Mutant("z_descent_looks_not_ahead", heights_mm[i] - heights_mm[i + 1], 0.0);
    if (*gap_mm - down_mm < kTooNear_mm) {
      result->messages.push_back(
          fmt::format("Z{} is left out: it would end on the bed", heights_mm[i + 1]));
      break;
    }
  }
  client->Say(fmt::format("G0 Z{}", heights_mm.front()));
  return off_mm;
}

/// What a descent goes by: the offset in force less the mean of the calibrations, and
/// how much one of them scatters.
struct Footing {
  double beyond_mean_mm = 0;
  double sd_mm = 0;
  int count = 1;
};

// As published: the calibration that is there.
std::optional<Footing> AsItStands(ZOffsetClient* client, ProcedureResult* result) {
  std::string why;
  if (client->is_spoilt()) {
    why = "Z was homed after CALIBRATE_Z: run z_calibration again first";
  } else if (!client->is_calibrated() || !client->last()) {
    why = "there is no offset to go by: run z_calibration first";
  } else if (const auto base_mm = client->GcodeBase_mm();
             base_mm && std::abs(*base_mm - client->last()->offset_mm) > kPrinted_mm) {
    why = fmt::format(
        "the offset in force is {:.6f}, CALIBRATE_Z had {:.6f}: somebody "
        "adjusted it, run z_calibration again first",
        *base_mm,
        client->last()->offset_mm);
  }
  if (why.empty()) return Footing{};
  Fail({.reply = why}, result);
  return std::nullopt;
}

// Wiped, and calibrated several times.
std::optional<Footing> Calibrated(ZOffsetClient* client,
                                  const SwitchOffsetOptions& options,
                                  const FeelerHands& hands,
                                  ProcedureResult* result) {
  if (!hands.wipe()) {
    Fail({.reply = "nobody wiped the nozzle: plastic on it looks like switch_offset"},
         result);
    return std::nullopt;
  }
  std::vector<double> offsets_mm;
  ProcedureResult one;
  for (int i = 0; i < options.calibrations; ++i) {
    one = RunZCalibration(client, options.in_force_mm);
    if (one.ending != Ending::kDone) break;
    offsets_mm.push_back(client->last()->offset_mm);
  }
  result->messages = one.messages;
  result->steps = one.steps;
  result->ending = one.ending;
  result->fault = one.fault;
  if (one.ending != Ending::kDone) return std::nullopt;
  if (client->is_spoilt()) {
    Fail({.reply = "its own macros home Z: this calibration holds nothing"}, result);
    return std::nullopt;
  }
  const auto count = static_cast<double>(offsets_mm.size());
  double mean_mm = 0, squares_mm2 = 0;
  for (const double offset_mm : offsets_mm) mean_mm += offset_mm / count;
  for (const double offset_mm : offsets_mm) {
    squares_mm2 += std::pow(offset_mm - mean_mm, 2);
  }
  return Footing{.beyond_mean_mm = offsets_mm.back() - mean_mm,
                 .sd_mm = count > 1 ? std::sqrt(squares_mm2 / (count - 1)) : 0,
                 .count = options.calibrations};
}

// One reading in whole leaves, however often it is taken: heights are multiples too.
Uncertain Told(double value_mm, const Footing& footing) {
  const auto count = static_cast<double>(footing.count);
  return WithBudget(
      value_mm,
      {{.input = "scatter of the calibrations",
        .u = Mutant("z_descent_forgets_scatter", footing.sd_mm / std::sqrt(count), 0.0),
        .dof = std::max(1.0, count - 1)},
       {.input = "steps of the machine", .u = kMachine_mm},
       {.input = "feeler gauge's step",
        .u = kFeelerStep_mm / std::sqrt(12.0),
        .is_rectangular = true}});
}

}  // namespace

ProcedureResult RunSwitchOffset(ZOffsetClient* client,
                                const SwitchOffsetOptions& options,
                                const FeelerHands& hands) {
  ProcedureResult result;
  const auto footing = options.is_as_published
                           ? AsItStands(client, &result)
                           : Calibrated(client, options, hands, &result);
  if (!footing) return result;
  const double in_force_mm =
      options.in_force_mm.value_or(client->last()->SwitchOffset_mm());
  const auto wider_mm = Descend(in_force_mm, options.at_mm, client, hands, &result);
  if (!wider_mm) return result;
  // A nozzle that hangs too high needs a greater switch_offset; what the last
  // calibration was higher than their mean is none of it.
  const double should_mm = in_force_mm + *wider_mm - footing->beyond_mean_mm;
  Uncertain told = Told(should_mm, *footing);
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
  result.messages.push_back(
      fmt::format("switch_offset {:.3f} should be {:.3f}", in_force_mm, should_mm));
  if (should_mm < 0) {
    result.messages.push_back(
        "Klipper takes none below 0: does the body of the switch touch as it should?");
  }
  return result;
}

}  // namespace caltwin
