#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"

namespace caltwin {
namespace {

std::string Group(std::string_view title, const std::string& html) {
  return html.empty() ? "" : fmt::format("<h3>{}</h3>\n{}", title, html);
}

std::vector<std::string> Messages(const RunResult& result, Message::Kind kind) {
  // The heading says whose words they are.
  const std::string whose = MachineSaid("").text;
  std::vector<std::string> texts;
  for (const Message& message : result.messages) {
    if (message.kind != kind) continue;
    const bool is_said = message.text.starts_with(whose);
    texts.push_back(is_said ? message.text.substr(whose.size()) : message.text);
  }
  return texts;
}

// Long lists that only somebody who doubts will read.
std::string Folded(std::string_view title, const std::vector<std::string>& texts) {
  const std::string list = ListHtml(texts);
  return list.empty()
             ? ""
             : fmt::format("<details><summary>{} ({})</summary>\n{}</details>\n",
                           title,
                           texts.size(),
                           list);
}

// What stands in the way: settings that were not applied, or taken back.
std::vector<std::string> NotApplied(const RunResult& result) {
  std::vector<std::string> not_applied;
  for (const Step& step : result.steps) {
    const bool is_refused = step.verdict == Verdict::kRefused;
    if (!is_refused && step.verdict != Verdict::kRolledBack) continue;
    not_applied.push_back(fmt::format("{} of {}: {}{}{}",
                                      step.name,
                                      step.procedure,
                                      is_refused ? "refused" : "rolled back",
                                      step.message.empty() ? "" : ", ",
                                      step.message));
  }
  return not_applied;
}

// Combinations along which readings do not change, so that no estimator can tell.
std::string NotTold(const RunResult& result) {
  std::string items;
  std::set<std::string> said;
  for (const Observability& item : result.observability) {
    if (!said.insert(item.statement).second) continue;
    items += fmt::format("<li>{}", SentenceHtml(item.statement));
    std::string blind;
    for (const auto& [name, share] : item.blind_direction) {
      blind += fmt::format(
          "{}{:+.2f} <code>{}</code>", blind.empty() ? "" : ", ", share, Escaped(name));
    }
    if (!blind.empty()) {
      items += fmt::format("<br><span class=\"kind\">blind along {}</span>", blind);
    }
    items += "</li>\n";
  }
  std::string silent;
  for (const ParameterResult& parameter : result.parameters) {
    if (parameter.identifiable || parameter.recovered) continue;
    silent += fmt::format(
        "{}<code>{}</code>", silent.empty() ? "" : ", ", Escaped(parameter.name));
  }
  if (!silent.empty())
    items += fmt::format("<li>No value is told for {}.</li>\n", silent);
  return items.empty() ? "" : "<ul>\n" + items + "</ul>\n";
}

}  // namespace

std::string MeaningSection(const RunResult& result,
                           const ReportPictures& /*pictures*/) {
  using enum Message::Kind;
  return Group("What was found", ListHtml(Messages(result, kFound))) +
         Group("What these measurements cannot tell", NotTold(result)) +
         Group("What was not applied, and why", ListHtml(NotApplied(result))) +
         Group("What to do", ListHtml(Messages(result, kToDo))) +
         Group("What the machine said", ListHtml(Messages(result, kMachine))) +
         Folded("What was verified", Messages(result, kCheck)) +
         Folded("What each plan determines, and what would determine more",
                Messages(result, kOpen)) +
         Folded("What was written", Messages(result, kLog));
}

}  // namespace caltwin
