#include "tools/commands/desk.h"

#include "sim/link/open_link.h"

namespace caltwin {

Desk::Desk(const CalibrateOptions& options, const TwinOptions& papers)
    : is_twin_(IsTwin(options)),
      applies_(options.apply),
      person_(std::make_unique<TerminalOperator>(AnswersFor(options))),
      gauge_(std::make_unique<TerminalGauge>(ReadingsOf(options.readings))) {
  if (!is_twin_) RequireAnswers(options);
  bench_.person = person_.get();
  bench_.gauge = gauge_.get();
  bench_.instruments = papers.instruments;
  if (is_twin_) return;
  opened_ = OpenLink(options.link);
  link_ = opened_.get();
}

TerminalOperator::Options Desk::AnswersFor(const CalibrateOptions& options) {
  return {.apply = options.apply, .yes = options.yes || (IsTwin(options) && !CanAsk())};
}

std::string Desk::Farewell() const {
  return applies_ ? "" : "Nothing was applied: --apply does that.";
}

}  // namespace caltwin
