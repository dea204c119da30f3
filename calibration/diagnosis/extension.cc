#include "calibration/diagnosis/extension.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

std::string Name(const std::string& cause, const std::string& axis) {
  return axis.empty() ? cause : cause + "." + axis;
}

// Of a finding that is a table, the covariates tell one from another.
std::string NameOf(const Finding& finding) {
  if (finding.effect) return Name(finding.cause, finding.axis);
  return fmt::format(
      "{}.{}{{{}}}", finding.cause, finding.axis, fmt::join(finding.covariates, ","));
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

std::string EvidenceText(const Diagnosis& diagnosis, const ExtensionBase& base) {
  std::string text =
      fmt::format("evidence:\n  data_sha256: \"{}\"\n", base.data_sha256);
  text += "  log_odds:  # against none, natural logarithm\n";
  for (const Finding& finding : diagnosis.findings) {
    text += fmt::format("    \"{}\": {:.6g}\n", NameOf(finding), finding.log_odds);
  }
  const GainFigures& gain = diagnosis.gain;
  return text + fmt::format(
                    "  gain: {{rmse_before_um: {:.4g}, rmse_after_um: {:.4g}, "
                    "explained_fraction: {:.4g}}}\n",
                    UmFromMm(gain.blocks.before_mm),
                    UmFromMm(gain.blocks.after_mm),
                    gain.explained_fraction);
}

}  // namespace

std::string ExtensionText(const Diagnosis& diagnosis, const ExtensionBase& base) {
  std::string text =
      "# What `caltwin diagnose` found this machine to differ by from its drawing.\n";
  text += fmt::format("extends: {}\n", base.extends);
  text += fmt::format("extends_sha256: \"{}\"\n", base.extends_sha256);
  std::string effects, maps;
  for (const Finding& finding : diagnosis.findings) {
    if (finding.effect) {
      effects += EffectText(finding);
    } else if (finding.map && !finding.map->knots.empty()) {
      maps += MapText(finding);
    } else {
      maps += fmt::format("  # {}: no table of it can be made\n", NameOf(finding));
    }
  }
  if (!effects.empty()) text += "effects:\n" + effects;
  if (!maps.empty()) {
    text +=
        "# values and sd in um, by the first covariate slowest; linear between knots\n"
        "unknown:\n" +
        maps;
  }
  return text + EvidenceText(diagnosis, base);
}

}  // namespace caltwin
