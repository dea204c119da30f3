#include "calibration/diagnosis/diagnosis_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

// What one cause is called, and what it does. In braces a parameter with its
// uncertainty, or with a tilde without; {axis} {pair} {by} {to} are the axis in
// capitals and, of ISO 230-1 names such as EYX, the axis that moves and the axis that
// errs; {ring} says more of three motors exchanged.
struct Phrase {
  std::string_view cause, name, does;
};

constexpr std::array kPhrases = {
    Phrase{"cyclic_lead",
           "cyclic error of the {axis} screw",
           "The {axis} screw errs by {amplitude_um} once per turn ({~period_mm})"},
    Phrase{"pulley_eccentric",
           "eccentric pulley of {axis}",
           "The {axis} pulley runs out: the axis errs by {amplitude_um} once per turn "
           "({~period_mm})"},
    Phrase{"microstep",
           "microstep error of the {axis} motor",
           "The {axis} motor errs by {amplitude_um} within every four full steps"},
    Phrase{"pitch_progressive",
           "changing pitch of the {axis} screw",
           "The pitch of the {axis} screw changes along its travel: both ends are off "
           "by {bow_um} against the middle"},
    Phrase{"pitch_map",
           "position table of {axis}",
           "The {axis} axis errs with position, in a shape that only a table tells"},
    Phrase{"thermal_screw",
           "growth of the {axis} screw with its temperature",
           "The {axis} screw grows by {expansion_um_per_m_k} as it warms, "
           "{~lag_s} behind its thermometer"},
    Phrase{
        "frame_growth",
        "growth of the frame while warming up",
        "Head and frame lift the tool by {growth_um} while they warm up, with a time "
        "constant of {~tau_s}"},
    Phrase{"frame_temperature",
           "growth of the {part} with its temperature",
           "The {part} grows along Z by {growth_um_per_k}, {~lag_s} behind its "
           "thermometer"},
    Phrase{"probe_temperature",
           "drift of the probe with temperature",
           "The probe drifts by {drift_um_per_k}, {~lag_s} behind the thermometer"},
    Phrase{"backlash_worn",
           "backlash of {axis} worn in one place",
           "The {axis} drive is worn in one place: {extra_mm} more play about "
           "{~center_mm}, {~width_mm} wide"},
    Phrase{"windup_load",
           "wind-up of the {axis} drive under load",
           "The {axis} drive gives way under load by {compliance_um_per_n}"},
    Phrase{"reversal_spike",
           "spike of {axis} after a reversal",
           "The {axis} axis sticks after a reversal: {height_um}, gone after some "
           "{~decay_mm}"},
    Phrase{"missed_steps",
           "lost steps of {axis}",
           "The {axis} motor lost steps: a jump of {jump_um} at {~at_t_s}"},
    Phrase{"homing_scatter",
           "scatter of homing {axis}",
           "Homing {axis} scatters by {sd_um}"},
    Phrase{"squareness",
           "squareness of {pair} ({axis})",
           "{pair} are out of square by {angle_mrad} ({axis})"},
    Phrase{"straightness",
           "straightness of {by} towards {to} ({axis})",
           "{by} does not run straight: it bows by {bow_um} towards {to} ({axis})"},
    Phrase{"angular",
           "turn of {by} about {to} ({axis})",
           "{by} turns about {to} as it moves: {slope_urad} over its travel ({axis})"},
    Phrase{"gantry_sag",
           "sag of the gantry",
           "The gantry hangs lower in the middle by {sag_um}"},
    Phrase{"axis_twist",
           "twist of the beam",
           "The beam is twisted: the head turns by {twist_mrad} over the travel"},
    Phrase{"servo_mismatch",
           "mismatch of the servos",
           "One servo of X and Y answers later than the other by {mismatch_ms}"},
    Phrase{"servo_lag",
           "lag of the servos",
           "The servos cut the circle by {lag_um_at_50_mm_s} at 50 mm/s"},
    Phrase{"probe_lobing",
           "lobing of the probe",
           "The probe triggers in three lobes of {amplitude_um}"},
    Phrase{"stylus_anisotropy",
           "stylus softer one way than across",
           "The stylus is softer one way than across by {amplitude_um}"},
    Phrase{"tip_runout",
           "run-out of the tip",
           "The tip runs out of the spindle's axis by {offset_um}"},
    Phrase{"tip_size",
           "wrong tip radius",
           "The tip's radius is not the configured one: it differs by "
           "{radius_error_mm}"},
    Phrase{"trigger_latency",
           "latency of the trigger",
           "The trigger comes late by {latency_ms}"},
    Phrase{"tower_lean",
           "lean of tower {axis}",
           "Tower {axis} leans outward by {radial_mrad} and counter-clockwise by "
           "{tangential_mrad}"},
    Phrase{"tower_twist",
           "twist of tower {axis}",
           "Tower {axis} is turned about itself by {angle_deg}"},
    Phrase{"tower_radius",
           "radius of tower {axis}",
           "Tower {axis} stands further out than drawn by {error_mm}"},
    Phrase{"effector_tilt",
           "tilt of the effector",
           "The nozzle stands askew in the effector by {tilt_x_mrad} about X and "
           "{tilt_y_mrad} about Y"},
    Phrase{"rod_mismatch",
           "length of rods {axis}",
           "Rod {axis} (both of the tower where no number stands) is longer than drawn "
           "by {length_error_mm}"},
    Phrase{"racking",
           "racked beam",
           "The beam does not stand square to its rails: it is turned by {angle_mrad}"},
    Phrase{"belt_pitch",
           "pitch of belt {axis}",
           "Belt {axis} moves what it pulls too far by {error_ppm}"},
    Phrase{"carriage_backlash",
           "play of carriage {axis}",
           "The carriage of tower {axis} has {gap_mm} of play"},
    Phrase{"screw_pitch",
           "pitch of screw {axis}",
           "Screw {axis} lifts the bed too far by {error_ppm}"},
    Phrase{"screw_cyclic",
           "cyclic error of screw {axis}",
           "Screw {axis} errs by {amplitude_um} once per turn ({~period_mm})"},
    Phrase{"screw_backlash",
           "play of screw {axis}",
           "The nut of screw {axis} has {gap_mm} of play"},
    Phrase{"pivot_position",
           "place of screw {axis}",
           "Screw {axis} stands elsewhere than drawn, by {dx_mm} along X and {dy_mm} "
           "along Y"},
    Phrase{"motors_swapped",
           "motors {axis} swapped",
           "The motors {axis} are plugged into each other's drivers{ring}"},
    Phrase{"overconstrained_bed",
           "overconstrained bed",
           "Guides hold the bed level against its screws: stiffness ratio "
           "{stiffness_ratio_mm2}"},
    Phrase{"nozzle_temperature",
           "growth of the nozzle with its temperature",
           "The nozzle grows by {growth_um_per_k}, {~lag_s} behind its thermometer"},
    Phrase{"ooze",
           "ooze under the nozzle",
           "From {~flows_c} on {thickness_um} of plastic under the nozzle meet the "
           "switch before it does"},
    Phrase{"switch_offset",
           "wrong switch_offset",
           "The probe triggers {off_um} higher over its knob than switch_offset says"},
    Phrase{"station_change",
           "change of the {part}",
           "The {part} was changed at {~at_t_s}: it reaches {step_um} further"},
    Phrase{"bed_bowl",
           "bowl of the bed",
           "The bed is a bowl: its corners stand {height_um} higher than the middle"},
    Phrase{"bed_cylinder",
           "bend of the bed along {axis}",
           "The bed is bent along {axis}: its edges stand {height_um} higher than the "
           "middle"},
    Phrase{"bed_twist",
           "twist of the bed",
           "The bed is twisted by {height_um} at its corners"},
    Phrase{"block_size",
           "size of the artefact {part}",
           "The artefact {part} is not as certified: its size is off by {error_um}"}};

const Phrase* PhraseOf(std::string_view cause) {
  const auto* found = std::ranges::find(kPhrases, cause, &Phrase::cause);
  return found == kPhrases.end() ? nullptr : &*found;
}

std::string Capitals(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals) {
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return capitals;
}

// The unit of a parameter, as declared.
std::string UnitOf(std::string_view cause, std::string_view parameter) {
  const auto effect = FindEffect(cause);
  if (!effect) return "";
  for (const Parameter& one : EffectAt(*effect).parameters) {
    if (one.name == parameter) return std::string(one.unit);
  }
  return "";
}

// Two letters after the first stand for axes only in names such as EYX.
std::string LetterAt(std::string_view axis, std::size_t at) {
  if (axis.size() != 3) return Capitals(axis);
  // Of an angular error (EBX) the letters A B C turn about X Y Z.
  const char letter = axis[at];
  return {letter >= 'A' && letter <= 'C' ? static_cast<char>(letter + ('X' - 'A'))
                                         : letter};
}

// The two axes of a squareness: C0Y is Y against X, B0Z Z against X, A0Z Z against Y.
std::string PairOf(std::string_view axis) {
  if (axis == "C0Y") return "X and Y";
  if (axis == "B0Z") return "X and Z";
  return axis == "A0Z" ? "Y and Z" : Capitals(axis);
}

// Of all three motors exchanged: which screw each driver turns.
std::string RingOf(std::string_view axis) {
  if (axis.size() < 6) return "";
  const auto turned = MotorsSwapped::ScrewsTurned(axis);
  return fmt::format(" in a ring: the drivers of Z1, Z2, Z3 turn screws Z{}, Z{}, Z{}",
                     turned[0] + 1,
                     turned[1] + 1,
                     turned[2] + 1);
}

std::string ValueOf(const Finding& finding, std::string_view key) {
  const bool plain = key.starts_with('~');
  if (plain) key.remove_prefix(1);
  const auto found =
      std::ranges::find(finding.parameters, key, &FindingParameter::name);
  if (found == finding.parameters.end()) return "an unknown amount";
  const std::string unit = UnitOf(finding.cause, key);
  if (plain && key == "period_mm") return fmt::format("{:.2f} {}", found->value, unit);
  return WithSd(found->value, plain ? 0 : found->sd, unit);
}

std::string Filled(std::string_view text, const Finding& finding) {
  std::string filled;
  while (!text.empty()) {
    const std::size_t open = text.find('{');
    filled += text.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = text.find('}', open);
    const std::string_view key = text.substr(open + 1, close - open - 1);
    if (key == "axis") {
      filled += Capitals(finding.axis);
    } else if (key == "part") {
      filled += finding.axis;
    } else if (key == "ring") {
      filled += RingOf(finding.axis);
    } else if (key == "pair") {
      filled += PairOf(finding.axis);
    } else if (key == "to" || key == "by") {
      filled += LetterAt(finding.axis, key == "to" ? 1 : 2);
    } else {
      filled += ValueOf(finding, key);
    }
    text.remove_prefix(close + 1);
  }
  return filled;
}

std::string ChannelInWords(std::string_view channel) {
  if (channel == "probe") return "the probe";
  if (channel == "bed") return "the bed";
  if (channel == "nozzle") return "the nozzle";
  return fmt::format("the {} axis", Capitals(channel));
}

}  // namespace

std::string NameInWords(std::string_view cause, std::string_view axis) {
  if (cause == "unknown") {
    return fmt::format("something without a name in {}", ChannelInWords(axis));
  }
  const Finding bare{.cause = std::string(cause), .axis = std::string(axis)};
  if (const Phrase* phrase = PhraseOf(cause)) return Filled(phrase->name, bare);
  return axis.empty() ? std::string(cause) : fmt::format("{}.{}", cause, axis);
}

std::string WhatItDoes(const Finding& finding) {
  if (finding.cause != "unknown") {
    if (const Phrase* phrase = PhraseOf(finding.cause)) {
      return Filled(phrase->does, finding);
    }
    std::vector<std::string> sizes;
    for (const FindingParameter& p : finding.parameters) {
      sizes.push_back(fmt::format(
          "{} {}", p.name, WithSd(p.value, p.sd, UnitOf(finding.cause, p.name))));
    }
    return fmt::format(
        "{}: {}", NameInWords(finding.cause, finding.axis), fmt::join(sizes, ", "));
  }
  std::vector<std::string> covariates;
  for (const std::string& word : finding.covariates) {
    covariates.push_back(CovariateInWords(word, finding.is_by_order));
  }
  return fmt::format(
      "Something makes {} err by up to {} um that depends on {}; its shape fits no "
      "cause in the catalogue",
      ChannelInWords(finding.axis),
      TwoDigits(finding.peak_um),
      fmt::join(covariates, " and "));
}

std::string WhatToDo(const Finding& finding) {
  const auto effect = FindEffect(finding.cause);
  return effect ? std::string(EffectAt(*effect).words.action) : "";
}

std::string CovariateInWords(std::string_view word, bool is_by_order) {
  if (is_by_order && word == "t") return "the order of the rows";
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kWords = {{
      {"t", "time"},
      {"temp", "temperature"},
      {"feed", "feed"},
      {"load", "load"},
      {"since_rev", "travel since the reversal"},
      {"theta", "direction of touch"},
  }};
  for (const auto& [key, text] : kWords) {
    if (word == key) return std::string(text);
  }
  if (word.starts_with("dir_")) {
    return fmt::format("the sense of approach of {}", Capitals(word.substr(4)));
  }
  if (word.size() == 1) return fmt::format("position along {}", Capitals(word));
  return std::string(word);
}

std::string_view UnitOfCovariate(std::string_view word, bool is_by_order) {
  if (word == "t") return is_by_order ? " rows" : " s";
  if (word == "temp") return " K";
  if (word == "feed") return " mm/s";
  if (word == "load") return " N";
  if (word == "theta" || word.starts_with("dir_")) return "";
  return " mm";
}

std::string NextInWords(const NextCampaign& next) {
  std::string line = fmt::format("Measure next: {}", next.kind);
  std::vector<std::string> options;
  for (const auto& [option, word] : next.options) {
    options.push_back(fmt::format("{}: {}", option, word));
  }
  if (!options.empty()) line += fmt::format(" {{{}}}", fmt::join(options, ", "));
  if (next.minutes > 0)
    line += fmt::format(" ({:.0f} minutes)", std::ceil(next.minutes));
  if (next.separates == std::vector<std::string>{"unknown"}) {
    line += "; a minute of it shows most of the shape without a name";
  } else if (!next.separates.empty()) {
    line += fmt::format("; it tells {} apart", fmt::join(next.separates, " and "));
  }
  return line;
}

}  // namespace caltwin
