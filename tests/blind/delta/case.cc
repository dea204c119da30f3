#include "tests/blind/delta/case.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

#include "tests/blind/delta/rivals.h"
#include "tests/blind/visible.h"

namespace blind {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kMost = 8;  // Times what is typical.

DeltaPaper DrawPaper(Random* random) {
  DeltaPaper paper;
  paper.radius_mm = random->Uniform(95, 170);
  paper.arm_mm = paper.radius_mm * random->Uniform(1.85, 2.3);
  paper.endstop_mm = random->Uniform(220, 380);
  paper.rod_spacing_mm = random->Uniform(35, 60);
  paper.effector_radius_mm = random->Uniform(22, 40);
  paper.joint_height_mm = random->Uniform(8, 30);
  paper.bed_radius_mm = paper.radius_mm * random->Uniform(0.7, 0.82);
  return paper;
}

std::vector<DeltaStop> DrawStops(const DeltaPaper& paper, Random* random) {
  std::vector<DeltaStop> stops;
  AddDeltaGrid(paper, random, &stops);
  if (random->Chance(0.75)) AddDeltaXy(paper, random, &stops);
  if (random->Chance(0.75)) AddZColumns(paper, random, &stops);
  if (random->Chance(0.4)) AddDeltaRing(paper, random, &stops);
  random->Shuffle(&stops);
  std::ranges::stable_sort(stops, {}, &DeltaStop::campaign);
  double t_s = 0;
  for (DeltaStop& stop : stops) {
    t_s += random->Uniform(6, 14);
    stop.t_s = t_s;
    const double warm = 1 - std::exp(-t_s / 900);
    stop.frame_k = 6 * warm + 1.5 * std::sin(t_s / 700) + 0.02 * random->Normal();
    stop.bed_k = 9 * (1 - std::exp(-t_s / 400)) - 3 * std::sin(t_s / 1100) +
                 0.02 * random->Normal();
    stop.screw_k = 4 * warm + 0.02 * random->Normal();
  }
  return stops;
}

// What every machine has, and every diagnosis fits first.
DeltaTruth DrawBaseline(const DeltaPaper& paper, std::uint64_t seed) {
  Random random(seed, "delta baseline");
  DeltaTruth truth;
  truth.bed.rim_mm = paper.bed_radius_mm;
  Random shape(seed, "delta shape");
  truth.bed.power = shape.Uniform(1.7, 2.3);
  for (std::size_t i = 0; i < 3; ++i) {
    truth.made.endstop_mm[i] = 0.3 * random.Normal();
    if (i < 2) truth.made.angle[i] = 0.25 * kRadPerDeg * random.Normal();
  }
  truth.made.radius_mm.fill(0.5 * random.Normal());
  truth.made.arm_mm = 0.2 * random.Normal();
  truth.made.belt.fill(2e-4 * random.Normal());
  truth.bed.slope_x = 1.5e-3 * random.Normal();
  truth.bed.slope_y = 1.5e-3 * random.Normal();
  truth.offset_mm = [seed](const std::string& setup) {
    Random own(seed, "offset of " + setup);
    // In an order that every compiler keeps.
    const double z_mm = own.Normal() / 5;
    const double y_mm = own.Normal() / 5;
    const double x_mm = own.Normal() / 5;
    return Vec(x_mm, y_mm, z_mm);
  };
  truth.turn = [seed](const std::string& setup) {
    // A gauge on a column has no turn.
    return setup.starts_with("plate") ? 1e-3 * Random(seed, "turn of " + setup).Normal()
                                      : 0.0;
  };
  return truth;
}

Column Readings(const DeltaPaper& paper,
                const DeltaTruth& truth,
                const std::vector<DeltaStop>& stops) {
  Column values;
  for (const DeltaStop& stop : stops) {
    const auto value = ReadStop(paper, truth, stop);
    if (!value) throw std::runtime_error("out of reach");
    values.push_back(*value);
  }
  return values;
}

// What a small change of the truth adds to each row, by differences.
Column Slope(const DeltaCase& made,
             const DeltaTruth& truth,
             const std::function<void(DeltaTruth*)>& change) {
  DeltaTruth changed = truth;
  change(&changed);
  const Column with = Readings(made.paper, changed, made.stops);
  const Column without = Readings(made.paper, truth, made.stops);
  Column slope;
  for (std::size_t i = 0; i < with.size(); ++i) {
    slope.push_back((with[i] - without[i]) / made.sigma_mm);
  }
  return slope;
}

std::vector<Column> BaselineColumns(const DeltaCase& made, const DeltaTruth& truth) {
  std::vector<Column> columns;
  const auto add = [&](const std::function<void(DeltaTruth*)>& change) {
    columns.push_back(Slope(made, truth, change));
  };
  for (std::size_t i = 0; i < 3; ++i) {
    add([i](DeltaTruth* t) { t->made.endstop_mm[i] += 0.01; });
    if (i < 2) add([i](DeltaTruth* t) { t->made.angle[i] += 1e-4; });
  }
  add([](DeltaTruth* t) {
    for (double& radius : t->made.radius_mm) radius += 0.01;
  });
  add([](DeltaTruth* t) { t->made.arm_mm += 0.01; });
  add([](DeltaTruth* t) {
    for (double& belt : t->made.belt) belt += 1e-5;
  });
  add([](DeltaTruth* t) { t->bed.slope_x += 1e-4; });
  add([](DeltaTruth* t) { t->bed.slope_y += 1e-4; });
  std::set<std::string> setups;
  for (const DeltaStop& stop : made.stops) setups.insert(stop.setup);
  for (const std::string& setup : setups) {
    for (int k = 0; k < 4; ++k) {
      Column column;
      for (const DeltaStop& stop : made.stops) {
        const Vec turned(-stop.at_mm.y(), stop.at_mm.x(), 0);
        const double here = k < 3 ? stop.n[k] : turned.dot(stop.n) / 100;
        column.push_back(stop.setup == setup ? here : 0.0);
      }
      columns.push_back(column);
    }
  }
  return columns;
}

std::vector<Column> CauseColumns(const DeltaCase& made,
                                 const DeltaTruth& truth,
                                 const DeltaCause& cause,
                                 const std::string& axis,
                                 double second) {
  std::vector<Column> columns;
  const double size = cause.typical;
  if (cause.second.empty()) {
    columns.push_back(
        Slope(made, truth, [&](DeltaTruth* t) { cause.put(axis, size, second, t); }));
    return columns;
  }
  columns.push_back(
      Slope(made, truth, [&](DeltaTruth* t) { cause.put(axis, size, 0, t); }));
  columns.push_back(
      Slope(made, truth, [&](DeltaTruth* t) { cause.put(axis, 0, size, t); }));
  return columns;
}

double SumSquares(const Column& column) {
  double sum = 0;
  for (const double value : column) sum += value * value;
  return sum;
}

// A cause in its place; `second` shapes it, or is the ratio of its second number.
struct Hiding {
  const DeltaCause& cause;
  std::string axis{};
  double second = 0;
};

// How much of the effect is left when another cause imitates it.
nlohmann::json TwinsOf(const DeltaCase& made,
                       const DeltaTruth& truth,
                       const Hiding& hidden,
                       const Column& effect,
                       const std::vector<Column>& baseline) {
  nlohmann::json twins = nlohmann::json::object();
  const auto add = [&](const std::string& name, std::vector<Column> columns) {
    constexpr double kNear = 25;
    columns.insert(columns.end(), baseline.begin(), baseline.end());
    const double left = SumSquares(Projector(columns).Rest(effect));
    const double least = twins.value(name, kNear);
    if (left < least) twins[name] = left;
  };
  for (const DeltaRival& rival : DeltaRivals(made.stops, made.sigma_mm)) {
    for (const Column& form : rival.forms) add(rival.name, {form});
  }
  for (const DeltaCause& cause : DeltaCauses()) {
    if (cause.is_outside) continue;
    for (const std::string& other : cause.axes) {
      if (cause.name == hidden.cause.name && other == hidden.axis) continue;
      add(cause.name + " " + other,
          CauseColumns(made, truth, cause, other, hidden.second));
    }
  }
  return twins;
}

nlohmann::json Hide(const DeltaCause& cause,
                    double sigma,
                    DeltaCase* made,
                    DeltaTruth* truth) {
  Random random(made->request.seed, "delta hidden" + cause.name);
  std::string axis = made->request.axis.empty() || made->request.axis == "any"
                         ? random.Pick(cause.axes)
                         : made->request.axis;
  const double sign = random.Sign();
  const double ratio = random.Normal();
  const bool has_two = !cause.second.empty();
  double size = sign * cause.typical;
  const auto put = [&](DeltaTruth* into) {
    cause.put(axis, size, has_two ? ratio * size : ratio, into);
  };
  const std::vector<Column> baseline = BaselineColumns(*made, *truth);
  Visible visible;
  Column effect;
  for (int round = 0; round < 4; ++round) {
    effect = Slope(*made, *truth, put);
    visible = VisibleEffect(effect, Projector(baseline));
    if (visible.peak < 1e-3 * visible.whole_peak) break;
    // No machine is this bad, whatever its plan shows of it.
    const double most = kMost * cause.typical;
    if (round < 3) size *= sigma / visible.peak;
    size = std::clamp(size, -most, most);
  }
  const nlohmann::json twins =
      TwinsOf(*made, *truth, {cause, axis, ratio}, effect, baseline);
  put(truth);
  nlohmann::json parameters = nlohmann::json::array();
  const bool is_absolute =
      cause.name == "carriage_backlash" || cause.name == "trigger_latency";
  if (!cause.parameter.empty()) {
    parameters.push_back(
        {{"name", cause.parameter}, {"value", is_absolute ? std::abs(size) : size}});
  }
  if (has_two) parameters.push_back({{"name", cause.second}, {"value", ratio * size}});
  return {{"cause", cause.name},
          {"axis", axis},
          {"parameters", parameters},
          {"peak_sigma", visible.peak},
          {"sum_squares", visible.sum_squares},
          {"separation", twins},
          {"acceptable", nlohmann::json::array()},
          {"covariates", cause.covariates}};
}

// One cause, or two of different names, each of a size of its own.
nlohmann::json HideAll(Random* random, DeltaCase* made, DeltaTruth* truth) {
  const DeltaRequest& request = made->request;
  nlohmann::json hidden = nlohmann::json::array();
  if (request.kind == "null") return hidden;
  std::vector<DeltaCause> fit;
  for (const DeltaCause& cause : DeltaCauses()) {
    const bool is_named = request.cause.empty() || cause.name == request.cause;
    if (is_named && cause.is_outside == (request.kind == "outside")) {
      fit.push_back(cause);
    }
  }
  if (fit.empty()) throw std::invalid_argument("no such cause: " + request.cause);
  const DeltaCause first = random->Pick(fit);
  hidden.push_back(Hide(first, request.sigma, made, truth));
  if (request.kind != "pair") return hidden;
  std::vector<DeltaCause> others;
  for (const DeltaCause& cause : DeltaCauses()) {
    if (cause.name != first.name && !cause.is_outside) others.push_back(cause);
  }
  // In an order that every compiler keeps.
  const double sigma = random->LogUniform(2, 15);
  const DeltaCause second = random->Pick(others);
  hidden.push_back(Hide(second, sigma, made, truth));
  return hidden;
}

// A random walk in time, as every reading along z sees it.
void AddWander(DeltaCase* made) {
  if (made->request.wander_um_per_sqrt_h <= 0) return;
  constexpr double kSecondsPerHour = 3600;
  Random random(made->request.seed, "delta wander");
  std::vector<std::size_t> order(made->stops.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::size_t i) { return made->stops[i].t_s; });
  double at_mm = 0, before_s = 0;
  for (const std::size_t i : order) {
    const DeltaStop& stop = made->stops[i];
    at_mm += 1e-3 * made->request.wander_um_per_sqrt_h * random.Normal() *
             std::sqrt((stop.t_s - before_s) / kSecondsPerHour);
    before_s = stop.t_s;
    // A nozzle that stands higher is touched lower.
    made->values_mm[i] += (stop.is_touch ? -1 : 1) * stop.n.z() * at_mm;
  }
}

}  // namespace

DeltaCase MakeDeltaCase(const DeltaRequest& request) {
  DeltaCase made{.request = request};
  Random random(request.seed, "delta");
  made.paper = DrawPaper(&random);
  made.stops = DrawStops(made.paper, &random);
  made.sigma_mm = random.LogUniform(0.002, 0.01);
  made.stated = random.Chance(0.3) ? random.LogUniform(0.5, 2) : 1;
  DeltaTruth truth = DrawBaseline(made.paper, request.seed);
  const nlohmann::json causes = HideAll(&random, &made, &truth);
  made.values_mm = Readings(made.paper, truth, made.stops);
  AddWander(&made);
  Random noise(request.seed, "delta noise");
  const double outliers = noise.Chance(0.3) ? 0.01 : 0;
  for (double& value : made.values_mm) {
    value += made.sigma_mm * noise.Normal();
    if (noise.Chance(outliers)) value += made.sigma_mm * noise.Sign() * 30;
  }
  made.truth = {{"kind", request.kind},
                {"seed", request.seed},
                {"rows", made.stops.size()},
                {"wander_um_per_sqrt_h", request.wander_um_per_sqrt_h},
                {"causes", causes},
                {"baseline",
                 {{"endstop_mm", truth.made.endstop_mm},
                  {"radius_mm", truth.made.radius_mm[0]},
                  {"angle_rad", truth.made.angle},
                  {"arm_mm", truth.made.arm_mm},
                  {"belt", truth.made.belt},
                  {"bed_slopes", {truth.bed.slope_x, truth.bed.slope_y}}}}};
  return made;
}

}  // namespace blind
