// Causes that no library has: the honest answers are "unknown" and, where it depends on
// the position of one axis alone, a free-form map.

#include <algorithm>
#include <cmath>

#include "tests/blind/causes.h"

namespace blind {
namespace {

std::vector<CampaignRequest> Line(const std::string& axis) {
  const int a = AxisIndex(axis);
  return {{.kind = "iso230", .axis = a}, {.kind = "iso230", .axis = 1 - a}};
}

std::vector<CampaignRequest> Alternating(const std::string& axis) {
  return {{.kind = "alternating", .axis = AxisIndex(axis)}, {.kind = "blocks"}};
}

std::vector<CampaignRequest> Plates(const std::string&) {
  return {{.kind = "plate"}, {.kind = "plate_turned_90"}};
}

std::vector<CampaignRequest> DenseLine(const std::string& axis) {
  const int a = AxisIndex(axis);
  return {{.kind = "dense", .axis = a}, {.kind = "iso230", .axis = a}};
}

template <typename Shape>
Defect OnAxis(const std::string& cause, const std::string& axis, const Shape& shape) {
  const int a = AxisIndex(axis);
  Defect defect{.cause = cause, .axis = axis};
  defect.motion = [=](const Instant& now) {
    return kMmPerUm * shape(now, static_cast<std::size_t>(a)) * Along(a);
  };
  return defect;
}

/// A stretch of screw where the nut rides up: a lopsided hump in one place.
Defect DeadSpot(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(AxisIndex(axis));
  const double center = at.random->Uniform(-0.6, 0.6);
  const double width = at.random->Uniform(0.12, 0.25);
  return OnAxis("dead_spot", axis, [=](const Instant& now, std::size_t a) {
    const double u = (drawing.Scaled(now.q_mm[a]) - center) / width;
    return u < -1 || u > 2 ? 0.0 : (u < 0 ? 1 + u : 1 - u / 2);
  });
}

/// Position error that grows as a logarithm from the home end.
Defect LogPosition(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(AxisIndex(axis));
  const double scale_mm = at.random->Uniform(5, 15);
  return OnAxis("log_position", axis, [=](const Instant& now, std::size_t a) {
    return std::log(1 + (now.q_mm[a] - drawing.min_mm) / scale_mm);
  });
}

/// The carriage sticks and slips: a sawtooth in the travel since the reversal, its
/// teeth all of different length.
Defect StickSlip(const std::string& axis, const Circumstances& at) {
  std::vector<double> teeth_mm = {0};
  while (teeth_mm.back() < 1200) {
    teeth_mm.push_back(teeth_mm.back() + at.random->Uniform(1.2, 6));
  }
  return OnAxis("stick_slip", axis, [=](const Instant& now, std::size_t a) {
    const double d = std::min(now.since_rev_mm[a], 1190.0);
    const auto next = std::ranges::upper_bound(teeth_mm, d);
    const double from = *(next - 1);
    return -now.dir[a] * (d - from) / (*next - from);
  });
}

/// The scale wanders with time: position times time.
Defect PositionTimesTime(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(AxisIndex(axis));
  const double duration_s = at.weather.duration_s();
  return OnAxis("x_times_t", axis, [=](const Instant& now, std::size_t a) {
    return drawing.Scaled(now.q_mm[a]) * std::sin(3 * now.t_s / duration_s);
  });
}

/// The gap opens while the machine is used: a twin of nothing in the catalogue.
Defect PlayGrows(const std::string& axis, const Circumstances& at) {
  const double duration_s = at.weather.duration_s();
  return OnAxis("play_grows", axis, [=](const Instant& now, std::size_t a) {
    return -0.5 * now.dir[a] * now.t_s / duration_s;
  });
}

std::vector<CampaignRequest> LongRun(const std::string& axis) {
  return {{.kind = "drift", .axis = AxisIndex(axis)}};
}

/// The whole frame creeps along an axis with time; the catalogue's growth is upwards.
Defect FrameCreep(const std::string& axis, const Circumstances& at) {
  const double tau_s = at.random->LogUniform(1500, 5000);
  return OnAxis("frame_creep", axis, [=](const Instant& now, std::size_t) {
    return 1 - std::exp(-now.t_s / tau_s);
  });
}

/// A dent in the plate, off its middle.
Defect Dent(const std::string& axis, const Circumstances& at) {
  const Drawing drawing = at.drawing;
  const double x = at.random->Uniform(-0.5, 0.5);
  const double y = at.random->Uniform(-0.5, 0.5);
  const double radius = at.random->Uniform(0.35, 0.5);
  const Vector3 middle = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  Defect defect{.cause = "dent", .axis = axis};
  defect.surface = [=](const Instant& now) {
    if (now.artefact != "plate") return 0.0;
    const Vector3 own = TurnedAboutZ(now.point_mm - middle, -now.turn_rad);
    const double d = std::hypot(own[0] / drawing.axis(0).Half_mm() - x,
                                own[1] / drawing.axis(1).Half_mm() - y);
    return d > radius ? 0.0 : -kMmPerUm * (1 - d / radius);
  };
  return defect;
}

/// The sensor hears something for a while: readings of one stretch of time stand off by
/// an amount that jumps about.
Defect SensorGlitch(const std::string& axis, const Circumstances& at) {
  const auto count = static_cast<double>(at.times_s.size());
  const auto first = static_cast<std::size_t>(count * at.random->Uniform(0.2, 0.6));
  const double from_s = at.times_s[first];
  const double to_s = at.times_s[first + static_cast<std::size_t>(0.12 * count)];
  const double rate = at.random->Uniform(1.3, 2.9);
  Defect defect{.cause = "sensor_glitch", .axis = axis};
  defect.reading = [=](const Instant& now) {
    if (now.t_s < from_s || now.t_s > to_s) return 0.0;
    return kMmPerUm * std::sin(rate * now.t_s * now.t_s);
  };
  return defect;
}

/// A rack's joints: a step up, a step down, nowhere regular.
Defect Steps(const std::string& axis, const Circumstances& at) {
  const AxisDrawing drawing = at.drawing.axis(AxisIndex(axis));
  const double up = at.random->Uniform(-0.6, -0.1);
  const double down = at.random->Uniform(0.1, 0.6);
  return OnAxis("rack_joints", axis, [=](const Instant& now, std::size_t a) {
    const double u = drawing.Scaled(now.q_mm[a]);
    return u > up && u < down ? 1.0 : 0.0;
  });
}

}  // namespace

const std::vector<Cause>& OutsideCauses() {
  static const std::vector<std::string> xy = {"x", "y"};
  static const std::vector<Cause> causes = {
      {"dead_spot", xy, Line, DeadSpot, 10, 0, {"pitch_map"}, {"q"}},
      {"log_position",
       xy,
       Line,
       LogPosition,
       10,
       0,
       {"pitch_map", "pitch_progressive"},
       {"q"}},
      {"stick_slip", xy, DenseLine, StickSlip, 10, 0, {}, {"since_rev", "dir"}},
      {"x_times_t", xy, Line, PositionTimesTime, 10, 0, {}, {"q", "t"}},
      {"play_grows", xy, Alternating, PlayGrows, 10, 0, {}, {"dir", "t"}},
      {"frame_creep", xy, LongRun, FrameCreep, 10, 0, {}, {"t", "temp"}},
      {"dent", {""}, Plates, Dent, 10, 0, {}, {"x", "y"}},
      {"sensor_glitch", {""}, Alternating, SensorGlitch, 10, 0, {}, {"t"}},
      {"rack_joints", xy, Line, Steps, 10, 0, {"pitch_map"}, {"q"}}};
  return causes;
}

}  // namespace blind
