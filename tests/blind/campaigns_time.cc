// Campaigns in which time passes: alternating faces, re-homing, drift; and the table of
// all campaigns.

#include <algorithm>

#include <fmt/format.h>

#include "tests/blind/plan.h"

namespace blind {
namespace {

/// The two faces of a block across one axis, in turn, for an hour and a half; the same
/// feed and place every time.
void AddAlternating(const CampaignRequest& request,
                    const std::string& name,
                    const Drawing& drawing,
                    Random* random,
                    Plan* plan) {
  constexpr int kPairs = 40;
  Vector3 center = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  center[static_cast<std::size_t>(request.axis)] += random->Uniform(-60, 60);
  for (int i = 0; i < kPairs; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      Stop stop = Touch(name,
                        name,
                        request.axis == 0 ? (sign < 0 ? "datum.left" : "datum.right")
                                          : (sign < 0 ? "datum.front" : "datum.back"),
                        center + Along(request.axis, 25 * sign) + Vector3{0, 0, 12},
                        Along(request.axis, sign));
      stop.rep = i + 1;
      stop.pause_s = 40;
      plan->stops.push_back(stop);
    }
  }
  plan->placements[name] = {.artefact = "datum", .center_mm = center};
  plan->artefacts["datum"] = {.type = "block", .sizes_mm = {50, 50, 25}, .u_um = 0.5};
  plan->campaigns.push_back(
      {name, "alternating", fmt::format("{{axis: {}}}", "xyz"[request.axis]), "probe"});
}

/// Three faces of a datum block after each of many homings.
void AddRehoming(const std::string& name,
                 const Drawing& drawing,
                 Random* random,
                 Plan* plan) {
  constexpr int kHomings = 16;
  const Vector3 center = {drawing.axis(0).Mid_mm() + random->Uniform(-50, 50),
                          drawing.axis(1).Mid_mm() + random->Uniform(-50, 50),
                          0};
  for (int home = 0; home < kHomings; ++home) {
    for (int rep = 1; rep <= 2; ++rep) {
      const std::vector<Stop> faces = {
          Touch(name, name, "cube.left", center + Vector3{-25, 0, 12}, Along(0, -1)),
          Touch(name, name, "cube.front", center + Vector3{0, -25, 12}, Along(1, -1)),
          Touch(name, name, "cube.top", center + Vector3{0, 0, 25}, Along(2))};
      for (std::size_t i = 0; i < faces.size(); ++i) {
        plan->stops.push_back(faces[i]);
        plan->stops.back().rep = rep;
        plan->stops.back().rehome = rep == 1 && i == 0;
      }
    }
  }
  plan->placements[name] = {.artefact = "cube", .center_mm = center};
  plan->artefacts["cube"] = {.type = "block", .sizes_mm = {50, 50, 25}, .u_um = 0.5};
  plan->campaigns.push_back({name, "rehoming", "{homings: 16}", "probe"});
}

/// Two posts far apart along an axis, each from both sides, and a lip from above and
/// from below, over hours from cold; the order within a round is random.
void AddDrift(const CampaignRequest& request,
              const std::string& name,
              const Drawing& drawing,
              Random* random,
              Plan* plan) {
  constexpr int kRounds = 36;
  const int a = request.axis;
  const bool along_x = a == 0;
  Vector3 middle = {drawing.axis(0).Mid_mm(), drawing.axis(1).Mid_mm(), 0};
  const double reach_mm = drawing.axis(a).Half_mm() - 30;
  const Vector3 near = middle + Along(a, -reach_mm);
  const Vector3 far = middle + Along(a, reach_mm);
  std::vector<Stop> round;
  for (const bool is_far : {false, true}) {
    const std::string post = is_far ? "post2" : "post1";
    for (const double sign : {-1.0, 1.0}) {
      const char* face =
          sign < 0 ? (along_x ? ".left" : ".front") : (along_x ? ".right" : ".back");
      round.push_back(
          Touch(name,
                name + "_" + post,
                post + face,
                (is_far ? far : near) + Along(a, 10 * sign) + Vector3{0, 0, 15},
                Along(a, sign)));
    }
  }
  round.push_back(
      Touch(name, name + "_lip", "lip.top", middle + Vector3{0, 0, 40}, Along(2)));
  round.push_back(Touch(
      name, name + "_lip", "lip.bottom", middle + Vector3{0, 0, 32}, Along(2, -1)));
  for (int i = 0; i < kRounds; ++i) {
    random->Shuffle(&round);
    for (std::size_t k = 0; k < round.size(); ++k) {
      plan->stops.push_back(round[k]);
      plan->stops.back().rep = i + 1;
      plan->stops.back().pause_s = k == 0 ? 330 : 0;
    }
  }
  plan->placements[name + "_post1"] = {.artefact = "post1", .center_mm = near};
  plan->placements[name + "_post2"] = {.artefact = "post2", .center_mm = far};
  plan->placements[name + "_lip"] = {.artefact = "lip", .center_mm = middle};
  plan->artefacts["post1"] = {.type = "post"};
  plan->artefacts["post2"] = {.type = "post"};
  plan->artefacts["lip"] = {.type = "ledge", .sizes_mm = {8}, .u_um = 0.5};
  plan->from_cold = true;
  plan->campaigns.push_back(
      {name, "drift", fmt::format("{{axis: {}, hours: 4}}", "xyz"[a]), "probe"});
}

}  // namespace

Stop Touch(const std::string& campaign,
           const std::string& setup,
           const std::string& feature,
           const Vector3& point,
           const Vector3& n) {
  Stop stop;
  stop.campaign = campaign;
  stop.kind = Kind::kTouch;
  stop.setup = setup;
  stop.feature = feature;
  stop.at_mm = point;
  stop.n = n;
  stop.feed_mm_s = 1;
  return stop;
}

void AddTimeCampaign(const CampaignRequest& request,
                     const std::string& name,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan) {
  if (request.kind == "alternating")
    AddAlternating(request, name, drawing, random, plan);
  if (request.kind == "rehoming") AddRehoming(name, drawing, random, plan);
  if (request.kind == "drift") AddDrift(request, name, drawing, random, plan);
}

void AddCampaign(const CampaignRequest& request,
                 const Drawing& drawing,
                 Random* random,
                 Plan* plan) {
  const auto taken = std::ranges::count(plan->campaigns, request.kind, &Campaign::kind);
  const std::string name =
      taken == 0 ? request.kind : fmt::format("{}_{}", request.kind, taken + 1);
  AddGaugeCampaign(request, name, drawing, random, plan);
  AddTouchCampaign(request, name, drawing, random, plan);
  AddTimeCampaign(request, name, drawing, random, plan);
}

}  // namespace blind
