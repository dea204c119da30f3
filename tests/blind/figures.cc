#include "tests/blind/figures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

namespace blind {
namespace {

constexpr double kChance = 1e-3;
constexpr double kSeen = 100;     ///< Sum of squares: the plan can see it at all.
constexpr double kSeparated = 9;  ///< Told from every twin under this plan.
constexpr double kConfident = 0.97;

using Condition = std::function<bool(const Judgement&)>;

Figure Counted(const std::vector<Judgement>& judgements,
               Figure figure,
               const Condition& counts,
               const Condition& hit) {
  for (const Judgement& judgement : judgements) {
    if (!counts(judgement)) continue;
    ++figure.cases;
    if (hit(judgement)) ++figure.hits;
  }
  return figure;
}

bool IsSingle(const Judgement& j, double sigma) {
  return j.kind == "single" && j.sigma >= sigma && j.sum_squares >= kSeen;
}

bool NamesAWrongMechanism(const Judgement& j) {
  return std::ranges::any_of(j.findings, [](const JudgedFinding& f) {
    return !f.right && !f.tolerable && f.cause != "unknown" && f.cause != "pitch_map";
  });
}

Figure Confident(const std::vector<Judgement>& judgements) {
  Figure figure{.what = "single-name answers stated above 0.97: right",
                .must = 0.97,
                .aim = 0.99};
  for (const Judgement& judgement : judgements) {
    for (const JudgedFinding& finding : judgement.findings) {
      if (finding.cause == "unknown" || !finding.alone ||
          finding.probability <= kConfident) {
        continue;
      }
      ++figure.cases;
      if (finding.right || finding.tolerable) ++figure.hits;
    }
  }
  return figure;
}

Figure Coverage(const std::vector<Judgement>& judgements) {
  Figure figure{.what = "95 % intervals cover the truth", .must = 0.90, .aim = 0.93};
  for (const Judgement& judgement : judgements) {
    figure.cases += judgement.intervals;
    figure.hits += judgement.covered;
  }
  return figure;
}

std::string MedianText(const std::vector<Judgement>& judgements) {
  std::vector<double> shares;
  std::vector<double> seconds;
  for (const Judgement& j : judgements) {
    if (j.ran) seconds.push_back(j.seconds);
    if (IsSingle(j, 3) && j.explained >= 0) shares.push_back(j.explained);
  }
  const auto median = [](std::vector<double> values) {
    std::ranges::sort(values);
    return values.empty() ? 0.0 : values[values.size() / 2];
  };
  return fmt::format(
      "\nEffect variance removed at 3 sigma and above, median of {}: {:.3f} (must "
      "0.95, "
      "aim 0.99). Time a case, median {:.2f} s, longest {:.2f} s.\n",
      shares.size(),
      median(shares),
      median(seconds),
      seconds.empty() ? 0.0 : *std::ranges::max_element(seconds));
}

/// Stated probability against how often it was right, of all named findings.
std::string ReliabilityText(const std::vector<Judgement>& judgements) {
  struct Bin {
    double low;
    int cases = 0, right = 0;
    double stated = 0;
  };
  std::vector<Bin> bins = {{0}, {0.5}, {0.8}, {0.9}, {0.97}, {0.99}};
  for (const Judgement& judgement : judgements) {
    for (const JudgedFinding& finding : judgement.findings) {
      if (finding.cause == "unknown") continue;
      const auto bin = std::find_if(bins.rbegin(), bins.rend(), [&](const Bin& b) {
        return finding.probability >= b.low;
      });
      if (bin == bins.rend()) continue;
      ++bin->cases;
      bin->stated += finding.probability;
      if (finding.right || finding.tolerable) ++bin->right;
    }
  }
  std::string text =
      "\n| stated probability from | findings | stated, mean | right |\n";
  text += "|---|---|---|---|\n";
  for (const Bin& bin : bins) {
    if (bin.cases == 0) continue;
    text += fmt::format("| {:.2f} | {} | {:.3f} | {:.3f} |\n",
                        bin.low,
                        bin.cases,
                        bin.stated / bin.cases,
                        static_cast<double>(bin.right) / bin.cases);
  }
  return text;
}

Figure OfPairs(const std::vector<Judgement>& all, const Figure& figure, int least) {
  return Counted(
      all,
      figure,
      [](const Judgement& j) {
        return j.kind == "pair" && j.sigma >= 2 && j.sum_squares >= kSeen;
      },
      [least](const Judgement& j) { return j.hidden_told >= least; });
}

Figure OfLoops(const std::vector<Judgement>& all) {
  return Counted(
      all,
      {"closed loops: ended with the right cause alone", 0, 0, 0.80, 0.95},
      [](const Judgement& j) { return j.kind == "loop"; },
      [](const Judgement& j) {
        return j.first_right && j.findings[0].alone && j.findings.size() == 1;
      });
}

}  // namespace

double BinomialTail(int hits, int cases, double rate) {
  double tail = 0;
  for (int k = hits; k <= cases; ++k) {
    const double log_choose =
        std::lgamma(cases + 1.0) - std::lgamma(k + 1.0) - std::lgamma(cases - k + 1.0);
    tail += std::exp(log_choose + k * std::log(rate) + (cases - k) * std::log1p(-rate));
  }
  return tail;
}

Interval Wilson95(int hits, int cases) {
  if (cases == 0) return {};
  const double z = 1.96;
  const double n = cases;
  const double p = hits / n;
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half =
      z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

bool Figure::IsBeyondChance() const {
  if (cases == 0) return false;
  const int failures = at_most ? hits : cases - hits;
  return BinomialTail(failures, cases, at_most ? must : 1 - must) < kChance;
}

std::vector<Figure> Figures(const std::vector<Judgement>& all) {
  const auto single3 = [](const Judgement& j) {
    return IsSingle(j, 3);
  };
  const auto named = [](const Judgement& j) {
    return j.first_right;
  };
  return {
      Counted(
          all,
          {"null data: any finding", 0, 0, 0.01, 0.002, true},
          [](const Judgement& j) { return j.kind == "null"; },
          [](const Judgement& j) { return !j.ran || j.verdict != "none"; }),
      Counted(
          all,
          {"one cause, 3 sigma and above: name and axis right", 0, 0, 0.95, 0.98},
          [&](const Judgement& j) { return single3(j) && j.separation >= kSeparated; },
          named),
      Counted(
          all,
          {"missed at 2 sigma and above", 0, 0, 0.02, 0.005, true},
          [](const Judgement& j) { return IsSingle(j, 2); },
          [](const Judgement& j) { return j.findings.empty(); }),
      Counted(all,
              {"true cause inside the reported set, any plan", 0, 0, 0.95, 0.98},
              single3,
              [](const Judgement& j) { return j.set_holds; }),
      Confident(all),
      Counted(
          all,
          {"outside the library: a wrong mechanism named", 0, 0, 0.02, 0, true},
          [](const Judgement& j) { return j.kind == "outside"; },
          NamesAWrongMechanism),
      OfPairs(all, {"two causes, 2-15 sigma: both named", 0, 0, 0.85, 0.93}, 2),
      OfPairs(all, {"two causes, 2-15 sigma: at least one named", 0, 0, 0.95, 0.98}, 1),
      OfLoops(all),
      Coverage(all),
      Counted(
          all,
          {"re-diagnosis of the extended model says none", 0, 0, 0.95, 0.99},
          [](const Judgement& j) { return j.rediagnosed && j.kind == "single"; },
          [](const Judgement& j) { return j.idempotent; }),
      Counted(
          all,
          {"one cause: a wrong mechanism beside or instead", 0, 0, 0.05, 0.02, true},
          [](const Judgement& j) { return IsSingle(j, 0); },
          [](const Judgement& j) { return NamesAWrongMechanism(j) && !j.set_holds; }),
      Counted(
          all,
          {"ended without an answer", 0, 0, 0.001, 0, true},
          [](const Judgement&) { return true; },
          [](const Judgement& j) { return !j.ran; })};
}

std::string FiguresText(const std::vector<Judgement>& judgements) {
  std::string text =
      "| figure | rate | 95 % | of | must | aim | |\n|---|---|---|---|---|---|---|\n";
  for (const Figure& figure : Figures(judgements)) {
    const Interval interval = Wilson95(figure.hits, figure.cases);
    text += fmt::format(
        "| {} | {:.2f} % | {:.1f}-{:.1f} % | {} | {}{:g} % | {:g} % | {} |\n",
        figure.what,
        100 * figure.Rate(),
        100 * interval.low,
        100 * interval.high,
        figure.cases,
        figure.at_most ? "<= " : ">= ",
        100 * figure.must,
        100 * figure.aim,
        figure.cases == 0         ? "-"
        : figure.IsBeyondChance() ? "FAILED"
        : figure.Reaches()        ? "reached"
        : interval.low <= figure.must && figure.must <= interval.high
            ? "missed, within chance"
            : "missed");
  }
  return text + MedianText(judgements) + ReliabilityText(judgements);
}

std::string NameRatesText(const std::vector<Judgement>& judgements) {
  struct Count {
    int cases = 0, right = 0, physics = 0, physics_right = 0;
  };
  std::map<std::string, Count> counts;
  for (const Judgement& j : judgements) {
    if (!IsSingle(j, 3) || j.separation < kSeparated) continue;
    Count& count = counts[j.name.substr(0, j.name.find(' '))];
    ++count.cases;
    count.right += j.first_right ? 1 : 0;
    count.physics += j.physics ? 1 : 0;
    count.physics_right += j.physics && j.first_right ? 1 : 0;
  }
  std::string text =
      "| hidden, 3 sigma and above, apart from every twin | named | of | rate | by "
      "MuJoCo |\n|---|---|---|---|---|\n";
  for (const auto& [cause, count] : counts) {
    text +=
        fmt::format("| {} | {} | {} | {:.0f} % | {} |\n",
                    cause,
                    count.right,
                    count.cases,
                    100.0 * count.right / count.cases,
                    count.physics == 0
                        ? std::string("-")
                        : fmt::format("{} of {}", count.physics_right, count.physics));
  }
  return text;
}

std::string AllText(const std::vector<Judgement>& judgements) {
  std::vector<Judgement> physics;
  std::vector<Judgement> closed;
  for (const Judgement& j : judgements) (j.physics ? physics : closed).push_back(j);
  std::string text = FiguresText(judgements);
  if (!physics.empty() && !closed.empty()) {
    text += "\n## Performed by MuJoCo\n\n" + FiguresText(physics);
    text += "\n## Of closed form\n\n" + FiguresText(closed);
  }
  return text + "\n## Names\n\n" + NameRatesText(judgements) + "\n" +
         ConfusionText(judgements);
}

std::string ConfusionText(const std::vector<Judgement>& judgements) {
  std::map<std::string, std::map<std::string, int>> rows;
  for (const Judgement& j : judgements) {
    const bool counts = j.kind == "null" || j.kind == "outside" || IsSingle(j, 3);
    if (!counts) continue;
    const std::string hidden = j.name.substr(0, j.name.find(' '));
    std::string answer = j.ran ? "none" : "failed";
    if (!j.findings.empty()) {
      const JudgedFinding& first = j.findings[0];
      answer =
          first.right ? "right" : first.cause + (first.holds ? " (set holds it)" : "");
    }
    ++rows[j.kind == "null" ? "nothing" : hidden][answer];
  }
  std::string text =
      "| hidden | cases | right | none | other answers |\n|---|---|---|---|---|\n";
  for (auto& [hidden, answers] : rows) {
    int cases = 0;
    for (const auto& [answer, count] : answers) cases += count;
    std::string others;
    for (const auto& [answer, count] : answers) {
      if (answer == "right" || answer == "none") continue;
      others += fmt::format("{}{} {}", others.empty() ? "" : ", ", answer, count);
    }
    text += fmt::format("| {} | {} | {} | {} | {} |\n",
                        hidden,
                        cases,
                        answers["right"],
                        answers["none"],
                        others);
  }
  return text;
}

}  // namespace blind
