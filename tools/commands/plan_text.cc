#include "tools/commands/plan_text.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace caltwin {
namespace {

using PlanTextJson = nlohmann::ordered_json;

constexpr std::size_t kMostShown = 12;

std::string Number(double um) {
  return um >= 1e6 ? "never" : fmt::format("{:.3g}", um);
}

std::string VisibleText(const Atlas& atlas) {
  std::string text = fmt::format(
      "\nVisible: seen at 20 to 1 from this size on (near-peak, um)\n"
      "  {:<28} {:>9} {:>9}\n",
      "cause",
      "smallest",
      "usual");
  for (const AtlasCause& line : atlas.visible) {
    text += fmt::format("  {:<28} {:>9} {:>9}{}\n",
                        line.Name(),
                        Number(line.smallest_um),
                        Number(line.usual_um),
                        line.smallest_um > line.usual_um ? "  only if large" : "");
  }
  return text;
}

std::string HiddenText(const Atlas& atlas) {
  std::string text;
  if (!atlas.absorbed.empty()) {
    text += "\nAbsorbed: the fit of the baseline takes it, so it biases that\n";
    for (const AtlasCause& line : atlas.absorbed) {
      text += fmt::format("  {:<28} into {}\n", line.Name(), line.into);
    }
  }
  if (!atlas.unseen.empty()) {
    std::vector<std::string> names;
    for (const AtlasCause& line : atlas.unseen) names.push_back(line.Name());
    text += fmt::format("\nNo reading responds to: {}\n", fmt::join(names, ", "));
  }
  return text;
}

std::string ConfoundedText(const Atlas& atlas) {
  if (atlas.confounded.empty()) return "\nAll visible causes can be told apart.\n";
  std::string text =
      "\nCannot be told apart (less than 3 sigma between them at their usual size)\n";
  for (const ConfoundedPair& pair : atlas.confounded) {
    text += fmt::format("  {:<28} {:<28} {:.1f} sigma\n",
                        pair.first.Name(),
                        pair.second.Name(),
                        pair.separation_sigma);
  }
  return text;
}

std::string Campaign(const Addition& one) {
  std::string text = one.kind;
  for (const auto& [option, word] : one.options) {
    text += fmt::format(" {{{}: {}}}", option, word);
  }
  return text;
}

std::string AddText(const std::vector<Addition>& add) {
  if (add.empty()) return "\nNo further campaign would tell more.\n";
  std::string text = "\nWhat to add, most told per minute first\n";
  for (std::size_t i = 0; i < std::min(add.size(), kMostShown); ++i) {
    const Addition& one = add[i];
    std::vector<std::string> said;
    for (const auto& [first, second] : one.pairs) {
      said.push_back(fmt::format("{} from {}", first, second));
    }
    text += fmt::format("  {:<28} {:>5.0f} min", Campaign(one), one.minutes);
    if (!said.empty()) text += fmt::format("\n    tells {}", fmt::join(said, ", "));
    if (!one.shows.empty()) {
      text += fmt::format("\n    shows {}", fmt::join(one.shows, ", "));
    }
    text += "\n";
  }
  return text;
}

PlanTextJson CauseJson(const AtlasCause& line) {
  return {{"cause", line.cause}, {"axis", line.axis}};
}

PlanTextJson AddJson(const Addition& one) {
  PlanTextJson pairs = PlanTextJson::array();
  for (const auto& [first, second] : one.pairs) {
    pairs.push_back(PlanTextJson::array({first, second}));
  }
  return {{"kind", one.kind},
          {"separates", one.separates},
          {"minutes", one.minutes},
          {"options", one.options},
          {"pairs", pairs},
          {"shows", one.shows},
          {"sigmas_gained", one.sigmas_gained}};
}

}  // namespace

std::string PlanAtlasText(const std::string& plan, const PlanAtlas& result) {
  return fmt::format("{}: {} readings, {:.0f} min of machine time\n",
                     plan,
                     result.num_rows,
                     result.minutes) +
         VisibleText(result.atlas) + HiddenText(result.atlas) +
         ConfoundedText(result.atlas) + AddText(result.add);
}

PlanTextJson PlanAtlasJson(const PlanAtlas& result) {
  PlanTextJson absorbed = PlanTextJson::array(), confounded = PlanTextJson::array(),
               visible = PlanTextJson::array();
  PlanTextJson unseen = PlanTextJson::array(), add = PlanTextJson::array();
  for (const AtlasCause& line : result.atlas.absorbed) {
    absorbed.push_back({{"what", line.Name()}, {"into", line.into}});
  }
  for (const ConfoundedPair& pair : result.atlas.confounded) {
    confounded.push_back({{"causes", {pair.first.cause, pair.second.cause}},
                          {"axes", {pair.first.axis, pair.second.axis}},
                          {"separation_sigma", pair.separation_sigma}});
  }
  for (const AtlasCause& line : result.atlas.visible) {
    PlanTextJson one = CauseJson(line);
    one["smallest_um"] = line.smallest_um;
    one["usual_um"] = line.usual_um;
    visible.push_back(one);
  }
  for (const AtlasCause& line : result.atlas.unseen) unseen.push_back(CauseJson(line));
  for (const Addition& one : result.add) add.push_back(AddJson(one));
  return {{"format", 1},
          {"rows", result.num_rows},
          {"minutes", result.minutes},
          {"absorbed", absorbed},
          {"unseen", unseen},
          {"confounded", confounded},
          {"visible", visible},
          {"add", add}};
}

}  // namespace caltwin
