#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/procedures/catalog.h"
#include "scenarios/figure_words.h"
#include "scenarios/keys.h"
#include "scenarios/kinds/kinds.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/plan_kinds.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

constexpr std::size_t kExplainWidth = 88;

// Prose folded at spaces, every line indented.
std::string Folded(std::string_view text, std::size_t indent) {
  std::string folded;
  std::string line(indent, ' ');
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    const std::string_view word = text.substr(start, end - start);
    if (line.size() > indent && line.size() + 1 + word.size() > kExplainWidth) {
      folded += line + "\n";
      line.assign(indent, ' ');
    }
    if (line.size() > indent) line += ' ';
    line += word;
    start = end + 1;
  }
  return folded + line + "\n";
}

std::string Entry(std::string_view title, std::string_view text) {
  return text.empty() ? "" : fmt::format("  {}\n", title) + Folded(text, 4);
}

std::string ToText(const Distribution& prior) {
  struct Words {
    std::string operator()(double value) const { return fmt::format("{}", value); }
    std::string operator()(const Normal& n) const {
      return fmt::format("normal, mean {}, sd {}", n.mean, n.sd);
    }
    std::string operator()(const Uniform& u) const {
      return fmt::format("uniform, {} to {}", u.min, u.max);
    }
    std::string operator()(const LogNormal& l) const {
      return fmt::format("lognormal, median {}, factor {}", l.median, l.factor);
    }
  };
  return std::visit(Words{}, prior);
}

std::string EffectText(const Effect& effect) {
  std::string text =
      fmt::format("{} (effect)\n", effect.name) + Folded(effect.about, 2);
  const auto add_axes = [&](std::span<const std::string_view> axes,
                            std::string_view where) {
    if (axes.empty() || (axes.size() == 1 && axes[0].empty())) return;
    text += fmt::format("  written {}.AXIS{}, AXIS one of: {}\n",
                        effect.name,
                        where,
                        fmt::join(axes, ", "));
  };
  for (const MachineKind* kind : AllMachineKinds()) {
    const auto axes = AxesOn(effect, kind);
    const bool is_as_declared =
        !kind->where().empty() && std::ranges::equal(effect.axes, axes);
    if (!is_as_declared) add_axes(axes, kind->where());
  }
  for (const Parameter& parameter : effect.parameters) {
    text += fmt::format("  {} [{}], {} to {}; expected: {}\n",
                        parameter.name,
                        parameter.unit,
                        parameter.min,
                        parameter.max,
                        ToText(parameter.prior));
    text += Folded(parameter.doc, 4);
  }
  return text + Entry("plot", effect.words.plot) +
         Entry("values", effect.words.values) + Entry("cause", effect.words.cause) +
         Entry("effect", effect.words.effect) + Entry("action", effect.words.action) +
         Entry("formula", effect.formula) + Entry("looks like", effect.twin) +
         Entry("source", effect.source);
}

std::string ProcedureText(const Procedure& procedure, std::string_view what) {
  std::string text =
      fmt::format("{} ({})\n", procedure.name, what) + Folded(procedure.about, 2);
  if (procedure.has_variants) text += "  variant: as_published or corrected\n";
  return text + Entry("published", procedure.published) +
         Entry("physics", procedure.physics) + Entry("source", procedure.source);
}

std::string CampaignText(const CampaignKind& kind) {
  std::string text = fmt::format("{} (campaign of a plan)\n", kind.id) +
                     Folded(kind.about, 2) + Entry("shows", kind.shows) +
                     Entry("read by", kind.instrument) + "  options\n";
  for (const PlanOption& option : kind.options) {
    text += fmt::format("    {}: {}\n", option.name, option.otherwise);
    text += Folded(option.doc, 6);
  }
  return text;
}

std::string WordText(const Word& word, std::string_view kind) {
  return fmt::format("{} ({})\n", word.name, kind) + Folded(word.meaning, 2);
}

// Those that only its kind of machine has.
Procedures OwnProcedures(const KindScenario& kind) {
  Procedures own = kind.KnownProcedures();
  std::erase_if(own, [](const Procedure* one) { return one->kind.empty(); });
  return own;
}

// "backlash" of "backlash.x" too; every meaning of a word, for some have two.
std::string Explanation(const std::string& name) {
  std::string text;
  const std::string first = name.substr(0, name.find('.'));
  const auto effect = FindEffect(first);
  if (effect) text += EffectText(EffectAt(*effect));
  if (const Procedure* procedure = FindProcedure(name, ProceduresOf(""))) {
    text += ProcedureText(*procedure, "procedure");
  }
  if (const CampaignKind* kind = FindCampaignKind(name)) text += CampaignText(*kind);
  const auto add = [&](std::span<const Word> words, std::string_view kind) {
    for (const Word& word : words) {
      const bool is_meant = word.name == name || word.name == first;
      if (is_meant) text += WordText(word, kind);
    }
  };
  add(ScenarioKeys(), "key");
  add(StudyKeys(), "key of a study");
  add(OutcomeWords(), "outcome");
  add(UnitWords(), "unit");
  add(UncertaintyWords(), "uncertainty");
  for (const auto& kind : AllKindScenarios()) {
    add(kind->OwnEffects(), fmt::format("effect of {}", kind->Owner()));
    for (const Procedure* procedure : OwnProcedures(*kind)) {
      if (procedure->name != name) continue;
      text += ProcedureText(*procedure, fmt::format("procedure of {}", kind->Owner()));
    }
    add(kind->ScenarioSteps(), fmt::format("step of a scenario of {}", kind->Owner()));
    add(kind->OwnKeys(), fmt::format("key of {}", kind->Owner()));
  }
  add(FigureWords(), "figure of a scenario");
  for (const Effect* each : AllEffects()) {
    for (const Parameter& parameter : each->parameters) {
      if (parameter.name != name || effect) continue;
      text +=
          fmt::format("{} [{}] (parameter of {})\n", name, parameter.unit, each->name);
      text += Folded(parameter.doc, 2);
    }
  }
  return text;
}

std::string ListText() {
  std::string text;
  const auto add = [&](std::string_view name, std::string_view about) {
    text += fmt::format("  {:<26}{}\n", name, about);
  };
  text += "Effects: how a machine may differ from its drawing\n";
  for (const Effect* effect : AllEffects()) add(effect->name, effect->about);
  text += "\nProcedures\n";
  for (const Procedure* procedure : ProceduresOf(""))
    add(procedure->name, procedure->about);
  text += "\nCampaigns of a plan: what can be measured\n";
  for (const CampaignKind& kind : AllCampaignKinds()) add(kind.id, kind.about);
  const auto add_names = [&](std::string_view title, std::span<const Word> words) {
    std::vector<std::string_view> names;
    for (const Word& word : words) names.push_back(word.name);
    text += fmt::format("\n{}\n", title);
    text += Folded(fmt::format("{}", fmt::join(names, " ")), 2);
  };
  add_names("Keys of a scenario (`caltwin explain scenario` says them all)",
            ScenarioKeys());
  add_names("Keys of a study (`caltwin explain study` says them all)", StudyKeys());
  add_names("Outcomes", OutcomeWords());
  add_names("Units", UnitWords());
  add_names("Uncertainty", UncertaintyWords());
  for (const auto& kind : AllKindScenarios()) {
    const auto add_of = [&](std::string_view what, std::span<const Word> words) {
      if (!words.empty())
        add_names(fmt::format("{} of {}", what, kind->Owner()), words);
    };
    std::vector<Word> procedures;
    for (const Procedure* one : OwnProcedures(*kind)) {
      procedures.push_back({one->name, one->about});
    }
    add_of("Effects", kind->OwnEffects());
    add_of("Procedures", procedures);
    add_of("Steps of scenarios", kind->ScenarioSteps());
    add_of("Keys", kind->OwnKeys());
  }
  add_names("Figures of scenarios", FigureWords());
  std::vector<Word> kinds;
  for (const MachineKind* kind : AllMachineKinds()) {
    kinds.push_back({kind->name(), kind->about()});
  }
  add_names("Kinds of machines", kinds);
  return text;
}

std::string KeysText(std::string_view of, std::span<const Word> keys) {
  std::string text = fmt::format("The keys of a {} file\n", of);
  for (const Word& word : keys) {
    text += fmt::format("  {}\n", word.name) + Folded(word.meaning, 4);
  }
  return text;
}

// All that there is on machines of a kind, by what it is.
std::string KindText(const MachineKind& kind) {
  std::string text = fmt::format("{} (a kind of machine)\n", kind.name());
  text +=
      Folded(fmt::format("{} Each name below is explained by `caltwin explain NAME`.",
                         kind.about()),
             2);
  const auto add = [&](std::string_view title, std::vector<std::string_view> names) {
    if (names.empty()) return;
    text += fmt::format("\n{}\n", title) +
            Folded(fmt::format("{}", fmt::join(names, " ")), 2);
  };
  const auto scenario = ScenarioOf(kind);
  std::vector<std::string_view> effects, campaigns, procedures, keys;
  for (const Word& word : scenario->OwnEffects()) effects.push_back(word.name);
  for (const Effect* effect : AllEffects()) {
    const bool is_known = std::ranges::find(effects, effect->name) != effects.end();
    if (!is_known && !AxesOn(*effect, &kind).empty()) effects.push_back(effect->name);
  }
  for (const Procedure* one : scenario->KnownProcedures()) {
    procedures.push_back(one->name);
  }
  for (const CampaignKind& campaign : AllCampaignKinds()) {
    if (kind.has_tip() && campaign.PlanOn(&kind) != nullptr)
      campaigns.push_back(campaign.id);
  }
  for (const Word& word : scenario->ScenarioSteps()) procedures.push_back(word.name);
  for (const Word& word : scenario->OwnKeys()) keys.push_back(word.name);
  add("Effects", effects);
  add("Procedures, and steps of scenarios", procedures);
  add("Campaigns of a plan", campaigns);
  add("Keys of its scenarios", keys);
  return text;
}

std::vector<std::string> AllNames() {
  std::vector<std::string> names = {"scenario", "study"};
  for (const MachineKind* kind : AllMachineKinds()) names.emplace_back(kind->name());
  for (const Effect* effect : AllEffects()) {
    names.emplace_back(effect->name);
    for (const Parameter& p : effect->parameters) names.emplace_back(p.name);
  }
  for (const Procedure* procedure : ProceduresOf(""))
    names.emplace_back(procedure->name);
  for (const CampaignKind& kind : AllCampaignKinds()) names.emplace_back(kind.id);
  for (const auto& kind : AllKindScenarios()) {
    for (const std::string& step : kind->StepNames()) names.push_back(step);
    for (const auto words : {kind->OwnEffects(), kind->OwnKeys()}) {
      for (const Word& word : words) names.emplace_back(word.name);
    }
  }
  for (const auto words : {ScenarioKeys(),
                           StudyKeys(),
                           OutcomeWords(),
                           UnitWords(),
                           UncertaintyWords(),
                           FigureWords()}) {
    for (const Word& word : words) names.emplace_back(word.name);
  }
  return names;
}

int Explain(const std::string& name) {
  if (name.empty()) {
    std::cout << ListText();
    return kPassed;
  }
  std::string text = name == "scenario" ? KeysText(name, ScenarioKeys())
                     : name == "study"  ? KeysText(name, StudyKeys())
                                        : Explanation(name);
  for (const MachineKind* kind : AllMachineKinds()) {
    if (kind->name() == name) text = KindText(*kind) + text;
  }
  if (text.empty()) {
    const std::string nearest = NearestWord(name, AllNames());
    throw InputError({},
                     fmt::format("there is nothing called '{}'", name),
                     nearest.empty()
                         ? "`caltwin explain` without a name lists everything"
                         : fmt::format("did you mean '{}'?", nearest));
  }
  std::cout << text;
  return kPassed;
}

}  // namespace

Action DeclareExplain(CLI::App* app) {
  auto name = std::make_shared<std::string>();
  app->add_option(
      "NAME",
      *name,
      "a kind of machine, an effect, procedure, campaign, outcome, unit or key; none: "
      "the list");
  return [name] {
    return Explain(*name);
  };
}

}  // namespace caltwin
