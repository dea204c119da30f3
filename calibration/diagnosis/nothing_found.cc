#include "calibration/diagnosis/nothing_found.h"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

// What the rows speak for most, before any was accepted.
std::string Likeliest(const Diagnosis& diagnosis) {
  const EvidenceLine& best = diagnosis.weighed[0];
  std::string name = NameInWords(best.cause, best.axis);
  if (best.cause == "unknown") {
    std::vector<std::string> words;
    for (const std::string& word : best.covariates) {
      words.push_back(CovariateInWords(word));
    }
    name = fmt::format("something that depends on {}", fmt::join(words, " and "));
  }
  return fmt::format("{} (log odds {:.0f})", name, best.log_odds);
}

}  // namespace

void DoubtNone(const Remains& left, Diagnosis* diagnosis) {
  const bool is_none = diagnosis->verdict == DiagnosisVerdict::kNone;
  const bool is_doubtful = left.IsThere() || left.wanders_most;
  if (!is_none || diagnosis->min_effect_um > 0 || !is_doubtful) return;
  diagnosis->verdict = DiagnosisVerdict::kUnknownStructure;
  std::string remark =
      left.IsThere()
          ? fmt::format(
                "{} um rms remain beyond the baseline, where the noise is {} um",
                TwoDigits(UmFromMm(left.rms_mm)),
                TwoDigits(UmFromMm(left.floor_mm)))
          : fmt::format(
                "To read so the machine would have to wander by {} um per root "
                "hour or more, the most that is tried",
                TwoDigits(diagnosis->wander_um_per_sqrt_h));
  remark += ": something is there, but nothing that was tried foretells rows left out";
  if (!diagnosis->weighed.empty() && diagnosis->weighed[0].log_odds > 0) {
    remark += "; the likeliest would be " + Likeliest(*diagnosis);
  }
  diagnosis->remarks.push_back(
      remark +
      ". Measure the same again, in both senses, with temperatures beside it, and see "
      "whether all runs were written down alike");
}

void NameTheLead(Diagnosis* diagnosis) {
  constexpr double kSure_nats = 20;
  const bool drifted = diagnosis->verdict == DiagnosisVerdict::kNone &&
                       diagnosis->wander_um_per_sqrt_h > 0;
  if (!drifted || diagnosis->weighed.empty() ||
      diagnosis->weighed[0].log_odds < kSure_nats) {
    return;
  }
  diagnosis->remarks.push_back(fmt::format(
      "What goes along with the drift most is {}, but with it rows left out are "
      "foretold no better, or its shape is not theirs. Let it happen again: what comes "
      "back at each warming and cooling can be told from a drift that only passes by",
      Likeliest(*diagnosis)));
}

}  // namespace caltwin
