#include "tools/commands/iso230_text.h"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/units.h"

namespace caltwin {
namespace {

using Iso230TextJson = nlohmann::ordered_json;

RowTable RowsOf(const RowTable& table, const Iso230Choice& choice) {
  RowTable chosen;
  for (const Row& row : table.rows) {
    if (row.campaign != choice.campaign || !MeasuresAlong(row, choice.axis)) continue;
    chosen.rows.push_back(row);
  }
  return chosen;
}

/// The campaign's instrument; where it is not named, the only one there is.
const Instrument* InstrumentOf(const DataHeader& header, const std::string& campaign) {
  const auto found = header.campaigns.find(campaign);
  const auto& instruments = header.instruments;
  if (found != header.campaigns.end() && !found->second.instrument.empty()) {
    const auto named = instruments.find(found->second.instrument);
    return named == instruments.end() ? nullptr : &named->second;
  }
  return instruments.size() == 1 ? &instruments.begin()->second : nullptr;
}

/// Root mean square of the rows' own sigmas; none where one is unknown.
std::optional<double> SigmaOf(const RowTable& table) {
  if (table.rows.empty()) return std::nullopt;
  double squares = 0;
  for (const Row& row : table.rows) squares += row.sigma_mm * row.sigma_mm;
  if (!Known(squares)) return std::nullopt;
  return std::sqrt(squares / static_cast<double>(table.rows.size()));
}

Iso230Budget BudgetOf(const RowTable& rows,
                      const Instrument* instrument,
                      Iso230Budget extra) {
  extra.is_known = extra.is_known || extra.alignment_u_um > 0 ||
                   extra.temperature_u_um > 0 || extra.environment_u_um > 0;
  if (const auto sigma_mm = SigmaOf(rows)) {
    extra.reading_u_um = UmFromMm(*sigma_mm);
    extra.is_known = true;
  }
  if (instrument == nullptr) return extra;
  extra.is_known = true;
  extra.device_u_um = instrument->u_um;
  // A reading rounded to the resolution errs by up to half of it either way.
  extra.reading_u_um =
      std::hypot(instrument->sigma_um, instrument->resolution_um / std::sqrt(12.0));
  return extra;
}

std::string UmIso230Text(const std::optional<double>& value_mm) {
  return value_mm ? fmt::format("{:10.2f}", UmFromMm(*value_mm))
                  : fmt::format("{:>10}", "-");
}

std::string SpanText(const char* what,
                     const std::optional<Span>& span,
                     const char* unit) {
  if (!span) return fmt::format("{} not recorded", what);
  if (span->min == span->max) return fmt::format("{} {:.4g} {}", what, span->min, unit);
  return fmt::format("{} {:.4g} to {:.4g} {}", what, span->min, span->max, unit);
}

std::string ConditionsText(const Iso230Report& report) {
  const Iso230Sheet& sheet = report.sheet;
  std::string text = SpanText("feed", sheet.feed_mm_s, "mm/s") + "; " +
                     SpanText("ambient", sheet.ambient_c, "C") + "; " +
                     SpanText("screw", sheet.screw_c, "C");
  if (sheet.time_s) {
    text += fmt::format("; took {:.0f} s", sheet.time_s->max - sheet.time_s->min);
  }
  for (const char* key : {"dwell_s", "warm_up"}) {
    const auto found = report.plan.find(key);
    text += found == report.plan.end() ? fmt::format("; {} not stated", key)
                                       : fmt::format("; {} {}", key, found->second);
  }
  return text + "\n";
}

std::string BudgetText(const Iso230Budget& budget) {
  if (!budget.is_known) {
    return "U is not stated: neither the rows nor the header tell the instrument's "
           "uncertainty (sigma_mm, or instruments: in DATA.yaml)\n";
  }
  const std::array contributions = {
      std::pair{"device", budget.device_u_um},
      std::pair{"alignment", budget.alignment_u_um},
      std::pair{"temperature", budget.temperature_u_um},
      std::pair{"environment", budget.environment_u_um},
      std::pair{"reading", budget.reading_u_um},
  };
  std::string counted, zero;
  for (const auto& [name, u_um] : contributions) {
    if (u_um > 0) {
      counted += fmt::format("{}{} {:.3g} um", counted.empty() ? "" : ", ", name, u_um);
    } else {
      zero += fmt::format("{}{}", zero.empty() ? "" : ", ", name);
    }
  }
  std::string text =
      "U (k = 2) from standard uncertainties: " + (counted.empty() ? "none" : counted);
  if (!zero.empty()) text += "; not stated and taken as 0: " + zero;
  return text + "\n";
}

std::string PositionsText(const Iso230Sheet& sheet) {
  std::string text = fmt::format("{:>12}{:>10}{:>10}{:>10}{:>10}{:>10}\n",
                                 "target mm",
                                 "mean fwd",
                                 "mean bwd",
                                 "s fwd",
                                 "s bwd",
                                 "B");
  for (const Iso230Position& position : sheet.positions) {
    text += fmt::format("{:12.4f}", position.target_mm) +
            UmIso230Text(position.mean_fwd_mm) + UmIso230Text(position.mean_bwd_mm) +
            UmIso230Text(position.s_fwd_mm) + UmIso230Text(position.s_bwd_mm) +
            UmIso230Text(position.b_mm) + "\n";
  }
  return text;
}

std::string BaselineText(const Iso230Report& report) {
  std::string text = fmt::format(
      "baseline: {:.1f} um rms with offset and scale, {:.1f} um with the reversal\n",
      UmFromMm(report.rms_without_reversal_mm),
      UmFromMm(report.baseline.rms_mm));
  for (const BaselineValue& value : report.baseline.values) {
    if (!value.identifiable) {
      text += fmt::format("  {:<32} these rows do not tell it\n", value.name);
    } else if (value.unit == "mm") {
      text += fmt::format("  {:<32}{:10.2f} +- {:.2f} um\n",
                          value.name,
                          UmFromMm(value.value),
                          UmFromMm(value.sd));
    } else {
      text += fmt::format("  {:<32}{:10.2f} +- {:.2f} {}\n",
                          value.name,
                          value.value,
                          value.sd,
                          value.unit);
    }
  }
  return text;
}

Iso230TextJson JsonOfIso230Text(const std::optional<double>& value) {
  return value ? Iso230TextJson(*value) : Iso230TextJson();
}

Iso230TextJson JsonOfIso230Text(const Iso230Symbols& symbols) {
  Iso230TextJson json = Iso230TextJson::object();
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    json[std::string(symbol.name)] = JsonOfIso230Text(symbols.*symbol.value);
  }
  return json;
}

Iso230TextJson JsonOfIso230Text(const std::optional<Span>& span) {
  return span ? Iso230TextJson{span->min, span->max} : Iso230TextJson();
}

}  // namespace

Iso230Report MakeIso230Report(const RowTable& table,
                              const DataHeader& header,
                              const Iso230Choice& choice,
                              Iso230Budget extra) {
  Iso230Report report;
  const RowTable rows = RowsOf(table, choice);
  report.budget = BudgetOf(rows, InstrumentOf(header, choice.campaign), extra);
  report.sheet = EvaluateIso230(table, choice, report.budget);
  report.baseline = FitBaseline(rows);
  report.rms_without_reversal_mm = FitBaseline(rows, {.reversal = false}).rms_mm;
  const auto campaign = header.campaigns.find(choice.campaign);
  if (campaign != header.campaigns.end()) report.plan = campaign->second.options;
  return report;
}

std::string Iso230Text(const Iso230Report& report) {
  const Iso230Sheet& sheet = report.sheet;
  std::string text = fmt::format(
      "ISO 230-2:2014, axis {}, campaign {}\n", Name(sheet.axis), sheet.campaign);
  if (!sheet.positions.empty()) {
    const std::string runs =
        sheet.runs_min == sheet.runs_max
            ? fmt::format("{}", sheet.runs_min)
            : fmt::format("{} to {}", sheet.runs_min, sheet.runs_max);
    text += fmt::format("{} positions from {:.6g} to {:.6g} mm, {} runs a direction\n",
                        sheet.positions.size(),
                        sheet.positions.front().target_mm,
                        sheet.positions.back().target_mm,
                        runs);
  }
  text += ConditionsText(report);
  text += fmt::format("\n{:<8}{:>10}{:>10}\n", "symbol", "um", "U (k=2)");
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    text += fmt::format("{:<8}", symbol.name) +
            UmIso230Text(sheet.symbols.*symbol.value) +
            UmIso230Text(sheet.expanded_u.*symbol.value) +
            fmt::format("  {}\n", symbol.words);
  }
  text += BudgetText(report.budget);
  text += "\n" + PositionsText(sheet) + "\n" + BaselineText(report);
  if (!sheet.remarks.empty()) text += "\n";
  for (const std::string& remark : sheet.remarks) text += "note: " + remark + "\n";
  return text;
}

Iso230TextJson Iso230Json(const Iso230Report& report) {
  const Iso230Sheet& sheet = report.sheet;
  Iso230TextJson positions = Iso230TextJson::array();
  for (const Iso230Position& position : sheet.positions) {
    positions.push_back({{"target_mm", position.target_mm},
                         {"mean_fwd_mm", JsonOfIso230Text(position.mean_fwd_mm)},
                         {"mean_bwd_mm", JsonOfIso230Text(position.mean_bwd_mm)},
                         {"s_fwd_mm", JsonOfIso230Text(position.s_fwd_mm)},
                         {"s_bwd_mm", JsonOfIso230Text(position.s_bwd_mm)},
                         {"B_mm", JsonOfIso230Text(position.b_mm)},
                         {"runs_fwd", position.runs_fwd},
                         {"runs_bwd", position.runs_bwd}});
  }
  Iso230TextJson baseline = Iso230TextJson::array();
  for (const BaselineValue& value : report.baseline.values) {
    baseline.push_back(
        {{"name", value.name},
         {"unit", value.unit},
         {"value", value.identifiable ? Iso230TextJson(value.value) : Iso230TextJson()},
         {"sd", value.identifiable ? Iso230TextJson(value.sd) : Iso230TextJson()}});
  }
  return {{"format", 1},
          {"axis", Name(sheet.axis)},
          {"campaign", sheet.campaign},
          {"sheet", JsonOfIso230Text(sheet.symbols)},
          {"U", JsonOfIso230Text(sheet.expanded_u)},
          {"positions", positions},
          {"baseline", baseline},
          {"baseline_rms_mm",
           {{"offset_scale", report.rms_without_reversal_mm},
            {"offset_scale_reversal", report.baseline.rms_mm}}},
          {"conditions",
           {{"runs", {sheet.runs_min, sheet.runs_max}},
            {"rows_without_direction", sheet.rows_without_direction},
            {"feed_mm_s", JsonOfIso230Text(sheet.feed_mm_s)},
            {"temp_ambient_c", JsonOfIso230Text(sheet.ambient_c)},
            {"temp_screw_c", JsonOfIso230Text(sheet.screw_c)},
            {"t_s", JsonOfIso230Text(sheet.time_s)}}},
          {"remarks", sheet.remarks}};
}

}  // namespace caltwin
