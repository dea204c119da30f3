// Numbers that may be drawn.

#include <fmt/format.h>

#include "sim/base/yaml.h"

namespace caltwin {

Distribution YamlValue::NumberOrDistribution(Bounds bounds,
                                             std::string_view hint) const {
  if (!node_.IsMap()) return Number(bounds, hint);
  YamlMap map = Map();
  const auto entries = map.Entries();
  const std::string kind = entries.size() == 1 ? entries[0].first : "";
  if (kind != "normal" && kind != "uniform" && kind != "lognormal") {
    Fail(
        "is neither a number nor a distribution",
        "a distribution is one of {normal: {mean: , sd: }}, {uniform: {min: , max: }}, "
        "{lognormal: {median: , factor: }}");
    return 0.0;
  }
  YamlMap inner = entries[0].second.Map();
  Distribution result = 0.0;
  if (kind == "normal") {
    result =
        Normal{inner.Number("mean", bounds, hint), inner.Number("sd", kNotNegative)};
  } else if (kind == "uniform") {
    const Uniform u{inner.Number("min", bounds, hint),
                    inner.Number("max", bounds, hint)};
    if (u.min > u.max) Fail(fmt::format("has min {} above max {}", u.min, u.max));
    result = u;
  } else {
    result = LogNormal{inner.Number("median", {1e-12, bounds.max}, hint),
                       inner.Number("factor", {1, 1e6})};
  }
  inner.NoMoreKeys();
  NoteWhatIsClamped(result, bounds);
  return result;
}

void YamlValue::NoteWhatIsClamped(const Distribution& distribution,
                                  Bounds bounds) const {
  constexpr double kNotWorthANote = 1e-3;
  const auto note = [&](double share, std::string_view side, double bound) {
    if (share < kNotWorthANote) return;
    faults_->Note(place(),
                  fmt::format("{}: {:.2g} % of what this draws is {} {} and becomes {}",
                              path_,
                              100 * share,
                              side,
                              bound,
                              bound));
  };
  const ShareBeyond beyond = Beyond(distribution, bounds.min, bounds.max);
  note(beyond.below, "below", bounds.min);
  note(beyond.above, "above", bounds.max);
}

}  // namespace caltwin
