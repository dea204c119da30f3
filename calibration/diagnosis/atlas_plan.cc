// The atlas of a plan, and what each kind of campaign would add to it.

#include <algorithm>
#include <set>
#include <utility>

#include "calibration/diagnosis/atlas.h"
#include "sim/base/input_error.h"
#include "sim/measure/plan_kinds.h"

namespace caltwin {
namespace {

constexpr double kSecondsPerMinute = 60;
// More than this many sigma apart is no better in practice.
constexpr double kEnough_sigma = 10;
constexpr double kSeen_sigma = 5;

using NamePair = std::pair<std::string, std::string>;

struct Performed {
  Observed observed;
  double duration_s = 0;
};

Performed PerformedBy(const Plan& plan,
                      const Machine& machine,
                      const std::vector<Injected>& effects,
                      std::uint64_t seed) {
  PlannedSession session = PlanSession(plan, machine, seed);
  return {Observed({.rows = std::move(session.rows)},
                   std::move(session.header),
                   machine,
                   effects),
          session.duration_s};
}

// What an atlas leaves open, by name.
struct Open {
  std::map<NamePair, double> pairs{};  ///< To their separation [sigma].
  std::set<std::string> hidden{};      ///< Absorbed or unseen.
};

Open OpenOf(const Atlas& atlas) {
  Open open;
  for (const ConfoundedPair& pair : atlas.confounded) {
    open.pairs[{pair.first.Name(), pair.second.Name()}] = pair.separation_sigma;
  }
  for (const auto* list : {&atlas.absorbed, &atlas.unseen}) {
    for (const AtlasCause& line : *list) open.hidden.insert(line.Name());
  }
  return open;
}

void Keep(const std::string& cause, std::vector<std::string>* causes) {
  if (std::ranges::find(*causes, cause) == causes->end()) causes->push_back(cause);
}

// Only candidates that the plan alone leaves open.
std::vector<Candidate> Concerned(const Observed& observed, const Open& open) {
  std::vector<Candidate> candidates = AllCandidates(observed);
  std::erase_if(candidates, [&](const Candidate& one) {
    if (one.is_free()) return true;
    const std::string name = one.Name();
    return !open.hidden.contains(name) &&
           std::ranges::none_of(open.pairs, [&](const auto& pair) {
             return pair.first.first == name || pair.first.second == name;
           });
  });
  return candidates;
}

Addition GainOf(const Open& before, const Atlas& with) {
  Addition addition;
  const Open after = OpenOf(with);
  const auto is_visible = [&](const std::string& name) {
    return std::ranges::find(with.visible, name, &AtlasCause::Name) !=
           with.visible.end();
  };
  for (const auto& [pair, sigma] : before.pairs) {
    const bool is_still_there = is_visible(pair.first) && is_visible(pair.second);
    if (after.pairs.contains(pair) || !is_still_there) continue;
    addition.pairs.push_back(pair);
    addition.sigmas_gained += kSeen_sigma - std::min(sigma, kSeen_sigma);
    for (const std::string& name : {pair.first, pair.second}) {
      Keep(name.substr(0, name.find('.')), &addition.separates);
    }
  }
  for (const AtlasCause& line : with.visible) {
    if (!before.hidden.contains(line.Name()) || line.smallest_um > line.usual_um) {
      continue;
    }
    addition.shows.push_back(line.Name());
    Keep(line.cause, &addition.separates);
    addition.sigmas_gained +=
        std::min(kSeen_sigma * line.usual_um / line.smallest_um, kEnough_sigma);
  }
  return addition;
}

bool Has(const Plan& plan, const CampaignChoice& choice) {
  return std::ranges::any_of(plan.campaigns, [&](const PlannedCampaign& one) {
    if (one.id != choice.campaign.id) return false;
    for (const char* option : {"axis", "plane", "wiped"}) {
      const auto mine = choice.campaign.options.AsWritten();
      const auto its = one.options.AsWritten();
      if (mine.contains(option) && mine.at(option) != its.at(option)) return false;
    }
    return true;
  });
}

// What else an option may say that makes another campaign of it.
std::vector<std::string_view> OtherWords(const PlanOption& option) {
  if (option.name == "wiped") return {"true"};
  if (option.name != "axis" && option.name != "plane") return {};
  std::vector<std::string_view> words(option.words.begin(), option.words.end());
  std::erase(words, option.otherwise);
  return words;
}

CampaignChoice Changed(const PlannedCampaign& usual,
                       const PlanOption& option,
                       const std::string& word) {
  CampaignChoice choice{usual, {{std::string(option.name), word}}};
  CampaignOptions& options = choice.campaign.options;
  if (option.type == OptionType::kFlag) {
    options.Set(option.name, true);
  } else {
    options.Set(option.name, word);
  }
  options.MarkWritten(option.name);
  return choice;
}

}  // namespace

std::vector<CampaignChoice> CampaignChoices() {
  std::vector<CampaignChoice> choices;
  for (const CampaignKind& kind : AllCampaignKinds()) {
    const PlannedCampaign usual = DefaultCampaign(kind.id);
    choices.push_back({usual, {}});
    for (const PlanOption& option : kind.options) {
      for (const std::string_view word : OtherWords(option)) {
        choices.push_back(Changed(usual, option, std::string(word)));
      }
    }
  }
  return choices;
}

PlanAtlas AtlasOfPlan(const Plan& plan,
                      const Machine& machine,
                      const std::vector<Injected>& effects,
                      std::uint64_t seed) {
  const Performed alone = PerformedBy(plan, machine, effects, seed);
  PlanAtlas result{.atlas = AtlasOf(alone.observed,
                                    AllCandidates(alone.observed),
                                    PlannedSigma_mm(alone.observed)),
                   .num_rows = static_cast<std::size_t>(alone.observed.num_rows()),
                   .minutes = alone.duration_s / kSecondsPerMinute};
  const Open open = OpenOf(result.atlas);
  for (CampaignChoice& choice : CampaignChoices()) {
    if (Has(plan, choice)) continue;
    Plan more = plan;
    choice.campaign.name = "added_" + choice.campaign.id;
    more.campaigns.push_back(choice.campaign);
    try {
      const Performed both = PerformedBy(more, machine, effects, seed);
      Addition addition = GainOf(open,
                                 AtlasOf(both.observed,
                                         Concerned(both.observed, open),
                                         PlannedSigma_mm(both.observed)));
      addition.kind = choice.campaign.id;
      addition.options = choice.changed;
      addition.minutes = (both.duration_s - alone.duration_s) / kSecondsPerMinute;
      if (!addition.separates.empty()) result.add.push_back(std::move(addition));
    } catch (const InputError&) {
      continue;  // It does not fit this machine's travel.
    }
  }
  std::ranges::stable_sort(result.add, std::ranges::greater{}, [](const Addition& one) {
    return one.sigmas_gained / one.minutes;
  });
  return result;
}

}  // namespace caltwin
