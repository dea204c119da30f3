#include "calibration/diagnosis/extension.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/map_table.h"

namespace caltwin {
namespace {

std::string Name(const std::string& cause, const std::string& axis) {
  return axis.empty() ? cause : cause + "." + axis;
}

std::string ListOf(const std::vector<double>& numbers) {
  std::vector<std::string> words;
  for (const double number : numbers) words.push_back(fmt::format("{:.9g}", number));
  return fmt::format("[{}]", fmt::join(words, ", "));
}

std::string RivalsOf(const Finding& finding) {
  std::vector<std::string> rivals;
  for (std::size_t i = 1; i < finding.candidates.size(); ++i) {
    rivals.push_back(Name(finding.candidates[i].cause, finding.candidates[i].axis));
  }
  return fmt::format("[{}]", fmt::join(rivals, ", "));
}

std::string EffectText(const Finding& finding) {
  std::string text = fmt::format("  {}:\n", Name(finding.cause, finding.axis));
  const auto parameters = EffectAt(finding.effect->effect).parameters;
  std::vector<std::string> sds;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    text +=
        fmt::format("    {}: {:.9g}\n", parameters[i].name, finding.effect->values[i]);
    if (i < finding.sds.size()) {
      sds.push_back(fmt::format("{}: {:.3g}", parameters[i].name, finding.sds[i]));
    }
  }
  text += fmt::format("    sd: {{{}}}\n", fmt::join(sds, ", "));
  text += fmt::format("    probability: {:.6g}\n", finding.probability);
  return text + fmt::format("    rivals: {}\n", RivalsOf(finding));
}

std::string MapText(const Finding& finding) {
  const FreeMap& map = *finding.map;
  std::string text = fmt::format("  - channel: {}\n    covariates: [{}]\n    knots:\n",
                                 map.channel,
                                 fmt::join(map.covariates, ", "));
  for (const auto& knots : map.knots)
    text += fmt::format("      - {}\n", ListOf(knots));
  text += fmt::format("    values: {}\n", ListOf(map.values_um));
  if (!map.sds_um.empty()) text += fmt::format("    sd: {}\n", ListOf(map.sds_um));
  text += fmt::format("    probability: {:.6g}\n", finding.probability);
  return text + fmt::format("    rivals: {}\n", RivalsOf(finding));
}

std::string EvidenceText(const std::vector<Finding>& findings,
                         const GainFigures& gain,
                         const ExtensionBase& base) {
  std::string text =
      fmt::format("evidence:\n  data_sha256: \"{}\"\n", base.data_sha256);
  text += "  log_odds:  # against none, natural logarithm\n";
  for (const Finding& finding : findings) {
    text += fmt::format("    \"{}\": {:.6g}\n", KeyOf(finding), finding.log_odds);
  }
  return text + fmt::format(
                    "  gain: {{rmse_before_um: {:.4g}, rmse_after_um: {:.4g}, "
                    "explained_fraction: {:.4g}}}\n",
                    UmFromMm(gain.blocks.before_mm),
                    UmFromMm(gain.blocks.after_mm),
                    gain.explained_fraction);
}

// The knots of both, those that a file's nine digits would not tell apart once.
std::vector<double> Joined(std::vector<double> knots, const std::vector<double>& more) {
  constexpr double kSame = 1e-6;  // Of the range.
  knots.insert(knots.end(), more.begin(), more.end());
  std::ranges::sort(knots);
  const double range = knots.back() - knots.front();
  const auto is_same = [&](double one, double next) {
    return next - one <= kSame * range;
  };
  knots.erase(std::unique(knots.begin(), knots.end(), is_same), knots.end());
  return knots;
}

// What one of a table's lists of values says at (u, v), linear between knots and
// constant outside them; v of a table over one covariate is of no meaning.
double ValueAt(const FreeMap& map,
               const std::vector<double>& values,
               double u,
               double v) {
  const Between<double> row = Locate<double>(map.knots[0], u);
  Between<double> column;
  std::size_t columns = 1;
  if (map.knots.size() == 2) {
    column = Locate<double>(map.knots[1], v);
    columns = map.knots[1].size();
  }
  const auto along = [&](std::size_t r) {
    const double near = values[r * columns + column.first];
    return near + column.share * (values[r * columns + column.second] - near);
  };
  const double near = along(row.first);
  return near + row.share * (along(row.second) - near);
}

// On the knots of both a sum of two such tables is one, exactly.
FreeMap Sum(const FreeMap& one, const FreeMap& other) {
  FreeMap sum = one;
  sum.values_um.clear();
  sum.sds_um.clear();
  for (std::size_t i = 0; i < one.knots.size(); ++i) {
    sum.knots[i] = Joined(one.knots[i], other.knots[i]);
  }
  const bool has_sds = !one.sds_um.empty() && !other.sds_um.empty();
  const std::vector<double> any = {0};
  for (const double u : sum.knots[0]) {
    for (const double v : sum.knots.size() == 2 ? sum.knots[1] : any) {
      sum.values_um.push_back(ValueAt(one, one.values_um, u, v) +
                              ValueAt(other, other.values_um, u, v));
      if (!has_sds) continue;
      sum.sds_um.push_back(std::hypot(ValueAt(one, one.sds_um, u, v),
                                      ValueAt(other, other.sds_um, u, v)));
    }
  }
  return sum;
}

bool HasTable(const Finding& finding) {
  return finding.map && !finding.map->knots.empty();
}

// Adds a finding to an earlier one of its name. False where both have a formula: the
// sum of two waves is no wave.
bool AddTo(Finding* earlier, const Finding& more) {
  if (earlier->effect || more.effect) return false;
  earlier->log_odds += more.log_odds;
  earlier->probability = std::max(earlier->probability, more.probability);
  if (!HasTable(more)) return true;
  earlier->map = HasTable(*earlier) ? Sum(*earlier->map, *more.map) : *more.map;
  return true;
}

/// Findings, each name once, and the names of those that could not be made so.
struct OncePerName {
  std::vector<Finding> findings{};
  std::vector<std::string> left_out{};
};

OncePerName Merged(const std::vector<Finding>& findings) {
  OncePerName once;
  for (const Finding& finding : findings) {
    const auto earlier =
        std::ranges::find(once.findings, KeyOf(finding), [](const Finding& other) {
          return KeyOf(other);
        });
    if (earlier == once.findings.end()) {
      once.findings.push_back(finding);
    } else if (!AddTo(&*earlier, finding)) {
      once.left_out.push_back(KeyOf(finding));
    }
  }
  return once;
}

// What was fitted beside the findings and is the machine's, not a placement's:
// `predict` holds it as it was.
std::string BaselineText(const Diagnosis& diagnosis) {
  std::string text;
  for (const BaselineLine& line : diagnosis.baseline) {
    const bool is_placed = line.name.starts_with("placement.") ||
                           line.name.starts_with("bed_plane") ||
                           line.name.starts_with("tracker_frame");
    if (is_placed || !line.is_determined) continue;
    text += fmt::format("  {}: {:.9g}\n", line.name, line.value);
  }
  return text.empty()
             ? text
             : "# as fitted beside the findings, for caltwin predict\nbaseline:\n" +
                   text;
}

}  // namespace

std::string KeyOf(const Finding& finding) {
  if (finding.effect) return Name(finding.cause, finding.axis);
  return fmt::format("{}{{{}}}",
                     Name(finding.cause, finding.axis),
                     fmt::join(finding.covariates, ","));
}

std::string ExtensionText(const Diagnosis& diagnosis, const ExtensionBase& base) {
  std::string text =
      "# What `caltwin diagnose` found this machine to differ by from its drawing.\n";
  text += fmt::format("extends: {}\n", base.extends);
  text += fmt::format("extends_sha256: \"{}\"\n", base.extends_sha256);
  std::string effects, maps;
  const OncePerName once = Merged(diagnosis.findings);
  for (const std::string& name : once.left_out) {
    text += fmt::format(
        "# {} was found twice, and a machine has one: the second is left out\n", name);
  }
  for (const Finding& finding : once.findings) {
    if (finding.effect) {
      effects += EffectText(finding);
    } else if (HasTable(finding)) {
      maps += MapText(finding);
    } else {
      maps += fmt::format("  # {}: no table of it can be made\n", KeyOf(finding));
    }
  }
  if (!effects.empty()) text += "effects:\n" + effects;
  if (!maps.empty()) {
    text +=
        "# values and sd in um, by the first covariate slowest; linear between knots\n"
        "unknown:\n" +
        maps;
  }
  text += BaselineText(diagnosis);
  return text + EvidenceText(once.findings, diagnosis.gain, base);
}

}  // namespace caltwin
