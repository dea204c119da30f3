// What the truth code plans, in the words of a plan file.

#include <algorithm>

#include <fmt/format.h>

#include "tests/blind/physics_case.h"

namespace blind {
namespace {

std::string LoadsOf(const CampaignRequest& request, const Drawing& drawing) {
  const double friction_n = drawing.axis(request.axis).friction_n;
  return fmt::format("[{:.2f}, {:.2f}]", friction_n, friction_n + 60);
}

/// The options, as YAML's flow style.
std::string Options(const CampaignRequest& request,
                    const Drawing& drawing,
                    Random* random) {
  const char letter = "xyz"[request.axis];
  if (request.kind == "iso230" && request.two_loads) {
    return fmt::format("{{axis: {}, positions: 13, runs: 2, loads_n: {}}}",
                       letter,
                       LoadsOf(request, drawing));
  }
  if (request.kind == "iso230") {
    return fmt::format(
        "{{axis: {}, positions: {}, runs: 3}}", letter, 17 + random->Index(5));
  }
  if (request.kind == "abbe") {
    return fmt::format("{{axis: {}, lever: {}}}", letter, "xyz"[request.lever]);
  }
  if (request.kind == "blocks") {
    return fmt::format("{{feeds_mm_s: [{}]}}",
                       request.three_feeds ? "1, 3, 8" : "1, 5");
  }
  if (request.kind == "plate") {
    return fmt::format("{{grid: [7, 7], repeats: 1, probe_offset_mm: [0{}]}}",
                       request.two_offsets ? ", 40" : "");
  }
  if (request.kind == "plate_turned_90") return "{grid: [7, 7], repeats: 1}";
  if (request.kind == "square") {
    return fmt::format("{{plane: {}}}",
                       !request.vertical   ? "xy"
                       : request.axis == 0 ? "xz"
                                           : "yz");
  }
  const bool has_axis = request.kind == "dense" || request.kind == "straightedge" ||
                        request.kind == "alternating";
  if (request.kind == "straightedge") {
    return fmt::format("{{axis: {}, across: {}}}", letter, "yx"[request.axis]);
  }
  return has_axis ? fmt::format("{{axis: {}}}", letter) : "{}";
}

std::string InstrumentOf(const std::string& kind) {
  if (kind == "ballbar") return "ballbar";
  return kind == "iso230" || kind == "dense" || kind == "abbe" ? "laser" : "probe";
}

}  // namespace

std::string PlanYaml(const std::vector<CampaignRequest>& campaigns,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan) {
  // No instruments: they are ideal, and the noise is the truth code's own.
  std::string text =
      fmt::format("format: 1\nseed: {}\ncampaigns:\n", 1 + random->Index(1'000'000));
  for (const CampaignRequest& request : campaigns) {
    const auto taken =
        std::ranges::count(plan->campaigns, request.kind, &Campaign::kind);
    const std::string options = Options(request, drawing, random);
    plan->campaigns.push_back(
        {taken == 0 ? request.kind : fmt::format("{}_{}", request.kind, taken + 1),
         request.kind,
         options,
         InstrumentOf(request.kind)});
    text += fmt::format("  - {}: {}\n", request.kind, options);
  }
  return text;
}

}  // namespace blind
