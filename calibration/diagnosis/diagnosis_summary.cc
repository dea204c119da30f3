#include "calibration/diagnosis/diagnosis_summary.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/unseen_rows.h"
#include "sim/base/units.h"
#include "sim/measure/plan_kinds.h"

namespace caltwin {
namespace {

using Answer = DiagnosisSummary::Answer;

std::string Sentence(std::string text) {
  if (text.empty()) return text;
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (text.back() != '.' && text.back() != '!' && text.back() != '?') text += '.';
  return text;
}

void AddOnce(const std::string& text, std::vector<std::string>* all) {
  const std::string sentence = Sentence(text);
  if (sentence.empty() || std::ranges::find(*all, sentence) != all->end()) return;
  all->push_back(sentence);
}

std::string Likely(double probability) {
  constexpr double kLeast = 0.01, kMost = 0.99;
  if (probability < kLeast) return "under 1 %";
  if (probability > kMost) return "over 99 %";
  return fmt::format("{:.0f} %", PercentFromFraction(probability));
}

// "Backlash of X (62 %) or wind-up of the X drive (30 %)"; where one is as good as
// sure, "backlash of X (over 99 %), and these rows cannot tell it from ...".
std::string Candidates(const Finding& finding) {
  constexpr double kWorthANumber = 0.05;
  std::vector<std::string> names;
  for (const FindingCandidate& one : finding.candidates) {
    if (!names.empty() && !one.structural && one.probability < kWorthANumber) continue;
    names.push_back(fmt::format(
        "{} ({})", NameInWords(one.cause, one.axis), Likely(one.probability)));
  }
  constexpr double kAsGoodAsSure = 0.95;
  if (names.size() > 1 && finding.candidates[0].probability > kAsGoodAsSure) {
    const std::string first = names.front();
    names.erase(names.begin());
    return fmt::format(
        "{}, and these rows cannot tell it from {}", first, fmt::join(names, " or "));
  }
  return fmt::format("{}", fmt::join(names, " or "));
}

std::string OfFindings(const Diagnosis& diagnosis) {
  std::vector<std::string> does;
  for (const Finding& finding : diagnosis.findings) {
    const bool is_open = diagnosis.verdict == DiagnosisVerdict::kAmbiguous &&
                         finding.candidates.size() > 1;
    const char* const opens =
        does.empty() ? "More than one cause is possible: " : "Another finding: ";
    does.push_back(is_open ? opens + Candidates(finding) : WhatItDoes(finding));
  }
  constexpr std::size_t kMost = 2;
  const std::size_t more = does.size() - std::min(does.size(), kMost);
  does.resize(does.size() - more);
  std::string text = fmt::format("{}", fmt::join(does, ". "));
  if (more > 0) {
    text += fmt::format(". There {} {} more",
                        more == 1 ? "is" : "are",
                        more == 1 ? "one" : fmt::format("{}", more));
  }
  return text;
}

constexpr const char* kPlainSettings =
    "plain settings (scale, backlash, where things lie)";

// The fact of which `size` is largest; of what is none of those meant, it is 0.
// nullptr: all are.
template <typename Size>
const Fact* Largest(const Facts& facts, const Size& size) {
  const auto largest = std::ranges::max_element(facts.all, {}, size);
  return largest == facts.all.end() || size(*largest) == 0 ? nullptr : &*largest;
}

// How far a scale is off of which nothing says how sure it is.
double UnsureScale(const Fact& fact) {
  const bool is_meant = fact.id == "scale" && !Known(fact.sigmas);
  return is_meant && !fact.figures.empty() ? std::abs(fact.figures[0].value - 1) : 0;
}

double OneSizeError_um(const Fact& fact) {
  return fact.id == "one_size" ? std::abs(fact.figures[0].value) : 0;
}

// What describes the rows best, where nothing answers: a surface, then the rest.
const Fact* FirstDescription(const Diagnosis& diagnosis) {
  const Facts& facts = diagnosis.facts;
  if (const Fact* plane = facts.Find("plane")) return plane;
  return facts.all.empty() ? nullptr : &facts.all.front();
}

// "12 rows that fit nothing were left out".
std::string LeftOut(const Diagnosis& diagnosis) {
  const std::size_t num = diagnosis.outlier_rows.size();
  if (num == 0) return "";
  return num == 1 ? fmt::format(". Row {} fits nothing and was left out",
                                diagnosis.outlier_rows[0])
                  : fmt::format(". {} rows that fit nothing were left out", num);
}

// Where no cause is named and no fact answers.
std::pair<Answer, std::string> OpenAnswer(const Diagnosis& diagnosis) {
  const bool is_open = IsOpen(diagnosis);
  const bool drifts = diagnosis.wander_um_per_sqrt_h > 0;
  if (is_open && drifts) {
    return {Answer::kTooFew,
            "The readings drift, and nothing that was measured with them says why"};
  }
  for (const auto size : {UnsureScale, OneSizeError_um}) {
    const Fact* const largest = Largest(diagnosis.facts, size);
    if (largest != nullptr) return {Answer::kTooFew, largest->sentence};
  }
  const Fact* const first = FirstDescription(diagnosis);
  if (is_open && first != nullptr) {
    return {Answer::kTooFew, first->sentence + ". These rows are too few to tell more"};
  }
  if (is_open && !diagnosis.facts.cannot.empty()) {
    return {Answer::kTooFew,
            "These rows do not determine what is wrong. " +
                Sentence(diagnosis.facts.cannot.front())};
  }
  if (is_open) return {Answer::kTooFew, "These rows are too few to tell anything"};
  if (first != nullptr && first->id == "plane") {
    return {Answer::kNothing,
            fmt::format("No fault shows beyond {}. {}{}",
                        kPlainSettings,
                        first->sentence,
                        LeftOut(diagnosis))};
  }
  return {Answer::kNothing,
          fmt::format("No fault shows: beyond {} there is only {}{}",
                      kPlainSettings,
                      drifts ? "a slow wander and noise" : "noise",
                      LeftOut(diagnosis))};
}

std::pair<Answer, std::string> AnswerOf(const Diagnosis& diagnosis) {
  const NotTheMachine& other = diagnosis.facts.not_the_machine;
  if (!other.reason.empty()) return {Answer::kElsewhere, other.sentence};
  if (diagnosis.verdict == DiagnosisVerdict::kNone) {
    if (diagnosis.min_effect_um > 0) {
      return {Answer::kNothing,
              fmt::format("Beyond {} these rows show nothing of {:g} um or more; what "
                          "is smaller was not asked for",
                          kPlainSettings,
                          diagnosis.min_effect_um)};
    }
    // Facts know no machine: what its file holds they show again.
    if (diagnosis.is_extended && !IsOpen(diagnosis)) {
      return {Answer::kNothing,
              fmt::format("No fault shows: beyond {} and what the machine's file holds "
                          "there is only noise{}",
                          kPlainSettings,
                          LeftOut(diagnosis))};
    }
  }
  const Fact* const first = FirstAnswer(diagnosis);
  const bool is_known = diagnosis.verdict == DiagnosisVerdict::kNamed ||
                        diagnosis.verdict == DiagnosisVerdict::kAmbiguous;
  if (is_known && !diagnosis.findings.empty()) {
    return {Answer::kCause, OfFindings(diagnosis)};
  }
  if (first != nullptr) return {Answer::kFigure, first->sentence};
  if (!diagnosis.findings.empty()) {
    return {Answer::kCause,
            "Something is there that no cause in the catalogue explains: " +
                OfFindings(diagnosis)};
  }
  if (diagnosis.verdict != DiagnosisVerdict::kNone) {
    return {Answer::kCause, "Something is there, but these rows cannot say what"};
  }
  return OpenAnswer(diagnosis);
}

// As a finding's candidates have it; the cause's own word where none has.
std::string SeparatedInWords(const std::string& cause, const Diagnosis& diagnosis) {
  for (const Finding& finding : diagnosis.findings) {
    for (const FindingCandidate& one : finding.candidates) {
      if (one.cause == cause) return NameInWords(one.cause, one.axis);
    }
  }
  return cause;
}

// "The same plate, turned by a quarter (plate_turned_90 in a plan, 10 minutes): that
// tells a bow of Y from a bend of the bed."
std::string NextSentence(const NextCampaign& next, const Diagnosis& diagnosis) {
  const CampaignKind* kind = FindCampaignKind(next.kind);
  std::string about(kind == nullptr ? next.kind : kind->about);
  if (about.ends_with('.')) about.pop_back();
  std::string text = fmt::format("{} (`{}` in a plan", about, next.kind);
  if (next.minutes > 0)
    text += fmt::format(", {:.0f} minutes", std::ceil(next.minutes));
  text += ")";
  std::vector<std::string> names;
  for (const std::string& cause : next.separates) {
    if (cause != "unknown") names.push_back(SeparatedInWords(cause, diagnosis));
  }
  if (names.empty()) return text;
  return text + fmt::format(": that {} {}",
                            names.size() == 1 ? "shows" : "tells apart",
                            fmt::join(names, " and "));
}

void AddFindings(const Diagnosis& diagnosis,
                 const TextNotes& notes,
                 DiagnosisSummary* summary) {
  for (const Finding& finding : diagnosis.findings) {
    if (finding.is_of_facts) continue;  // Its sentence stands among the facts.
    AddOnce(FindingText(finding, diagnosis, notes.measured), &summary->found);
    if (finding.candidates.size() > 1 &&
        diagnosis.verdict == DiagnosisVerdict::kAmbiguous) {
      AddOnce("These rows show alike: " + Candidates(finding), &summary->cannot_tell);
    }
    if (WhatUnseenRowsSay(finding, diagnosis.gain).is_recommended) {
      AddOnce(WhatToDo(finding), &summary->to_do);
    }
  }
}

}  // namespace

const Fact* FirstAnswer(const Diagnosis& diagnosis) {
  // A bad reading is left out; what the others say answers more.
  const Fact* outliers = nullptr;
  for (const Fact& fact : diagnosis.facts.all) {
    if (!fact.is_answer) continue;
    if (fact.id != "outliers") return &fact;
    if (outliers == nullptr) outliers = &fact;
  }
  return outliers;
}

bool IsOpen(const Diagnosis& diagnosis) {
  if (!diagnosis.has_model) return true;
  return !diagnosis.baseline.empty() &&
         std::ranges::none_of(diagnosis.baseline, &BaselineLine::is_determined);
}

std::string AbsorbedText(const std::vector<Absorbed>& absorbed) {
  constexpr std::size_t kMostNamed = 6;
  std::vector<std::string> names;
  for (const Absorbed& one : absorbed) {
    const std::size_t dot = std::min(one.what.find('.'), one.what.size());
    const std::string axis = one.what.substr(std::min(dot + 1, one.what.size()));
    names.push_back(NameInWords(one.what.substr(0, dot), axis));
  }
  if (names.empty()) return "";
  const std::size_t more = names.size() - std::min(names.size(), kMostNamed);
  names.resize(names.size() - more);
  return fmt::format("These rows cannot show {}{}: {} take it up, or no row moves it.",
                     fmt::join(names, "; "),
                     more == 0 ? "" : fmt::format("; and {} more", more),
                     kPlainSettings);
}

nlohmann::ordered_json SummaryJson(const DiagnosisSummary& summary) {
  const auto word = [&] {
    switch (summary.answer) {
      case Answer::kCause:
        return "cause";
      case Answer::kFigure:
        return "figure";
      case Answer::kElsewhere:
        return "elsewhere";
      case Answer::kNothing:
        return "nothing";
      case Answer::kTooFew:
        return "too_few";
    }
    return "";
  };
  return {{"answer", word()},
          {"sentence", summary.sentence},
          {"found", summary.found},
          {"cannot_tell", summary.cannot_tell},
          {"to_do", summary.to_do}};
}

std::string AnswerSentence(const Diagnosis& diagnosis) {
  return Sentence(AnswerOf(diagnosis).second);
}

DiagnosisSummary SummaryOf(const Diagnosis& diagnosis, const TextNotes& notes) {
  DiagnosisSummary summary;
  auto [answer, sentence] = AnswerOf(diagnosis);
  summary.answer = answer;
  summary.sentence = Sentence(std::move(sentence));
  AddFindings(diagnosis, notes, &summary);
  for (const bool is_answer : {true, false}) {
    for (const Fact& fact : diagnosis.facts.all) {
      if (fact.is_answer == is_answer) AddOnce(fact.sentence, &summary.found);
    }
  }
  std::erase(summary.found, summary.sentence);
  for (const std::string& cannot : diagnosis.facts.cannot) {
    AddOnce(cannot, &summary.cannot_tell);
  }
  if (!IsOpen(diagnosis)) {
    AddOnce(AbsorbedText(diagnosis.absorbed), &summary.cannot_tell);
    if (diagnosis.next_campaign) {
      AddOnce(NextSentence(*diagnosis.next_campaign, diagnosis), &summary.to_do);
    }
  }
  for (const Advice& advice : diagnosis.facts.next) {
    AddOnce(advice.sentence, &summary.to_do);
  }
  return summary;
}

}  // namespace caltwin
