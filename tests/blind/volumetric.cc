#include "tests/blind/volumetric.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>

namespace blind {
namespace {

namespace fs = std::filesystem;

constexpr std::array kSigmas = {3.0, 20.0};
constexpr std::array kMust = {0.70, 0.90};
constexpr std::array kAim = {0.85, 0.97};

/// Causes that move the tool by where it stands; those of time and load would need the
/// same day again.
const std::vector<std::string>& PlaceCauses() {
  static const std::vector<std::string> causes = {"cyclic_lead",
                                                  "pulley_eccentric",
                                                  "microstep",
                                                  "pitch_progressive",
                                                  "pitch_map",
                                                  "backlash_worn",
                                                  "squareness",
                                                  "straightness",
                                                  "angular",
                                                  "gantry_sag",
                                                  "axis_twist"};
  return causes;
}

constexpr const char* kSetup = "unseen_laser";

Plan UnseenPlan(const Drawing& drawing, Random* random) {
  constexpr int kPoses = 120;
  constexpr double kOverrun_mm = 4, kMargin_mm = 8;
  Plan plan;
  for (int pose = 0; pose < kPoses; ++pose) {
    Stop stop{.campaign = "unseen", .setup = kSetup, .feed_mm_s = 10};
    Vector3 from_mm{};
    for (std::size_t i = 0; i < 3; ++i) {
      const AxisDrawing& axis = drawing.axes[i];
      stop.at_mm[i] =
          random->Uniform(axis.min_mm + kMargin_mm, axis.max_mm - kMargin_mm);
      from_mm[i] = stop.at_mm[i] + (random->Chance(0.5) ? 1 : -1) * kOverrun_mm;
    }
    stop.via = {from_mm};
    for (int axis = 0; axis < 3; ++axis) {
      stop.n = Along(axis);
      plan.stops.push_back(stop);
    }
  }
  plan.placements[kSetup] = {
      .artefact = "", .offset_sd_mm = 0, .turn_sd_rad = 0, .on_table = false};
  plan.campaigns = {{"unseen", "unseen", "{}", "laser"}};
  return plan;
}

/// What a diagnosis states of rows held out before any finding [um]; below 0: nothing.
double Rmse_um(const nlohmann::json& answer) {
  if (!answer.is_object() || !answer.contains("gain")) return -1;
  return answer["gain"].value("rmse_before_um", -1.0);
}

}  // namespace

void MakeUnseen(const Case& made, Case* unseen) {
  Random random(made.request.seed, "unseen poses");
  unseen->request = made.request;
  unseen->drawing = made.drawing;
  unseen->plan = UnseenPlan(made.drawing, &random);
  unseen->times_s = TimesOf_s(unseen->plan);
  unseen->truth = made.truth;
  unseen->truth.defects.clear();
  for (const HiddenTruth& hidden : made.hidden) {
    unseen->truth.defects.push_back(hidden.defect);
  }
  unseen->truth.standing = {{kSetup, {}}};
  unseen->instruments = {{"laser", {.sigma_mm = 1e-5, .resolution_mm = 1e-6}}};
  unseen->blemishes.missing = {"temp"};
  unseen->readings =
      Machine(unseen->drawing, unseen->truth).Perform(unseen->plan, unseen->times_s);
  AddNoise(unseen);
}

Volumetric ExamineVolumetric(const Diagnoser& diagnoser, const CaseRequest& request) {
  const fs::path folder =
      fs::path(diagnoser.folder) /
      fmt::format("volumetric_{}_{}", request.hidden[0].cause, request.seed);
  Case made;
  MakeCase(request, &made);
  WriteCase(made, folder.string());
  Volumetric volumetric{.name = request.hidden[0].cause + " " + request.hidden[0].axis,
                        .sigma = request.hidden[0].sigma,
                        .seed = request.seed};
  const auto answer =
      Diagnose(diagnoser, folder.string(), {.extend = "machine.ext.yaml"});
  Case unseen;
  MakeUnseen(made, &unseen);
  const fs::path there = folder / "unseen";
  WriteCase(unseen, there.string());
  volumetric.before_um = Rmse_um(Diagnose(diagnoser, there.string()));
  volumetric.after_um = volumetric.before_um;
  if (fs::exists(folder / "machine.ext.yaml")) {
    fs::copy_file(folder / "machine.ext.yaml",
                  there / "machine.ext.yaml",
                  fs::copy_options::overwrite_existing);
    volumetric.after_um =
        Rmse_um(Diagnose(diagnoser,
                         there.string(),
                         {.machine = "machine.ext.yaml", .answer = "after.json"}));
  }
  volumetric.ran =
      answer.is_object() && volumetric.before_um >= 0 && volumetric.after_um >= 0;
  if (!diagnoser.keep) fs::remove_all(folder);
  return volumetric;
}

std::vector<CaseRequest> VolumetricSet(int count, std::uint64_t seed) {
  std::vector<CaseRequest> requests;
  for (const double sigma : kSigmas) {
    for (int i = 0; i < count; ++i) {
      const std::string& cause =
          PlaceCauses()[static_cast<std::size_t>(i) % PlaceCauses().size()];
      CaseRequest request{.kind = "single",
                          .hidden = {{cause, "any", sigma}},
                          .sigma = sigma,
                          .seed = seed + requests.size()};
      requests.push_back(Filled(request));
    }
  }
  return requests;
}

std::string VolumetricText(const std::vector<Volumetric>& all) {
  std::string text =
      "| volumetric error removed at unseen poses, median | rate | worst tenth below | "
      "of | must | aim | |\n|---|---|---|---|---|---|---|\n";
  std::string short_of;
  for (std::size_t s = 0; s < kSigmas.size(); ++s) {
    std::vector<double> removed;
    for (const Volumetric& one : all) {
      if (one.sigma != kSigmas[s]) continue;
      removed.push_back(one.ran ? one.Removed() : 0);
      if (removed.back() >= kMust[s]) continue;
      short_of += fmt::format(
          "| {} | {:g} | {} | {:.2f} | {:.2f} | {} |\n",
          one.name,
          one.sigma,
          one.seed,
          one.before_um,
          one.after_um,
          one.ran ? fmt::format("{:.0f} %", 100 * one.Removed()) : "no answer");
    }
    std::ranges::sort(removed);
    if (removed.empty()) continue;
    const double median = removed[removed.size() / 2];
    text += fmt::format(
        "| {:g} sigma | {:.1f} % | {:.1f} % | {} | {:g} % | {:g} % | {} |\n",
        kSigmas[s],
        100 * median,
        100 * removed[removed.size() / 10],
        removed.size(),
        100 * kMust[s],
        100 * kAim[s],
        median >= kMust[s] ? "reached" : "short");
  }
  if (short_of.empty()) return text;
  return text +
         "\n| short of it | sigma | seed | before, um | after, um | removed |\n"
         "|---|---|---|---|---|---|\n" +
         short_of;
}

}  // namespace blind
