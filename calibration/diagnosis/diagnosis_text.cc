#include "calibration/diagnosis/diagnosis_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/diagnosis_summary.h"
#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/unseen_rows.h"
#include "calibration/facts/facts_text.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

constexpr double kAxisAligned = 0.999;
constexpr double kTold = 0.0005;  // Smaller probabilities are not worth a number.
constexpr std::size_t kMostShown = 8;

double Um(double mm) {
  return UmFromMm(mm);
}

// 0.62 -> "62 %", 0.001 -> "0.1 %".
std::string Percent(double part) {
  const double percent = 100 * std::clamp(part, 0.0, 1.0);
  if (percent > 99.9 && percent < 100) return "over 99.9 %";
  return fmt::format("{:.{}f} %", percent, percent < 10 || percent > 99 ? 1 : 0);
}

std::string Figure(double um) {
  return fmt::format("{:.{}f}", um, um < 100 ? 1 : 0);
}

// The rms after correcting a part `share` of what can be explained [mm].
double AfterShare_mm(const GainFigures& gain, double share) {
  const double before2 = std::pow(gain.blocks.before_mm, 2);
  const double floor2 = std::pow(gain.noise_floor_mm, 2);
  const double left2 =
      before2 - std::clamp(share, 0.0, 1.0) * std::max(before2 - floor2, 0.0);
  return std::sqrt(std::max(left2, 0.0));
}

std::string HowSure(const Finding& finding) {
  const auto rivals =
      std::span(finding.candidates).subspan(finding.candidates.empty() ? 0 : 1);
  double next = 0;
  bool may_be_other = false;
  for (const FindingCandidate& rival : rivals) {
    next = std::max(next, rival.probability);
    constexpr double kFits = 0.05;
    if (rival.structural || rival.probability > kFits) may_be_other = true;
  }
  if (may_be_other) return "but another cause could look like this here (below)";
  if (next < kTold) return "nothing else fits";
  return fmt::format("nothing else fits (next best {})", Percent(next));
}

void AddRivals(const Finding& finding, std::string* text) {
  constexpr double kFits = 0.05;
  std::vector<std::string> rivals;
  for (std::size_t i = 1; i < finding.candidates.size(); ++i) {
    const FindingCandidate& rival = finding.candidates[i];
    if (!rival.structural && rival.probability <= kFits) continue;
    std::string said = NameInWords(rival.cause, rival.axis);
    if (rival.probability >= kTold)
      said += fmt::format(" ({})", Percent(rival.probability));
    rivals.push_back(std::move(said));
  }
  if (rivals.empty()) return;
  *text +=
      fmt::format("  Cannot tell it from: {}. These rows show both alike; {} has {}.\n",
                  fmt::join(rivals, "; "),
                  NameInWords(finding.cause, finding.axis),
                  Percent(finding.probability));
  const auto effect = FindEffect(finding.cause);
  if (effect) *text += fmt::format("  What tells: {}\n", EffectAt(*effect).twin);
}

// What a table is a sum of.
std::string TermsInWords(const FreeMap& map) {
  if (map.covariates.size() > 1) return fmt::format("{} terms", map.terms);
  if (map.covariates[0] == "theta") return fmt::format("{} waves", map.terms);
  if (map.terms == 1) return "a line";
  if (map.terms == 2) return "a line and a bow";
  return fmt::format(
      "a line, a bow and {} cosine{}", map.terms - 2, map.terms == 3 ? "" : "s");
}

// How fine a table can be, and what held it back.
void AddKernel(const Finding& finding, std::string* text) {
  if (!finding.map || finding.map->terms == 0) return;
  const FreeMap& map = *finding.map;
  *text += "  The table: " + TermsInWords(map);
  const std::string& word = map.covariates[0];
  if (map.covariates.size() == 1 && map.knots[0].size() > 2) {
    const double range = map.knots[0].back() - map.knots[0].front();
    const std::string_view unit = UnitOfCovariate(word, finding.is_by_order);
    const std::string along = word == "t" && finding.is_by_order
                                  ? "in their order"
                                  : "of " + CovariateInWords(word);
    *text += fmt::format(" over {:.4g}{} {}, half-waves down to {:.3g}{}",
                         range,
                         unit,
                         along,
                         range / std::max(1, map.terms - 2),
                         unit);
  }
  *text += fmt::format("; prior size {} um, as these rows chose it.\n",
                       TwoDigits(map.prior_size_um));
}

// "straight 12 +- 3 um", and how the part is meant.
std::string PartInWords(const TablePart& part, const Finding& finding) {
  const bool is_surface = finding.map->covariates.size() > 1 &&
                          !finding.map->covariates[0].starts_with("dir_");
  std::string text = part.name;
  if (is_surface && !part.along.empty()) text += " along " + part.along;
  text += " " + WithSd(part.size_um, part.sd_um, "um");
  if (part.period > 0) {
    text += fmt::format(
        " of {:.3g}{}", part.period, UnitOfCovariate(part.along, finding.is_by_order));
  }
  if (part.name == "rest") text += " rms";
  return text;
}

// What the table is made of that has a name.
void AddParts(const Finding& finding, std::string* text) {
  if (!finding.map || finding.map->parts.empty()) return;
  std::vector<std::string> parts;
  for (const TablePart& part : finding.map->parts) {
    parts.push_back(PartInWords(part, finding));
  }
  *text += fmt::format("  In parts: {}.\n", fmt::join(parts, "; "));
}

// The verdict's word of the catalogue's causes, then the answer whatever it is about.
std::string Headline(const Diagnosis& diagnosis) {
  return fmt::format(
      "Verdict: {}. {}", ToString(diagnosis.verdict), AnswerSentence(diagnosis));
}

void AddHeldOut(const HeldOut& held, std::string_view what, std::string* text) {
  if (held.groups == 0) return;
  *text +=
      fmt::format("With {} left out in turn: {} um rms before, {} after ({} rows).\n",
                  what,
                  Figure(Um(held.before_mm)),
                  Figure(Um(held.after_mm)),
                  held.rows);
}

void AddGain(const Diagnosis& diagnosis, std::string* text) {
  const GainFigures& gain = diagnosis.gain;
  const std::string floor_from = gain.floor_from_replicates
                                     ? "from repeated readings"
                                     : "from what the richest model leaves";
  if (diagnosis.findings.empty()) {
    *text += fmt::format(
        "The baseline predicts rows it has not seen to {} um rms; the noise floor is "
        "{} "
        "({}).\n",
        Figure(Um(gain.blocks.before_mm)),
        Figure(Um(gain.noise_floor_mm)),
        floor_from);
    return;
  }
  *text += fmt::format("The noise floor is {}; explained: {} of what can be.\n",
                       floor_from,
                       Percent(gain.explained_fraction));
  AddHeldOut(gain.runs, "runs", text);
  AddHeldOut(gain.positions, "positions (inner ones)", text);
  AddHeldOut(gain.ends, "the ends (an extrapolation)", text);
}

// The best of each cause; causes on several axes are told once.
void AddWouldShow(const std::vector<WouldShow>& all, std::string* text) {
  std::vector<std::string> shown, hidden;
  std::set<std::string> told;
  for (const WouldShow& one : all) {
    if (!told.insert(one.cause).second) continue;
    const std::string name = NameInWords(one.cause, one.axis);
    constexpr double kAnyMachine_mm = 2;  // Nobody asks for errors larger than that.
    if (one.smallest_mm < kAnyMachine_mm) {
      shown.push_back(
          fmt::format("{} from {} um", name, TwoDigits(Um(one.smallest_mm))));
    } else {
      hidden.push_back(name);
    }
  }
  const std::size_t more = shown.size() - std::min(shown.size(), kMostShown);
  shown.resize(shown.size() - more);
  if (!shown.empty()) {
    *text += fmt::format(
        "They would have shown {}{}.\n",
        fmt::join(shown, ", "),
        more > 0 ? fmt::format(", and {} other causes less sharply", more) : "");
  }
  if (!hidden.empty()) {
    *text += fmt::format("They could not show {}: the baseline takes it up.\n",
                         fmt::join(hidden, ", "));
  }
}

void AddCannotTell(const Diagnosis& diagnosis, std::string* text) {
  const std::string absorbed = AbsorbedText(diagnosis.absorbed);
  if (!absorbed.empty()) *text += absorbed + "\n";
  if (!diagnosis.next_campaign) return;
  *text += NextInWords(*diagnosis.next_campaign) + ".\n";
}

void AddChanges(const TextNotes& notes, std::string* text) {
  if (!notes.has_before) return;
  std::vector<Change> changed = notes.changes;
  const auto open = std::ranges::stable_partition(changed, &Change::IsCompared);
  std::vector<std::string> not_told;
  for (const Change& change : open) not_told.push_back(change.name);
  changed.erase(open.begin(), open.end());
  const auto same = std::ranges::stable_partition(changed, &Change::is_more_than_noise);
  const auto count = changed.size() - same.size();
  if (notes.changes.empty()) {
    *text += "\nSince the earlier rows: the two have no figure in common.\n";
    return;
  }
  *text += fmt::format(
      "\nSince the earlier rows, {}:\n",
      count == 0
          ? "nothing changed by more than noise"
          : fmt::format(
                "{} of {} figures changed by more than noise", count, changed.size()));
  for (const Change& change : changed) {
    *text +=
        fmt::format("  {:<24} {} -> {}  {}\n",
                    change.name,
                    WithSd(change.before, change.before_sd, change.unit),
                    WithSd(change.now, change.now_sd, change.unit),
                    change.is_more_than_noise
                        ? fmt::format("changed ({:.1f} sigma)", change.sigmas)
                        : fmt::format("within noise ({:.1f} sigma)", change.sigmas));
  }
  if (!not_told.empty()) {
    *text += fmt::format("  not told by one of the two, so not compared: {}\n",
                         fmt::join(not_told, ", "));
  }
}

void AddBaseline(const Diagnosis& diagnosis, std::string* text) {
  if (diagnosis.baseline.empty()) return;
  *text += "\nBaseline (built minus believed, always fitted):\n";
  std::vector<std::string> open;
  for (const BaselineLine& line : diagnosis.baseline) {
    if (!line.is_determined) {
      open.push_back(line.name);
      continue;
    }
    *text +=
        fmt::format("  {:<28} {}\n", line.name, WithSd(line.value, line.sd, line.unit));
  }
  if (!open.empty()) {
    *text += fmt::format("  not determined by these rows: {}\n", fmt::join(open, ", "));
  }
}

void AddRows(const Diagnosis& diagnosis, std::string* text) {
  if (!diagnosis.outlier_rows.empty()) {
    const bool is_one = diagnosis.outlier_rows.size() == 1;
    *text +=
        fmt::format("\n{} {} left out: beyond 4.2 sigma of everything that fits.\n",
                    is_one ? "Row" : "Rows",
                    fmt::join(diagnosis.outlier_rows, ", "));
  }
  if (diagnosis.wander_um_per_sqrt_h > 0) {
    *text += fmt::format(
        "{}Slow wander of {} um per root hour is part of the noise: the "
        "machine drifts in a way that no cause here explains. One datum touched every "
        "few minutes, the temperatures beside it, would tell more.\n",
        diagnosis.outlier_rows.empty() ? "\n" : "",
        TwoDigits(diagnosis.wander_um_per_sqrt_h));
  }
  for (const std::string& remark : diagnosis.remarks) *text += "Note: " + remark + "\n";
}

}  // namespace

std::string WhatRowsMeasure(const RowTable& table) {
  std::optional<Axis> common;
  for (const Row& row : table.rows) {
    std::optional<Axis> along;
    for (const Axis axis : kAxes) {
      if (std::abs(row.n[Index(axis)]) > kAxisAligned) along = axis;
    }
    if (!along || (common && *common != *along)) return "the rows";
    common = along;
  }
  return common ? std::string(1, CapitalLetter(*common)) : "the rows";
}

std::string FindingText(const Finding& finding,
                        const Diagnosis& diagnosis,
                        const std::string& measured) {
  const GainFigures& gain = diagnosis.gain;
  constexpr double kNoShare = 0.005;
  if (finding.share < kNoShare) {
    return fmt::format(
        "{}; {}. The rows fit no better with it: without it the baseline would need "
        "values that are not believable.",
        WhatItDoes(finding),
        HowSure(finding));
  }
  std::string text = fmt::format("{}: {} of what the model could not explain; {}. ",
                                 WhatItDoes(finding),
                                 Percent(finding.share),
                                 HowSure(finding));
  const double alone_mm = diagnosis.findings.size() == 1
                              ? gain.blocks.after_mm
                              : AfterShare_mm(gain, finding.share);
  constexpr double kWorse = 1.1;
  const bool is_worse = !finding.map && alone_mm > kWorse * gain.blocks.before_mm;
  const std::string before = Figure(Um(gain.blocks.before_mm));
  const std::string after = Figure(Um(alone_mm));
  text += is_worse ? fmt::format(
                         "Of data it has not seen it foretells less than nothing ({} "
                         "{} um without it, {} with): take the name, and not the "
                         "size; ",
                         measured,
                         before,
                         after)
                   : fmt::format(
                         "Correcting it takes {} from {} to {} um on data it has not "
                         "seen; ",
                         measured,
                         before,
                         after);
  if (diagnosis.findings.size() > 1) {
    text +=
        fmt::format("all findings together to {}; ", Figure(Um(gain.blocks.after_mm)));
  }
  text += fmt::format("the noise floor is {}.", Figure(Um(gain.noise_floor_mm)));
  return text;
}

std::string DiagnosisText(const Diagnosis& diagnosis, const TextNotes& notes) {
  const std::string headline = Headline(diagnosis);
  std::string text = headline + "\n";
  for (const Finding& finding : diagnosis.findings) {
    if (finding.is_of_facts) continue;  // Its sentence stands among the facts.
    text += "\n" + FindingText(finding, diagnosis, notes.measured) + "\n";
    AddRivals(finding, &text);
    AddKernel(finding, &text);
    AddParts(finding, &text);
    const UnseenRows unseen = WhatUnseenRowsSay(finding, diagnosis.gain);
    if (!unseen.worse.empty()) text += "  " + unseen.worse + "\n";
    const std::string action = unseen.is_recommended ? WhatToDo(finding) : "";
    if (!action.empty()) text += "  What to do: " + action + "\n";
  }
  const std::string facts = FactsText(diagnosis.facts, headline);
  if (!facts.empty()) text += "\n" + facts;
  text += "\n";
  if (!IsOpen(diagnosis)) {
    AddGain(diagnosis, &text);
    if (diagnosis.verdict == DiagnosisVerdict::kNone)
      AddWouldShow(notes.would_show, &text);
    AddCannotTell(diagnosis, &text);
  }
  AddChanges(notes, &text);
  if (!IsOpen(diagnosis)) AddBaseline(diagnosis, &text);
  AddRows(diagnosis, &text);
  return text;
}

}  // namespace caltwin
