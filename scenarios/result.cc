#include "scenarios/result.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/shared_inputs.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json FiniteOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// Share of the variance that an input has.
double ShareOf(const Contribution& input, const Expanded& of) {
  return input.u * input.u / (of.u * of.u);
}

Json BudgetJson(const ParameterResult& p, const Expanded& expanded) {
  Json lines = Json::array();
  for (const Contribution& input : ByInput(p.budget)) {
    lines.push_back({{"input", input.input},
                     {"u", input.u},
                     {"dof", FiniteOrNull(input.dof)},
                     {"distribution", input.is_rectangular ? "rectangular" : "normal"},
                     {"share", expanded.u > 0 ? ShareOf(input, expanded) : 0}});
  }
  return lines;
}

// u, k, U and degrees of freedom (null: infinite) behind a stated sd.
Json UncertaintyJson(const ParameterResult& p) {
  const auto expanded = ExpandedOf(p);
  if (!expanded) return nullptr;
  return {{"u", expanded->u},
          {"k", expanded->k},
          {"U", expanded->U},
          {"dof", FiniteOrNull(expanded->dof)},
          {"budget", BudgetJson(p, *expanded)}};
}

Json ParameterJson(const ParameterResult& p) {
  return {{"name", p.name},
          {"unit", p.unit},
          {"injected", p.injected},
          {"recovered", OrNull(p.recovered)},
          {"sd", OrNull(p.sd)},
          {"uncertainty", UncertaintyJson(p)},
          {"error", OrNull(p.error)},
          {"tolerance", OrNull(p.tolerance)},
          {"passed", OrNull(p.passed)},
          {"identifiable", p.identifiable},
          {"source", p.is_setting ? "setting" : "estimate"}};
}

Json CheckJson(const CheckResult& check) {
  return {{"name", check.name},
          {"expected", check.expected},
          {"found", check.found},
          {"passed", check.passed}};
}

Json StepJson(const Step& step) {
  return {{"procedure", step.procedure},
          {"variant", step.variant},
          {"iteration", step.iteration},
          {"name", step.name},
          {"unit", step.unit},
          {"before", step.has_before ? Json(step.before) : Json(nullptr)},
          {"after", step.after},
          {"verdict", ToString(step.verdict)},
          {"message", step.message}};
}

template <typename List, typename Convert>
Json ListJson(const List& list, Convert convert) {
  Json json = Json::array();
  for (const auto& item : list) json.push_back(convert(item));
  return json;
}

}  // namespace

void SetUncertainty(const Estimate& estimate, ParameterResult* row) {
  row->budget = estimate.budget;
  row->sd.reset();
  if (estimate.sd > 0) row->sd = estimate.sd;
}

std::optional<Contribution> CombinedOf(const ParameterResult& row) {
  if (!row.sd || !(*row.sd > 0)) return std::nullopt;
  if (row.budget.empty()) return Contribution{.input = "as stated", .u = *row.sd};
  return Contribution{.input = "all inputs",
                      .u = CombinedU(row.budget),
                      .dof = EffectiveDof(row.budget)};
}

std::optional<Expanded> ExpandedOf(const ParameterResult& row) {
  if (!row.sd) return std::nullopt;
  if (!row.budget.empty()) return Expand(row.budget);
  return Expand(std::vector<Contribution>{{.input = "as stated", .u = *row.sd}});
}

void AddDone(const ProcedureResult& part, RunResult* result) {
  const auto append = [](const auto& from, auto* to) {
    to->insert(to->end(), from.begin(), from.end());
  };
  append(part.steps, &result->steps);
  append(part.correlations, &result->correlations);
  for (const Observability& o : part.observability) {
    const auto same = [&](const Observability& known) {
      return known.statement == o.statement;
    };
    if (std::ranges::none_of(result->observability, same)) {
      result->observability.push_back(o);
    }
  }
}

std::vector<Correlations> AllCorrelations(const RunResult& result) {
  std::vector<Budgeted> told;
  for (const ParameterResult& row : result.parameters) {
    if (row.sd) told.push_back({.name = row.name, .budget = row.budget});
  }
  return AllCorrelations(told, result.correlations);
}

nlohmann::ordered_json ToJson(const Correlations& of) {
  constexpr std::size_t kShown = 10;
  Json rows = Json::array(), largest = Json::array();
  for (Eigen::Index i = 0; i < of.matrix.rows(); ++i) {
    const Eigen::VectorXd row = of.matrix.row(i);
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  for (const CorrelatedPair& pair : LargestPairs(of, kShown, 0)) {
    largest.push_back({{"between", {pair.first, pair.second}}, {"r", pair.r}});
  }
  return {{"procedure", of.procedure},
          {"names", of.names},
          {"matrix", rows},
          {"largest", largest}};
}

nlohmann::ordered_json ToJson(const RunResult& result) {
  return {{"format", 1},
          {"scenario", result.scenario},
          {"about", result.about},
          {"machine", result.machine},
          {"passed", result.passed},
          {"outcome", result.outcome},
          {"fidelity", result.fidelity},
          {"seed", result.seed},
          {"parameters", ListJson(result.parameters, ParameterJson)},
          {"checks", ListJson(result.checks, CheckJson)},
          {"steps", ListJson(result.steps, StepJson)},
          {"correlations",
           ListJson(AllCorrelations(result),
                    [](const Correlations& of) { return ToJson(of); })},
          {"observability",
           ListJson(result.observability,
                    [](const Observability& o) {
                      return Json{{"statement", o.statement},
                                  {"blind_direction", o.blind_direction}};
                    })},
          {"messages", result.messages},
          {"causes", result.Causes()},
          {"position_error_mm",
           {{"p95_before", result.position_error_before_p95_mm},
            {"p95_after", result.position_error_after_p95_mm}}},
          {"machine_time_s", result.machine_time_s},
          {"version", CALTWIN_VERSION},
          {"cpu_s", result.cpu_s},
          {"touches", result.touches}};
}

std::vector<std::string> RunResult::Causes() const {
  for (const auto kind : {Message::Kind::kCause, Message::Kind::kMachine}) {
    std::vector<std::string> causes;
    for (const Message& message : messages) {
      const bool is_new = std::ranges::find(causes, message.text) == causes.end();
      if (message.kind == kind && is_new) causes.push_back(message.text);
    }
    if (!causes.empty()) return causes;
  }
  return {};
}

std::optional<double> Coverage95(std::span<const RunResult> results) {
  constexpr double kSigmasOf95Percent = 1.96;
  int stated = 0;
  int held = 0;
  for (const RunResult& result : results) {
    for (const ParameterResult& p : result.parameters) {
      if (!p.identifiable || !p.error || !p.sd) continue;
      ++stated;
      if (std::abs(*p.error) <= kSigmasOf95Percent * *p.sd) ++held;
    }
  }
  if (stated == 0) return std::nullopt;
  return static_cast<double>(held) / stated;
}

}  // namespace caltwin
