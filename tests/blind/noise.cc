#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/blind/case.h"

namespace blind {
namespace {

const Noise& NoiseOf(const Case& made, const Reading& reading) {
  const Kind kind = reading.stop->kind;
  return made.instruments.at(kind == Kind::kTouch    ? "probe"
                             : kind == Kind::kRadial ? "ballbar"
                                                     : "laser");
}

/// What the firmware reports of a trigger: step counts of the axes that moved.
double Reported_mm(const Case& made, const Reading& reading, double noise_mm) {
  const Stop& stop = *reading.stop;
  double along_mm = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double steps_per_mm = made.drawing.axes[i].StepsPerMm();
    const double offset_mm = stop.offset_mm[i];
    // value = s: the commanded tip centre stands R_cfg + s outside the nominal point.
    const double q_mm =
        stop.at_mm[i] - offset_mm +
        (made.drawing.tip_radius_cfg_mm + reading.value_mm + noise_mm) * stop.n[i];
    const double counted_mm = std::round(q_mm * steps_per_mm) / steps_per_mm;
    along_mm += (counted_mm + offset_mm - stop.at_mm[i]) * stop.n[i];
  }
  return along_mm - made.drawing.tip_radius_cfg_mm;
}

}  // namespace

double Sigma_mm(const Case& made, const Reading& reading) {
  const Noise& noise = NoiseOf(made, reading);
  double resolution_mm = noise.resolution_mm;
  if (reading.stop->kind == Kind::kTouch) {
    const std::size_t main = std::abs(reading.stop->n[2]) > 0.7 ? 2 : 0;
    resolution_mm = 1 / made.drawing.axes[main].StepsPerMm();
  }
  return std::sqrt(noise.sigma_mm * noise.sigma_mm +
                   resolution_mm * resolution_mm / 12);
}

void AddNoise(Case* made) {
  Random random(made->request.seed, "noise");
  Random wild(made->request.seed, "outliers");
  for (Reading& reading : made->readings) {
    const Noise& noise = NoiseOf(*made, reading);
    const double noise_mm = noise.sigma_mm * random.Normal();
    if (reading.stop->kind == Kind::kTouch) {
      reading.value_mm = Reported_mm(*made, reading, noise_mm);
    } else {
      reading.value_mm =
          noise.resolution_mm *
          std::round((reading.value_mm + noise_mm) / noise.resolution_mm);
    }
    if (!wild.Chance(made->blemishes.outlier_share)) continue;
    reading.is_outlier = true;
    reading.value_mm += wild.Sign() * wild.LogUniform(8, 40) * Sigma_mm(*made, reading);
  }
}

Defect Wander(const Circumstances& at, double um_per_sqrt_h) {
  constexpr double kStep_s = 20;
  auto paths = std::make_shared<std::array<History, 3>>();
  for (History& path : *paths) {
    path.step_s = kStep_s;
    double place = 0;
    const int steps = static_cast<int>(at.weather.duration_s() / kStep_s) + 3;
    for (int i = 0; i < steps; ++i) {
      path.values.push_back(place);
      place += at.random->Normal() * std::sqrt(kStep_s / 3600);
    }
  }
  Defect defect{.cause = "random_walk"};
  defect.size = um_per_sqrt_h;
  defect.parameters = {{"um_per_sqrt_h", 1}};
  defect.motion = [paths](const Instant& now) {
    return kMmPerUm * Vector3{(*paths)[0].At(now.t_s),
                              (*paths)[1].At(now.t_s),
                              (*paths)[2].At(now.t_s)};
  };
  return defect;
}

Defect Clutter(const Circumstances& at, double amplitude_mm) {
  struct Ripple {
    Vector3 waves_per_mm;
    double phase_rad;
    int axis;
  };
  std::vector<Ripple> ripples;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 4; ++i) {
      ripples.push_back({{at.random->Uniform(-0.1, 0.1),
                          at.random->Uniform(-0.1, 0.1),
                          at.random->Uniform(-0.1, 0.1)},
                         at.random->Uniform(0, 6.28),
                         axis});
    }
  }
  Defect defect{.cause = "clutter"};
  defect.motion = [=](const Instant& now) {
    Vector3 sum{};
    for (const Ripple& ripple : ripples) {
      const double wave =
          std::sin(6.2832 * Dot(ripple.waves_per_mm, now.q_mm) + ripple.phase_rad);
      sum = sum + 0.7 * amplitude_mm * wave * Along(ripple.axis);
    }
    return sum;
  };
  return defect;
}

}  // namespace blind
