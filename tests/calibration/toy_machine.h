#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/link/gcode.h"
#include "sim/link/link.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"

namespace caltwin::testing {

/// A rigid machine in closed form, for tests of what calibration says on the wire: per
/// axis a true scale, a play and a pre-travel; boxes to be touched; nothing else. No
/// step of its code is shared with the twin.
class ToyMachine final : public Link, public Gauge, public Operator {
 public:
  struct Drive {
    double true_steps_per_mm = 800;
    double gap_mm = 0;
    double pretravel_mm = 0.02;
  };
  Machine machine{};
  std::array<Drive, 3> drives{};
  Settings settings{};
  std::vector<Artefact> artefacts{};
  double tip_radius_mm = 1;
  double hysteresis_mm = 0.002;
  double latency_s = 0;
  double table_slope_x = 0;  ///< dz/dx of the table; what stands on it stays upright.
  bool confirms = true;
  std::function<double()> noise_mm = [] {
    return 0.0;
  };
  std::vector<std::string> log{};      ///< Every line received.
  std::vector<std::string> written{};  ///< sys/nxt-user-vars.g.
  std::vector<Act> acts{};
  std::map<std::string, std::string> globals{};

  ToyMachine() {
    for (std::size_t i = 0; i < 3; ++i) {
      AxisDrawing& axis = machine.axes[i];
      if (i == 2)
        axis = {.max_mm = 120, .home = HomeEnd::kMax, .counterbalance_n = 58.86};
      settings.steps_per_mm[i] = 800;
    }
    machine.settings = settings;
  }

  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    log.emplace_back(line);
    if (halted_) return Fault(MachineFault::Kind::kAlarm, "Error: stopped, send M999");
    if (line.starts_with("echo") || line.starts_with("set ") ||
        line.starts_with("global ")) {
      return Meta(std::string(line));
    }
    const GcodeLine parsed = ParseGcode(line);
    std::vector<std::string> lines;
    for (const GcodeCommand& command : parsed.commands) {
      auto reply = Obey(command);
      if (!reply) return reply;
      lines.insert(lines.end(), reply->begin(), reply->end());
    }
    return lines;
  }

  Expected<double> Read_mm(std::string_view id) override {
    const std::string name(id);
    const std::size_t axis = static_cast<std::size_t>(name.back() - 'x');
    if (name.starts_with("laser.")) return carriage_mm_[axis] + noise_mm();
    if (name.starts_with("dial.")) {
      return carriage_mm_[axis] - dial_zero_mm_[axis] + noise_mm();
    }
    if (name == "calliper.tip") return 2 * tip_radius_mm;
    return Refused("no such gauge: " + name);
  }
  Expected<void> Zero(std::string_view id) override {
    const std::size_t axis = static_cast<std::size_t>(id.back() - 'x');
    dial_zero_mm_[axis] = carriage_mm_[axis];
    return {};
  }
  Expected<void> Do(const Act& act) override {
    acts.push_back(act);
    if (act.kind == Act::Kind::kConfirm && !confirms) return Refused("no");
    for (Artefact& artefact : artefacts) {
      if (act.kind != Act::Kind::kTurnBlock || artefact.id != act.artefact) continue;
      artefact.size_mm =
          BlockLying(*AxisNamed(std::string(1, act.axis)), act.length_mm);
    }
    return {};
  }

 private:
  using Reply = Expected<std::vector<std::string>>;
  static tl::unexpected<MachineFault> Refused(const std::string& text) {
    return tl::unexpected(
        MachineFault{.kind = MachineFault::Kind::kRefused, .reply = text});
  }
  Reply Fault(MachineFault::Kind kind, const std::string& text) {
    if (kind == MachineFault::Kind::kAlarm) halted_ = true;
    return tl::unexpected(MachineFault{.kind = kind, .reply = text});
  }

  Reply Meta(const std::string& line) {
    if (line.starts_with("echo >")) {
      if (!line.starts_with("echo >>")) written.clear();
      const std::size_t close = line.find('"', line.find('"') + 1);
      const std::size_t from = line.find('"', close + 1) + 1;
      written.push_back(line.substr(from, line.rfind('"') - from));
      return Reply{};
    }
    if (line.starts_with("echo global.")) {
      const auto found = globals.find(line.substr(12));
      if (found == globals.end()) return Refused("Error: unknown variable");
      return std::vector<std::string>{found->second};
    }
    const bool set = line.starts_with("set global.");
    const std::size_t from = set ? 11 : 7;
    const std::size_t equals = line.find(" = ");
    const std::string name = line.substr(from, equals - from);
    if (set != globals.contains(name)) return Refused("Error: variable");
    globals[name] = line.substr(equals + 3);
    return Reply{};
  }

  Reply Obey(const GcodeCommand& command) {
    if (command.letter == 'M') return ObeyM(command);
    if (command.Is('G', 28)) return Home();
    if (command.Is('G', 38, 2)) return Probe(command, true);
    if (command.Is('G', 38, 4)) return Probe(command, false);
    if (command.Is('G', 0) || command.Is('G', 1)) return Travel(command);
    return Reply{};
  }

  Reply ObeyM(const GcodeCommand& command) {
    if (command.code == 92 || command.code == 425) {
      auto& values = command.code == 92 ? settings.steps_per_mm : settings.backlash_mm;
      for (std::size_t i = 0; i < 3; ++i) {
        if (const GcodeWord* word = command.Find("XYZ"[i])) values[i] = word->number;
      }
      if (!command.words.empty()) return Reply{};
      return std::vector<std::string>{
          fmt::format("{}: X: {:.3f}, Y: {:.3f}, Z: {:.3f}",
                      command.code == 92 ? "Steps/mm" : "Backlash correction (mm)",
                      values[0],
                      values[1],
                      values[2])};
    }
    if (command.code == 114) {
      return std::vector<std::string>{
          fmt::format("X:0 Y:0 Z:0 E:0 Count {} {} {} Machine 0 0 0",
                      count_[0],
                      count_[1],
                      count_[2])};
    }
    if (command.code == 409) {
      return std::vector<std::string>{homed_ ? R"({"result":[true,true,true]})"
                                             : R"({"result":[false,false,false]})"};
    }
    return Reply{};
  }

  Reply Home() {
    homed_ = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const AxisDrawing& axis = machine.axes[i];
      const double sense = axis.home == HomeEnd::kMin ? -1 : 1;
      carriage_mm_[i] = axis.home_mm();
      motor_mm_[i] = axis.home_mm() + sense * drives[i].gap_mm / 2;
      offset_mm_[i] = motor_mm_[i] - axis.home_mm();
      count_[i] = std::lround(axis.home_mm() * settings.steps_per_mm[i]);
      sense_[i] = sense;
      applied_mm_[i] = 0;
    }
    return Reply{};
  }

  /// Where the motor of axis i stands when the controller believes `q_mm`, having moved
  /// in `sense`: scale about home, and the compensation for its sense.
  double MotorFor(std::size_t i, double q_mm) const {
    const double home_mm = machine.axes[i].home_mm();
    const double k = settings.steps_per_mm[i] / drives[i].true_steps_per_mm;
    return home_mm + offset_mm_[i] + k * (q_mm - home_mm) + applied_mm_[i];
  }
  double Believed(std::size_t i) const {
    return static_cast<double>(count_[i]) / settings.steps_per_mm[i];
  }
  void Compensate(std::size_t i, double to_mm) {
    const double sense = to_mm > Believed(i) ? 1 : -1;
    if (to_mm == Believed(i) || sense == sense_[i]) return;
    sense_[i] = sense;
    applied_mm_[i] += sense * settings.backlash_mm[i];
  }
  void DriveTo(std::size_t i, double motor_mm) {
    const double half_mm = drives[i].gap_mm / 2;
    motor_mm_[i] = motor_mm;
    carriage_mm_[i] =
        std::clamp(carriage_mm_[i], motor_mm - half_mm, motor_mm + half_mm);
  }
  std::array<double, 3> Targets(const GcodeCommand& command) const {
    std::array<double, 3> target{Believed(0), Believed(1), Believed(2)};
    for (std::size_t i = 0; i < 3; ++i) {
      if (const GcodeWord* word = command.Find("XYZ"[i])) target[i] = word->number;
    }
    return target;
  }

  /// How deep the ball's centre is inside what is solid to it; negative in the air.
  /// Along the nearest face only: enough for touches far from edges.
  double Depth(const std::array<double, 3>& p) const {
    double deepest_mm = tip_radius_mm - (p[2] - table_slope_x * p[0]);  // The table.
    for (const Artefact& artefact : artefacts) {
      double depth_mm = 1e9;
      for (std::size_t i = 0; i < 3; ++i) {
        const int axis = static_cast<int>(i);
        const double middle_mm =
            artefact.at_mm[axis] + (i == 2 ? artefact.size_mm[2] / 2 : 0);
        depth_mm = std::min(
            depth_mm,
            artefact.size_mm[axis] / 2 + tip_radius_mm - std::abs(p[i] - middle_mm));
      }
      deepest_mm = std::max(deepest_mm, depth_mm);
    }
    return deepest_mm;
  }

  Reply Travel(const GcodeCommand& command) {
    const auto target = Targets(command);
    std::array<double, 3> from = carriage_mm_;
    for (std::size_t i = 0; i < 3; ++i) {
      if (target[i] < machine.axes[i].min_mm - 1e-6 ||
          target[i] > machine.axes[i].max_mm + 1e-6) {
        return Fault(MachineFault::Kind::kRefused,
                     "Error: G1: target position outside machine limits");
      }
      Compensate(i, target[i]);
      count_[i] = std::lround(target[i] * settings.steps_per_mm[i]);
      DriveTo(i, MotorFor(i, Believed(i)));
    }
    for (int part = 1; part <= 200; ++part) {
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = from[i] + (carriage_mm_[i] - from[i]) * part / 200;
      }
      if (Depth(p) > machine.probe.overtravel_mm) {
        return Fault(MachineFault::Kind::kAlarm,
                     "Error: the stylus was bent beyond its overtravel");
      }
    }
    return Reply{};
  }

  /// One axis at a time: finds where the depth crosses the trigger by halving.
  Reply Probe(const GcodeCommand& command, bool towards) {
    const auto target = Targets(command);
    std::size_t i = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      if (command.Find("XYZ"[j]) != nullptr) i = j;
    }
    const double from_mm = Believed(i);
    Compensate(i, target[i]);
    const double start_mm = MotorFor(i, from_mm);
    const double end_mm = MotorFor(i, target[i]);
    const double level_mm =
        drives[i].pretravel_mm + noise_mm() - (towards ? 0 : hysteresis_mm);
    const auto in_contact = [&](double share) {
      const auto kept = carriage_mm_;
      const double motor = start_mm + share * (end_mm - start_mm);
      const double half_mm = drives[i].gap_mm / 2;
      auto p = kept;
      p[i] = std::clamp(kept[i], motor - half_mm, motor + half_mm);
      return Depth(p) > level_mm;
    };
    double low = 0, high = -1;
    for (int part = 1; part <= 400 && high < 0; ++part) {
      if (in_contact(part / 400.0) == towards)
        high = part / 400.0;
      else
        low = part / 400.0;
    }
    if (high < 0) {
      return Fault(MachineFault::Kind::kRefused,
                   "Error: G38: Probe was not triggered during probing move");
    }
    for (int n = 0; n < 60; ++n) {
      const double middle = (low + high) / 2;
      (in_contact(middle) == towards ? high : low) = middle;
    }
    const GcodeWord* feed = command.Find('F');
    const double late_mm =
        latency_s * (feed == nullptr ? 0 : FeedFromWord_mm_s(feed->number));
    const double sense = target[i] > from_mm ? 1 : -1;
    const double at_mm = from_mm + high * (target[i] - from_mm) + sense * late_mm;
    count_[i] = std::lround(at_mm * settings.steps_per_mm[i]);
    DriveTo(i, MotorFor(i, Believed(i)));
    return Reply{};
  }

  std::array<double, 3> motor_mm_{}, carriage_mm_{}, offset_mm_{}, applied_mm_{};
  std::array<double, 3> dial_zero_mm_{}, sense_{};
  std::array<std::int64_t, 3> count_{};
  bool homed_ = false;
  bool halted_ = false;
};

}  // namespace caltwin::testing
