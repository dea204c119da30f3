// What is drawn before anything is hidden: the machine, the plan, the common faults,
// the blemishes of the data.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/blind/case.h"

namespace blind {
namespace {

bool Hides(const CaseRequest& request,
           const std::string& cause,
           const std::string& axis) {
  return std::ranges::any_of(request.hidden, [&](const Hidden& hidden) {
    return hidden.cause == cause && hidden.axis == axis;
  });
}

int RowsOf(const CampaignRequest& request, const Drawing& drawing) {
  Plan plan;
  Random random(1, "rows");
  AddCampaign(request, drawing, &random, &plan);
  return static_cast<int>(plan.stops.size());
}

/// Joins what two causes ask of one campaign.
void Merge(const CampaignRequest& wanted, std::vector<CampaignRequest>* all) {
  for (CampaignRequest& have : *all) {
    const bool no_axis = wanted.kind == "blocks" || wanted.kind == "plate" ||
                         wanted.kind == "plate_turned_90" || wanted.kind == "ring" ||
                         wanted.kind == "ballbar" || wanted.kind == "rehoming";
    const bool same =
        have.kind == wanted.kind && have.vertical == wanted.vertical &&
        (no_axis || (have.axis == wanted.axis && have.lever == wanted.lever));
    if (!same) continue;
    have.two_loads |= wanted.two_loads;
    have.three_feeds |= wanted.three_feeds;
    have.two_offsets |= wanted.two_offsets;
    have.two_artefacts |= wanted.two_artefacts;
    return;
  }
  all->push_back(wanted);
}

const std::vector<CampaignRequest>& OtherCampaigns() {
  static const std::vector<CampaignRequest> others = {
      {.kind = "iso230", .axis = 0},
      {.kind = "iso230", .axis = 1},
      {.kind = "dense", .axis = 0},
      {.kind = "dense", .axis = 1},
      {.kind = "blocks"},
      {.kind = "blocks", .three_feeds = true},
      {.kind = "plate"},
      {.kind = "plate_turned_90"},
      {.kind = "ring"},
      {.kind = "ballbar"},
      {.kind = "alternating", .axis = 0},
      {.kind = "alternating", .axis = 1},
      {.kind = "rehoming"},
      {.kind = "straightedge", .axis = 0},
      {.kind = "straightedge", .axis = 1},
      {.kind = "square"},
      {.kind = "abbe", .axis = 0},
      {.kind = "abbe", .axis = 1},
      {.kind = "drift", .axis = 0}};
  return others;
}

}  // namespace

namespace {

// Of a machine to be measured on: a laser then sees no whole motor steps.
constexpr double kLoopMicrosteps = 256;

}  // namespace

Drawing DrawMachine(const CaseRequest& request) {
  Random random(request.seed, "drawing");
  Drawing drawing;
  const double travel_mm = random.Pick<double>({260, 300, 320, 400});
  for (std::size_t i = 0; i < 3; ++i) {
    AxisDrawing& axis = drawing.axes[i];
    axis.max_mm = i == 2 ? 120 : travel_mm;
    axis.lead_mm = random.Pick<double>({4, 4, 5, 8});
    axis.friction_n = random.Uniform(5, 14);
    if (request.kind == "loop") axis.microsteps = kLoopMicrosteps;
    const std::string name(1, "xyz"[i]);
    const bool may_be_belt = i < 2 && random.Chance(0.15);
    const bool is_belt = Hides(request, "pulley_eccentric", name) ||
                         (may_be_belt && !Hides(request, "cyclic_lead", name));
    if (!is_belt) continue;
    axis.is_belt = true;
    axis.lead_mm = random.Pick<double>({32, 40});
    axis.microsteps = 128;
  }
  return drawing;
}

std::vector<CampaignRequest> ChooseCampaigns(const CaseRequest& request,
                                             const Drawing& drawing,
                                             Random* random) {
  std::vector<CampaignRequest> wanted;
  for (const Hidden& hidden : request.hidden) {
    for (const auto& campaign : FindCause(hidden.cause)->campaigns(hidden.axis)) {
      Merge(campaign, &wanted);
    }
  }
  if (request.kind == "loop") {
    wanted.resize(1);
    return wanted;
  }
  int rows = 0;
  for (const auto& campaign : wanted) rows += RowsOf(campaign, drawing);
  std::vector<CampaignRequest> others = OtherCampaigns();
  random->Shuffle(&others);
  const auto enough = static_cast<std::size_t>(random->Index(3)) +
                      (request.hidden.empty() ? 2 : wanted.size());
  for (const CampaignRequest& other : others) {
    const int more = RowsOf(other, drawing);
    if (wanted.size() >= enough || rows + more > request.max_rows) continue;
    const std::size_t before = wanted.size();
    Merge(other, &wanted);
    if (wanted.size() > before) rows += more;
  }
  // The run from cold comes first: its first reading is where temperatures begin.
  random->Shuffle(&wanted);
  std::ranges::stable_partition(
      wanted, [](const CampaignRequest& r) { return r.kind == "drift"; });
  return wanted;
}

Plan MakePlan(const CaseRequest& request, const Drawing& drawing, int attempt) {
  Random random(request.seed, attempt == 0 ? "plan" : fmt::format("plan {}", attempt));
  Plan plan;
  for (const auto& campaign : ChooseCampaigns(request, drawing, &random)) {
    AddCampaign(campaign, drawing, &random, &plan);
  }
  return plan;
}

Truth DrawTruth(const CaseRequest& request, const Drawing& drawing, const Plan& plan) {
  Random random(request.seed, "truth");
  Truth truth;
  truth.tip_radius_mm = drawing.tip_radius_cfg_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    truth.scale[i] = 150e-6 * random.Normal();
    truth.gap_mm[i] = random.Chance(0.15) ? 0 : random.LogUniform(0.003, 0.05);
    truth.pretravel_mm[i] = random.Uniform(0.01, 0.025);
  }
  truth.bed_slope_x = 4e-4 * random.Normal();
  truth.bed_slope_y = 4e-4 * random.Normal();
  for (const auto& [setup, placement] : plan.placements) {
    Standing& standing = truth.standing[setup];
    for (double& offset_mm : standing.offset_mm) {
      offset_mm = placement.offset_sd_mm * random.Normal();
    }
    standing.turn_rad = placement.turn_sd_rad * random.Normal();
  }
  return truth;
}

std::map<std::string, Noise> DrawInstruments(const CaseRequest& request,
                                             const Drawing& drawing) {
  Random random(request.seed, "instruments");
  std::map<std::string, Noise> instruments;
  instruments["laser"] = {random.Uniform(0.4, 1.0) * kMmPerUm, 0.1 * kMmPerUm};
  instruments["ballbar"] = {random.Uniform(0.4, 0.8) * kMmPerUm, 0.1 * kMmPerUm};
  // A touch is reported in motor steps.
  instruments["probe"] = {random.Uniform(0.8, 2.0) * kMmPerUm,
                          1 / drawing.axis(0).StepsPerMm()};
  return instruments;
}

Blemishes DrawBlemishes(const CaseRequest& request) {
  Blemishes blemishes;
  if (request.clean) return blemishes;
  Random random(request.seed, "blemishes");
  if (random.Chance(0.4)) blemishes.sigma_factor = random.LogUniform(0.5, 2);
  blemishes.states_sigma = random.Chance(0.8);
  if (random.Chance(0.35)) blemishes.outlier_share = random.Uniform(0.003, 0.02);
  if (random.Chance(0.25)) {
    blemishes.wander_um_per_sqrt_h = random.LogUniform(0.4, 1.5);
  }
  if (random.Chance(0.25)) blemishes.clutter_sigma = random.Uniform(0.05, 0.15);
  const auto hides = [&](std::initializer_list<const char*> causes) {
    return std::ranges::any_of(request.hidden, [&](const Hidden& hidden) {
      return std::ranges::find(causes, hidden.cause) != causes.end();
    });
  };
  const auto drop = [&](const std::string& group, bool needed) {
    if (random.Chance(0.15) && !needed) blemishes.missing.insert(group);
  };
  drop("since_rev", hides({"reversal_spike", "stick_slip"}));
  drop("rep", false);
  drop("row", false);
  drop("settings", false);
  drop(
      "temp",
      hides(
          {"thermal_screw", "frame_temperature", "probe_temperature", "frame_growth"}));
  drop("load", hides({"windup_load"}));
  drop("home", hides({"homing_scatter"}));
  drop("header", hides({"block_size", "tip_size"}));
  blemishes.logs_commanded_travel = random.Chance(0.5);
  return blemishes;
}

}  // namespace blind
