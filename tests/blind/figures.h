#pragma once

#include <string>
#include <vector>

#include "tests/blind/judge.h"

namespace blind {

/// A rate with what must be reached.
struct Figure {
  std::string what{};
  int hits = 0;   ///< Cases in which it came true.
  int cases = 0;  ///< Cases that count.
  double must = 0, aim = 0;
  bool at_most = false;  ///< A rate of failures: must is an upper limit.

  double Rate() const { return cases == 0 ? 0 : static_cast<double>(hits) / cases; }
  bool Reaches() const { return at_most ? Rate() <= must : Rate() >= must; }
  /// Worse than chance allows of a diagnosis that just reaches `must` (0.1 %).
  bool IsBeyondChance() const;
};

/// P(X >= hits) of a binomial distribution.
double BinomialTail(int hits, int cases, double rate);

/// Wilson's 95 % interval of a rate.
struct Interval {
  double low = 0, high = 1;
};
Interval Wilson95(int hits, int cases);

/// The table at the end of the specification, from judged cases.
std::vector<Figure> Figures(const std::vector<Judgement>& judgements);

/// The table, medians and reliability as Markdown.
std::string FiguresText(const std::vector<Judgement>& judgements);

/// How often each cause was named where it shows with 3 sigma and more and no twin
/// hides it, as Markdown.
std::string NameRatesText(const std::vector<Judgement>& judgements);

/// All of the above, of all cases, of those performed by MuJoCo, and of the others.
std::string AllText(const std::vector<Judgement>& judgements);

/// Hidden cause against named cause (single causes of 3 sigma and above), as Markdown.
std::string ConfusionText(const std::vector<Judgement>& judgements);

}  // namespace blind
