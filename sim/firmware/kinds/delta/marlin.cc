#include "sim/firmware/kinds/delta/marlin.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kTravel_mm_s = 80;
constexpr double kProbe_mm_s = 5;
constexpr double kClearance_mm = 5;
constexpr double kHoming_s = 12;
constexpr double kDeepest_mm = 50;  // Below the bed believed in: then it is past it.

// A letter that wants a number and has none: that of `M665 Lnan` reads as a bare L. 0:
// every one has its own.
char WithoutItsNumber(const GcodeCommand& command) {
  struct Wanting {
    char of;
    int code;
    std::string_view letters;
  };
  constexpr std::array kWanting = {Wanting{'M', 665, "LRHSXYZABC"},
                                   Wanting{'M', 666, "XYZ"},
                                   Wanting{'M', 851, "XYZ"},
                                   Wanting{'M', 421, "IJZ"},
                                   Wanting{'G', 0, "XYZF"},
                                   Wanting{'G', 1, "XYZF"},
                                   Wanting{'G', 30, "XY"},
                                   Wanting{'G', 33, "PCVR"}};
  for (const Wanting& wanting : kWanting) {
    if (!command.Is(wanting.of, wanting.code)) continue;
    for (const GcodeWord& word : command.words) {
      const bool is_asked = wanting.letters.find(word.letter) != std::string_view::npos;
      if (is_asked && word.kind != GcodeWord::Kind::kNumber) return word.letter;
    }
  }
  return 0;
}

Reply Refusal(const std::string& text) {
  return {.lines = {"Error:" + text}, .error = true};
}

// Where the nozzle is once homed: each carriage backs off to the lowest endstop.
double HomedHeight_mm(const DeltaModel<double>& model) {
  return std::ranges::min(model.endstop_mm);
}

}  // namespace

DeltaModel<double> AsMarlinHasIt(const DeltaModel<double>& settings) {
  DeltaModel<double> kept = settings;
  kept.radius_mm.fill(MeanOfTowers(settings.radius_mm));
  return kept;
}

MarlinDelta::MarlinDelta(const DeltaModel<double>& drawn,
                         const DeltaModel<double>& settings,
                         const std::array<double, 3>& steps_per_mm,
                         Plant* plant,
                         AutoCalibration g33)
    : drawn_(drawn),
      settings_(AsMarlinHasIt(settings)),
      stored_(settings_),
      height_mm_(HomedHeight_mm(settings)),
      steps_per_mm_(steps_per_mm),
      plant_(plant),
      g33_(std::move(g33)) {}

Reply MarlinDelta::Execute(std::string_view line) {
  GcodeLine parsed;
  try {
    parsed = ParseGcode(line);
  } catch (const InputError&) {
    return {.lines = {fmt::format("echo:Unknown command: \"{}\"", line)}};
  }
  if (parsed.is_meta) {
    return {.lines = {fmt::format("echo:Unknown command: \"{}\"", parsed.text)}};
  }
  Reply reply;
  for (const GcodeCommand& command : parsed.commands) {
    const Reply part = Obey(command);
    reply.lines.insert(reply.lines.end(), part.lines.begin(), part.lines.end());
    reply.error = reply.error || part.error;
  }
  return reply;
}

Reply MarlinDelta::Obey(const GcodeCommand& command) {
  if (const char letter = WithoutItsNumber(command); letter != 0) {
    return {
        .lines = {fmt::format(
            "?{}: no number after {}, nothing is changed", command.Name(), letter)}};
  }
  if (command.Is('G', 28)) return Home();
  if (command.Is('G', 30)) return Probe(command);
  if (command.Is('G', 0) || command.Is('G', 1)) return Move(command);
  if (command.Is('G', 33)) {
    if (!g33_) return Refusal("G33 is not compiled in");
    is_levelling_ = false;  // What it corrects the mesh no longer fits.
    const Reply reply{.lines = g33_(command, &settings_)};
    Take(settings_);
    return reply;
  }
  if (command.Is('M', 114)) return Position();
  if (command.Is('M', 665)) return SetGeometry(command);
  if (command.Is('M', 666)) return SetEndstops(command);
  if (command.Is('M', 851)) return SetProbeOffset(command);
  if (command.Is('M', 420)) return SwitchMesh(command);
  if (command.Is('M', 421)) return SetMeshPoint(command);
  if (command.code >= 500 && command.code <= 502 && command.letter == 'M') {
    return Keep(command.code);
  }
  if (command.Is('M', 503)) return Report();
  if (command.Is('M', 119)) return Switches();
  if (auto told = Tell(command)) return *std::move(told);
  if (command.Is('G', 90) || command.Is('G', 91)) {
    is_relative_ = command.code == 91;
    return {};
  }
  // The moves behind it would go elsewhere: not known is not enough.
  const bool shifts =
      command.Is('G', 92) &&
      (command.Number('X') || command.Number('Y') || command.Number('Z'));
  if (shifts || command.Is('G', 20) || command.Is('G', 2) || command.Is('G', 3)) {
    return Refusal(command.Name() + " is not part of this machine");
  }
  if (command.Is('G', 21) || command.Is('G', 92)) return {};
  return {.lines = {fmt::format("echo:Unknown command: \"{}\"", command.Name())}};
}

Reply MarlinDelta::Keep(int code) {
  if (code == 500) {
    stored_ = settings_;
    return {.lines = {"echo:Settings Stored (614 bytes; crc 0)"}};
  }
  Take(code == 501 ? stored_ : drawn_);
  return {.lines = {code == 501
                        ? "echo:V83 stored settings retrieved (614 bytes; crc 0)"
                        : "echo:Hardcoded Default Settings Loaded"}};
}

void MarlinDelta::Take(const DeltaModel<double>& settings) {
  settings_ = AsMarlinHasIt(settings);
  height_mm_ = HomedHeight_mm(settings_);
}

Motors MarlinDelta::StepsAt(const DeltaModel<double>& settings,
                            const Vec3<double>& nozzle_mm) const {
  Motors steps = DeltaMotors_mm(settings, nozzle_mm);
  for (int i = 0; i < kNumTowers; ++i) {
    steps[i] *= steps_per_mm_[static_cast<std::size_t>(i)];
  }
  return steps;
}

Outcome MarlinDelta::Go(const DeltaModel<double>& settings,
                        const Vec3<double>& from_mm,
                        const Vec3<double>& to_mm,
                        double feed_mm_s,
                        Watch::Kind until) {
  const Vec3<double> way_mm = to_mm - from_mm;
  const double length_mm = way_mm.norm();
  if (length_mm == 0) return {};
  const Vec3<double> along = way_mm / length_mm;
  const Segment segment{.from_steps = StepsAt(settings, from_mm),
                        .to_steps = StepsAt(settings, to_mm),
                        .profile = {.length_mm = length_mm,
                                    .feed_in_mm_s = feed_mm_s,
                                    .feed_top_mm_s = feed_mm_s,
                                    .feed_out_mm_s = feed_mm_s},
                        .curve = [&](double gone_mm) {
                          return StepsAt(settings, from_mm + gone_mm * along);
                        }};
  const Outcome outcome = plant_->Run(segment, {.kind = until});
  steps_ = segment.Steps(outcome.time_s).array().round();
  if (outcome.stopped) plant_->Settle(steps_);
  return outcome;
}

std::optional<Vec3<double>> MarlinDelta::Touch(const DeltaModel<double>& settings,
                                               double x_mm,
                                               double y_mm) {
  const Vec3<double> above(x_mm, y_mm, HomedHeight_mm(settings));
  const Vec3<double> below(x_mm, y_mm, -kDeepest_mm);
  if (!StepsAt(settings, above).allFinite()) return std::nullopt;
  const Outcome outcome =
      Go(settings, above, below, kProbe_mm_s, Watch::Kind::kProbeTriggered);
  if (!outcome.stopped) return std::nullopt;
  Vec3<double> counted_mm = steps_;
  for (int i = 0; i < kNumTowers; ++i) {
    counted_mm[i] /= steps_per_mm_[static_cast<std::size_t>(i)];
  }
  const Vec3<double> stopped_mm = DeltaNozzle_mm(settings, counted_mm);
  Go(settings, stopped_mm, stopped_mm + kClearance_mm * Unit(Axis::kZ), kProbe_mm_s);
  if (witness_) witness_(settings, counted_mm);
  return counted_mm;
}

// Each carriage up to its endstop.
Reply MarlinDelta::Home() {
  const double most_steps = std::max(steps_.maxCoeff(), 1.0);
  plant_->Run({.from_steps = steps_,
               .to_steps = steps_.array() - most_steps,
               .profile = {.length_mm = most_steps / steps_per_mm_[0],
                           .feed_in_mm_s = kTravel_mm_s,
                           .feed_top_mm_s = kTravel_mm_s,
                           .feed_out_mm_s = kTravel_mm_s}},
              {.kind = Watch::Kind::kSwitchClosed});
  steps_.setZero();
  plant_->Settle(steps_);
  at_mm_ = {0, 0, height_mm_};
  is_homed_ = true;
  time_s_ += kHoming_s;
  return Position();
}

Reply MarlinDelta::Probe(const GcodeCommand& command) {
  if (!is_homed_) return Refusal("Home XYZ first");
  const double x = command.Number('X').value_or(at_mm_[0]);
  const double y = command.Number('Y').value_or(at_mm_[1]);
  // The tip goes there, the nozzle beside.
  const double nozzle_x = x - probe_offset_mm_[0], nozzle_y = y - probe_offset_mm_[1];
  const auto motors = Touch(settings_, nozzle_x, nozzle_y);
  if (!motors) return {.lines = {"Z Probe Past Bed"}};
  const double z = DeltaNozzle_mm(settings_, *motors)[2] + probe_offset_mm_[2];
  const Vec3<double> above(nozzle_x, nozzle_y, z - probe_offset_mm_[2] + kClearance_mm);
  time_s_ += (above - at_mm_).norm() / kTravel_mm_s + 2 * kClearance_mm / kProbe_mm_s;
  at_mm_ = above;
  ++touches_;
  Reply reply{.lines = {fmt::format("Bed X: {:.2f} Y: {:.2f} Z: {:.3f}", x, y, z)}};
  return reply;
}

Reply MarlinDelta::Move(const GcodeCommand& command) {
  if (!is_homed_) return Refusal("Home XYZ first");
  Vec3<double> to = at_mm_;
  constexpr std::string_view kLetters = "XYZ";
  for (int i = 0; i < 3; ++i) {
    const auto word_mm = command.Number(kLetters[static_cast<std::size_t>(i)]);
    if (word_mm) to[i] = is_relative_ ? to[i] + *word_mm : *word_mm;
  }
  const Vec3<double> travel_mm = DeltaMotors_mm(settings_, to);
  if (!travel_mm.allFinite() || travel_mm.minCoeff() < -kAtEnd_mm) {
    return Refusal("Destination out of reach");  // Of the rods, or above the endstops.
  }
  Go(settings_, at_mm_, to, kTravel_mm_s);
  time_s_ += (to - at_mm_).norm() / kTravel_mm_s;
  at_mm_ = to;
  return {};
}

Reply MarlinDelta::SetGeometry(const GcodeCommand& command) {
  if (command.words.empty()) return {.lines = GeometryLines()};
  const double arm = MeanOfTowers(settings_.arm_mm);
  const double new_arm = command.Number('L').value_or(arm);
  const double new_height = command.Number('H').value_or(height_mm_);
  const double radius = command.Number('R').value_or(settings_.radius_mm[0]);
  DeltaModel<double> model = settings_;
  for (std::size_t i = 0; i < 3; ++i) {
    model.endstop_mm[i] += new_height - height_mm_;
    model.radius_mm[i] = radius;
    const double trim = command.Number("ABC"[i]).value_or(model.arm_mm[i] - arm);
    model.arm_mm[i] = new_arm + trim;
    if (const auto degrees = command.Number("XYZ"[i])) {
      model.angle_rad[i] = drawn_.angle_rad[i] + RadFromDeg(*degrees);
    }
    if (!(radius > 0 && model.arm_mm[i] > radius && model.arm_mm[i] < 1e5)) {
      return Refusal("a rod must be longer than the radius");
    }
  }
  settings_ = model;
  height_mm_ = new_height;
  is_homed_ = false;
  return {};
}

Reply MarlinDelta::SetEndstops(const GcodeCommand& command) {
  if (command.words.empty()) return {.lines = GeometryLines()};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto below = command.Number("XYZ"[i]);
    // A carriage backs off from its endstop, never beyond it: Marlin ignores the rest.
    if (below && *below <= 0) settings_.endstop_mm[i] = height_mm_ - *below;
  }
  is_homed_ = false;
  return {};
}

Reply MarlinDelta::SetProbeOffset(const GcodeCommand& command) {
  constexpr std::array kMost_mm = {50.0, 50.0, 20.0};
  Vec3<double> offset_mm = probe_offset_mm_;
  for (int i = 0; i < 3; ++i) {
    const char letter = "XYZ"[i];
    const double most_mm = kMost_mm[static_cast<std::size_t>(i)];
    offset_mm[i] = command.Number(letter).value_or(offset_mm[i]);
    if (std::abs(offset_mm[i]) <= most_mm) continue;
    return {.lines = {fmt::format("?{0} out of range (-{1} to {1})", letter, most_mm)}};
  }
  probe_offset_mm_ = offset_mm;
  return {.lines = {fmt::format("Probe Offset X{:.2f} Y{:.2f} Z{:.2f}",
                                offset_mm[0],
                                offset_mm[1],
                                offset_mm[2])}};
}

Reply MarlinDelta::SwitchMesh(const GcodeCommand& command) {
  if (const auto on = command.Number('S')) is_levelling_ = *on != 0;
  return {.lines = {fmt::format("echo:Bed Leveling {}", is_levelling_ ? "ON" : "OFF"),
                    "echo:Fade Height OFF"}};
}

Reply MarlinDelta::SetMeshPoint(const GcodeCommand& command) {
  const auto column = command.Number('I'), row = command.Number('J');
  const auto height_mm = command.Number('Z');
  if (!column || !row || !height_mm) {
    return Refusal("M421 incorrect parameter usage");
  }
  const auto is_node = [](double index) {
    return index >= 0 && index < kMeshNodes && index == std::floor(index);
  };
  if (!is_node(*column) || !is_node(*row)) return Refusal("Mesh point out of range");
  const int node = static_cast<int>(*row) * kMeshNodes + static_cast<int>(*column);
  mesh_.height_mm[static_cast<std::size_t>(node)] = *height_mm;
  return {};
}

}  // namespace caltwin
