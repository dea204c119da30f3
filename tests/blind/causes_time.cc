// What changes with time and temperature, and between homings.

#include <cmath>
#include <memory>

#include "tests/blind/causes.h"

namespace blind {
namespace {

std::vector<CampaignRequest> LongRun(const std::string& axis) {
  return {{.kind = "drift", .axis = axis == "y" ? 1 : 0}};
}

std::vector<CampaignRequest> LongRunAndLine(const std::string& axis) {
  const int a = AxisIndex(axis);
  return {{.kind = "drift", .axis = a}, {.kind = "iso230", .axis = a}};
}

/// A temperature after two lags in a row, as metal behind metal has it.
std::shared_ptr<const History> TwiceLagged(const Weather& weather,
                                           Thermometer which,
                                           double lag_s) {
  History history = Lag(weather.Lagged(which, lag_s), 0.12 * lag_s);
  return std::make_shared<const History>(std::move(history));
}

/// The screw grows from its fixed end: dq = a (q - home) (T - T0), size 1: 1 um/(m K).
Defect ThermalScrew(const std::string& axis, const Circumstances& at) {
  const auto a = static_cast<std::size_t>(AxisIndex(axis));
  const AxisDrawing drawing = at.drawing.axes[a];
  const double lag_s = at.random->LogUniform(200, 1200);
  const double uneven = at.random->Uniform(-0.1, 0.1);
  const auto heat_k = TwiceLagged(at.weather, kScrew, lag_s);
  Defect defect{.cause = "thermal_screw", .axis = axis};
  defect.parameters = {{"expansion_um_per_m_k", 1}, {"lag_s", lag_s, false}};
  defect.motion = [=](const Instant& now) {
    const double along_mm = now.q_mm[a] - drawing.min_mm;
    const double stretch = 1e-6 * (1 + uneven * drawing.Scaled(now.q_mm[a]));
    return stretch * along_mm * heat_k->At(now.t_s) * Along(static_cast<int>(a));
  };
  return defect;
}

/// The tool is lifted by 1 um (1 - exp(-t / tau)), with a slower part.
Defect FrameGrowth(const std::string& axis, const Circumstances& at) {
  const double tau_s = at.random->LogUniform(1200, 4500);
  const double slow = at.random->Uniform(0, 0.12);
  const double sign = at.random->Sign();
  Defect defect{.cause = "frame_growth", .axis = axis};
  defect.parameters = {{"growth_um", sign}, {"tau_s", tau_s, false}};
  defect.motion = [=](const Instant& now) {
    const double growth = 1 - (1 - slow) * std::exp(-now.t_s / tau_s) -
                          slow * std::exp(-now.t_s / (2.5 * tau_s));
    return sign * kMmPerUm * growth * Along(2);
  };
  return defect;
}

/// A warm frame lifts the tool (touches read -); a warm bed raises what stands on it
/// (touches of its top read +). Size 1: 1 um/K.
Defect FrameTemperature(const std::string& axis, const Circumstances& at) {
  const bool is_bed = axis == "bed";
  const double lag_s = at.random->LogUniform(150, 1200);
  const double sign = at.random->Sign();
  const auto heat_k = TwiceLagged(at.weather, is_bed ? kBed : kFrame, lag_s);
  Defect defect{.cause = "frame_temperature", .axis = axis};
  defect.parameters = {{"growth_um_per_k", sign}, {"lag_s", lag_s, false}};
  if (is_bed) {
    defect.surface = [=](const Instant& now) {
      return sign * kMmPerUm * heat_k->At(now.t_s) * now.n[2];
    };
  } else {
    defect.motion = [=](const Instant& now) {
      return sign * kMmPerUm * heat_k->At(now.t_s) * Along(2);
    };
  }
  return defect;
}

/// The probe triggers later as it warms: every face reads -k (T - T0). 1 um/K.
Defect ProbeTemperature(const std::string& axis, const Circumstances& at) {
  const double lag_s = at.random->LogUniform(60, 600);
  const double sign = at.random->Sign();
  const auto heat_k = TwiceLagged(at.weather, kScrew, lag_s);
  Defect defect{.cause = "probe_temperature", .axis = axis};
  defect.parameters = {{"drift_um_per_k", sign}, {"lag_s", lag_s, false}};
  defect.pretravel = [=](const Instant& now) {
    return sign * kMmPerUm * heat_k->At(now.t_s);
  };
  return defect;
}

std::vector<CampaignRequest> RepeatedDatum(const std::string& axis) {
  return {{.kind = "alternating", .axis = AxisIndex(axis)},
          {.kind = "iso230", .axis = AxisIndex(axis)}};
}

/// The axis stands 1 um further to + from some moment on, until it is homed.
Defect MissedSteps(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  std::vector<double> chances_s;
  for (std::size_t i = 0; i < at.plan.stops.size(); ++i) {
    if (at.plan.stops[i].campaign.rfind("alternating", 0) == 0) {
      chances_s.push_back(at.times_s[i]);
    }
  }
  if (chances_s.empty()) chances_s = at.times_s;
  const auto place = static_cast<std::size_t>(at.random->Uniform(0.15, 0.85) *
                                              static_cast<double>(chances_s.size()));
  const double at_t_s = chances_s[place] - 3;
  const double sign = at.random->Sign();
  Defect defect{.cause = "missed_steps", .axis = axis};
  defect.parameters = {{"jump_um", sign}, {"at_t_s", at_t_s, false}};
  defect.motion = [=](const Instant& now) {
    const bool jumped = now.t_s >= at_t_s && now.homed_t_s < at_t_s;
    return jumped ? sign * kMmPerUm * Along(a) : Vector3{};
  };
  return defect;
}

std::vector<CampaignRequest> Rehoming(const std::string&) {
  return {{.kind = "rehoming"}};
}

/// Each homing finds its zero anew, with a standard deviation of 1 um; a little more
/// peaked than normal.
Defect HomingScatter(const std::string& axis, const Circumstances& at) {
  const int a = AxisIndex(axis);
  std::vector<double> offsets;
  for (int i = 0; i < 64; ++i) {
    offsets.push_back(0.8 * at.random->Normal() + at.random->Uniform(-1, 1));
  }
  Defect defect{.cause = "homing_scatter", .axis = axis};
  defect.parameters = {{"sd_um", std::sqrt(0.64 + 1.0 / 3)}};
  defect.motion = [=](const Instant& now) {
    return kMmPerUm * offsets[static_cast<std::size_t>(now.home % 64)] * Along(a);
  };
  return defect;
}

}  // namespace

std::vector<Cause> TimeCauses() {
  const std::vector<std::string> xy = {"x", "y"};
  return {{"thermal_screw", xy, LongRunAndLine, ThermalScrew, 8},
          {"frame_growth", {""}, LongRun, FrameGrowth, 15},
          {"frame_temperature", {"frame", "bed"}, LongRun, FrameTemperature, 4},
          {"probe_temperature", {""}, LongRun, ProbeTemperature, 1},
          {"missed_steps", xy, RepeatedDatum, MissedSteps, 15},
          {"homing_scatter", {"x", "y", "z"}, Rehoming, HomingScatter, 10}};
}

}  // namespace blind
