// Campaigns read by a gauge: laser lines, ball-bar.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tests/blind/plan.h"

namespace blind {
namespace {

constexpr double kOverrun_mm = 4;
const char* const kLetters = "xyz";

Vector3 MiddleOfTravel(const Drawing& drawing) {
  return {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), drawing.axis(2).Mid_mm()};
}

/// Targets spread over the travel, each with a random offset (a regular grid would
/// alias a screw's waves), in ascending order.
std::vector<double> RandomTargets_mm(const AxisDrawing& axis,
                                     int count,
                                     Random* random) {
  const double low = axis.min_mm + kOverrun_mm + 4;
  const double high = axis.max_mm - kOverrun_mm - 4;
  const double spacing = (high - low) / (count - 1);
  const double room = std::min(0.45 * spacing, 1.2 * axis.lead_mm);
  std::vector<double> targets;
  for (int i = 0; i < count; ++i) {
    const double offset = random->Uniform(-0.5, 0.5) * room;
    targets.push_back(std::clamp(low + i * spacing + offset, low - 3, high + 3));
  }
  std::ranges::sort(targets);
  return targets;
}

/// A bidirectional run over the targets along `axis` through `base`.
struct LineRun {
  std::string campaign{}, setup{};
  int axis = 0;
  Vector3 base_mm{};
  std::vector<double> targets_mm{};
  int rep = 1;
  double load_n = -1;
  double feed_mm_s = 10;
};

void AddLineRun(const LineRun& run, Plan* plan) {
  const auto a = static_cast<std::size_t>(run.axis);
  const auto add = [&](double target_mm, bool first, double sense) {
    Stop stop;
    stop.campaign = run.campaign;
    stop.setup = run.setup;
    stop.rep = run.rep;
    stop.at_mm = run.base_mm;
    stop.at_mm[a] = target_mm;
    stop.n = Along(run.axis);
    stop.load_n = run.load_n;
    stop.feed_mm_s = run.feed_mm_s;
    if (first) {  // Come from beyond, so that even the first target has its sense.
      stop.via = {stop.at_mm};
      stop.via[0][a] -= sense * kOverrun_mm;
    }
    plan->stops.push_back(stop);
  };
  const auto& targets = run.targets_mm;
  for (std::size_t i = 0; i < targets.size(); ++i) add(targets[i], i == 0, +1);
  for (std::size_t i = targets.size(); i-- > 0;) {
    add(targets[i], i + 1 == targets.size(), -1);
  }
}

void AddIso230(const CampaignRequest& request,
               const std::string& name,
               const Drawing& drawing,
               Random* random,
               Plan* plan) {
  const int positions = request.two_loads ? 13 : 17 + random->Index(5);
  const int runs = request.two_loads ? 2 : 3;
  LineRun run{.campaign = name,
              .setup = name + "_laser",
              .axis = request.axis,
              .base_mm = MiddleOfTravel(drawing)};
  run.targets_mm = RandomTargets_mm(drawing.axis(request.axis), positions, random);
  const double friction_n = drawing.axis(request.axis).friction_n;
  for (int load = 0; load < (request.two_loads ? 2 : 1); ++load) {
    if (request.two_loads) run.load_n = load == 0 ? friction_n : friction_n + 60;
    for (int i = 0; i < runs; ++i) {
      run.rep = i + 1;
      AddLineRun(run, plan);
    }
  }
  plan->placements[run.setup] = {
      .artefact = "", .offset_sd_mm = 0.05, .turn_sd_rad = 0, .on_table = false};
  plan->campaigns.push_back({name,
                             "iso230",
                             fmt::format("{{axis: {}, positions: {}, runs: {}}}",
                                         kLetters[request.axis],
                                         positions,
                                         runs),
                             "laser"});
}

/// Over 2.5 leads in even steps that fit no period, there and back; the reversal
/// between is read as it comes.
void AddDense(const CampaignRequest& request,
              const std::string& name,
              const Drawing& drawing,
              Random* random,
              Plan* plan) {
  const AxisDrawing& axis = drawing.axis(request.axis);
  const double length_mm = 2.5 * axis.lead_mm;
  const int count = 60;
  const double start_mm =
      random->Uniform(axis.min_mm + 10, axis.max_mm - 10 - length_mm);
  const double step_mm = length_mm / count * random->Uniform(0.97, 1.03);
  LineRun run{.campaign = name,
              .setup = name + "_laser",
              .axis = request.axis,
              .base_mm = MiddleOfTravel(drawing)};
  for (int i = 0; i < count; ++i) run.targets_mm.push_back(start_mm + i * step_mm);
  const std::size_t first = plan->stops.size();
  AddLineRun(run, plan);
  // The way back begins without an overrun: the reversal itself is read.
  plan->stops.erase(plan->stops.begin() + static_cast<long>(first) + count);
  plan->placements[run.setup] = {
      .artefact = "", .offset_sd_mm = 0.05, .turn_sd_rad = 0, .on_table = false};
  plan->campaigns.push_back(
      {name, "dense", fmt::format("{{axis: {}}}", kLetters[request.axis]), "laser"});
}

/// The same line at two positions of another axis (two heights of the beam).
void AddAbbe(const CampaignRequest& request,
             const std::string& name,
             const Drawing& drawing,
             Random* random,
             Plan* plan) {
  LineRun run{
      .campaign = name, .axis = request.axis, .base_mm = MiddleOfTravel(drawing)};
  run.targets_mm = RandomTargets_mm(drawing.axis(request.axis), 15, random);
  const AxisDrawing& lever = drawing.axis(request.lever);
  for (int level = 0; level < 2; ++level) {
    run.base_mm[static_cast<std::size_t>(request.lever)] =
        level == 0 ? lever.min_mm + 0.08 * 2 * lever.Half_mm()
                   : lever.max_mm - 0.08 * 2 * lever.Half_mm();
    run.setup = fmt::format("{}_{}", name, level == 0 ? "low" : "high");
    plan->placements[run.setup] = {
        .artefact = "", .offset_sd_mm = 0.05, .turn_sd_rad = 0, .on_table = false};
    for (run.rep = 1; run.rep <= 2; ++run.rep) AddLineRun(run, plan);
  }
  plan->campaigns.push_back(
      {name,
       "abbe",
       fmt::format(
           "{{axis: {}, lever: {}}}", kLetters[request.axis], kLetters[request.lever]),
       "laser"});
}

constexpr double kBarRadius_mm = 100;
constexpr int kBarPoints = 40;

/// One circle of a ball-bar: from `start_rad`, with half a turn of overrun before.
struct Circle {
  Stop pattern{};
  Vector3 center_mm{};
  double start_rad = 0;
};

void AddCircle(const Circle& circle, Plan* plan) {
  const double step_rad = 2 * std::numbers::pi / kBarPoints;
  const auto direction = [](double angle_rad) {
    return Vector3{std::cos(angle_rad), std::sin(angle_rad), 0};
  };
  for (int i = 0; i < kBarPoints; ++i) {
    Stop stop = circle.pattern;
    const double angle_rad = circle.start_rad + stop.sense * i * step_rad;
    stop.n = direction(angle_rad);
    stop.at_mm = circle.center_mm + kBarRadius_mm * stop.n;
    const int before = i == 0 ? 400 : 20;
    const double span_rad = i == 0 ? std::numbers::pi : step_rad;
    for (int k = before; k > 0; --k) {
      const double passed_rad = angle_rad - stop.sense * span_rad * k / before;
      stop.via.push_back(circle.center_mm + kBarRadius_mm * direction(passed_rad));
    }
    plan->stops.push_back(stop);
  }
}

/// Full circles in both senses at two feeds.
void AddBallbar(const std::string& name,
                const Drawing& drawing,
                Random* random,
                Plan* plan) {
  Circle circle{.center_mm = MiddleOfTravel(drawing),
                .start_rad = random->Uniform(0.02, 0.12)};
  circle.pattern.campaign = name;
  circle.pattern.kind = Kind::kRadial;
  circle.pattern.setup = name + "_pivot";
  circle.pattern.feature = "bar.ball";
  circle.pattern.circle_radius_mm = kBarRadius_mm;
  for (const double feed_mm_s : {15.0, 60.0}) {
    for (const double sense : {1.0, -1.0}) {
      circle.pattern.feed_mm_s = feed_mm_s;
      circle.pattern.sense = sense;
      AddCircle(circle, plan);
    }
  }
  plan->placements[circle.pattern.setup] = {.artefact = "bar",
                                            .center_mm = circle.center_mm,
                                            .offset_sd_mm = 0.02,
                                            .turn_sd_rad = 0,
                                            .on_table = false};
  plan->artefacts["bar"] = {
      .type = "ballbar", .sizes_mm = {kBarRadius_mm}, .u_um = 0.5};
  plan->campaigns.push_back({name, "ballbar", "{radius_mm: 100}", "ballbar"});
}

}  // namespace

void AddGaugeCampaign(const CampaignRequest& request,
                      const std::string& name,
                      const Drawing& drawing,
                      Random* random,
                      Plan* plan) {
  if (request.kind == "iso230") AddIso230(request, name, drawing, random, plan);
  if (request.kind == "dense") AddDense(request, name, drawing, random, plan);
  if (request.kind == "abbe") AddAbbe(request, name, drawing, random, plan);
  if (request.kind == "ballbar") AddBallbar(name, drawing, random, plan);
}

}  // namespace blind
