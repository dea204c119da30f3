#include "scenarios/result_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/verdict_text.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr const char* kGreen = "\033[32m";
constexpr const char* kRed = "\033[31m";
constexpr const char* kPlain = "\033[0m";
constexpr const char* kNormalDof = "inf";

std::string Painted(const std::string& text, bool good, bool colour) {
  return colour ? fmt::format("{}{}{}", good ? kGreen : kRed, text, kPlain) : text;
}

std::optional<double> ResolutionOf(const ParameterResult& row) {
  std::optional<double> resolution;
  for (const auto& candidate : {row.sd, row.tolerance}) {
    if (!candidate || !(*candidate > 0)) continue;
    if (!resolution || *candidate < *resolution) resolution = candidate;
  }
  return resolution;
}

std::string VerdictOf(const ParameterResult& row) {
  if (!row.identifiable) {
    return row.passed == true    ? "cannot be told, as expected"
           : row.passed == false ? "NOT RECOVERED"
                                 : "not told";
  }
  if (row.passed == true) return "recovered";
  return row.passed == false ? "MISSED" : "measured";
}

using Cells = std::array<std::string, 8>;

Cells CellsOf(const ParameterResult& row) {
  const auto resolution = ResolutionOf(row);
  const auto cell = [&](const std::optional<double>& value) {
    return value ? Sensible(*value, resolution) : std::string("-");
  };
  std::string error = cell(row.error);
  if (row.error && *row.error >= 0) error = "+" + error;
  return {row.name,
          row.unit,
          Sensible(row.injected, resolution),
          cell(row.recovered),
          error,
          cell(row.sd),
          cell(row.tolerance),
          VerdictOf(row)};
}

std::string TableText(const RunResult& result, bool colour) {
  std::vector<Cells> lines = {{"quantity",
                               "unit",
                               "injected",
                               "recovered",
                               "error",
                               "uncertainty",
                               "tolerance",
                               "verdict"}};
  for (const ParameterResult& row : result.parameters) lines.push_back(CellsOf(row));
  std::array<std::size_t, 8> widths{};
  for (const Cells& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      widths[i] = std::max(widths[i], line[i].size());
    }
  }
  std::string text;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const Cells& line = lines[n];
    text += fmt::format("  {:<{}}  {:<{}}", line[0], widths[0], line[1], widths[1]);
    for (std::size_t i = 2; i + 1 < line.size(); ++i) {
      text += fmt::format("  {:>{}}", line[i], widths[i]);
    }
    const bool judged = n > 0 && result.parameters[n - 1].passed.has_value();
    text +=
        "  " + (judged ? Painted(line.back(), *result.parameters[n - 1].passed, colour)
                       : line.back());
    text += "\n";
  }
  return text;
}

std::string StepText(const Step& step) {
  std::string text = step.procedure;
  if (!step.variant.empty()) text += fmt::format(" ({})", step.variant);
  if (step.iteration > 1) text += fmt::format(", pass {}", step.iteration);
  text +=
      step.before == step.after || !step.has_before
          ? fmt::format(": {} {:.7g}", step.name, step.after)
          : fmt::format(": {} {:.7g} -> {:.7g}", step.name, step.before, step.after);
  if (!step.unit.empty()) text += " " + step.unit;
  text += ", " + ToString(step.verdict);
  if (!step.message.empty()) text += ". " + step.message;
  return text;
}

std::string ListText(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string text = fmt::format("\n{}\n", title);
  for (const std::string& line : lines) text += fmt::format("  {}\n", line);
  return text;
}

// What U = k u each result has, and what it is made of.
std::string BudgetsText(const RunResult& result) {
  std::vector<std::string> lines;
  for (const ParameterResult& row : result.parameters) {
    const std::string line = UncertaintyText(row);
    if (!line.empty()) lines.push_back(line);
  }
  for (const Correlations& of : AllCorrelations(result)) {
    const std::string line = CorrelationText(of);
    if (!line.empty()) lines.push_back(line);
  }
  return ListText("How sure: 95 % intervals, and what makes them", lines);
}

std::string ChecksText(const RunResult& result, bool colour, bool only_failed = false) {
  std::vector<std::string> lines;
  for (const CheckResult& check : result.checks) {
    if (only_failed && check.passed) continue;
    lines.push_back(fmt::format(
        "{}: {}",
        check.name,
        check.passed
            ? Painted(check.found, true, colour) + ", as expected"
            : Painted(check.found, false, colour) + ", expected " + check.expected));
  }
  const double before_mm = result.position_error_before_p95_mm;
  const double after_mm = result.position_error_after_p95_mm;
  if (before_mm != 0 || after_mm != 0) {  // Motors and offsets have none.
    lines.push_back(fmt::format("{}: {:.4f} mm before, {:.4f} mm after",
                                result.is_error_of_nozzle
                                    ? "height of the nozzle at 0, off by"
                                    : "position error (p95)",
                                before_mm,
                                after_mm));
  }
  return ListText("Checks", lines);
}

}  // namespace

std::string UncertaintyText(const ParameterResult& row) {
  const auto expanded = ExpandedOf(row);
  if (!expanded || !row.recovered || !(expanded->u > 0)) return "";
  const auto resolution = ResolutionOf(row);
  const std::string dof = DofText(expanded->dof);
  std::string text =
      fmt::format("{}: {} +- {} {}, k = {:.2f}{}",
                  row.name,
                  Sensible(*row.recovered, resolution),
                  Sensible(expanded->U, resolution),
                  row.unit,
                  expanded->k,
                  dof == kNormalDof ? "" : fmt::format(" ({} dof)", dof));
  const std::string shares = SharesText(row);
  return shares.empty() ? text : text + ": " + shares;
}

std::string CorrelationText(const Correlations& of) {
  const std::string pairs = MostCorrelatedText(of);
  return pairs.empty() ? ""
                       : fmt::format("{}, most correlated: {}", of.procedure, pairs);
}

std::string SharesText(const ParameterResult& row) {
  constexpr double kShown = 0.005;  // Less is 0 %.
  const double u = CombinedU(row.budget);
  std::vector<Contribution> budget = ByInput(row.budget);
  std::ranges::stable_sort(budget, std::greater{}, &Contribution::u);
  std::vector<std::string> shares;
  for (const Contribution& input : budget) {
    const double share = std::pow(input.u / u, 2);
    if (share < kShown) continue;
    shares.push_back(
        fmt::format("{} {:.0f} %", input.input, PercentFromFraction(share)));
  }
  return fmt::format("{}", fmt::join(shares, ", "));
}

std::string DofText(double dof) {
  constexpr double kAsGoodAsNormal = 1e3;  // As CoverageFactor has it.
  return dof < kAsGoodAsNormal ? fmt::format("{:.0f}", std::floor(dof)) : kNormalDof;
}

std::string Sensible(double value, std::optional<double> resolution) {
  if (!resolution || !(*resolution > 0)) return fmt::format("{:.6g}", value);
  const int decimals =
      std::clamp(1 - static_cast<int>(std::floor(std::log10(*resolution))), 0, 6);
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero && text.starts_with('-') ? text.substr(1) : text;
}

std::string ResultText(const RunResult& result, bool colour) {
  std::string text = result.scenario;
  if (!result.about.empty()) text += ": " + result.about;
  text += fmt::format(
      "\nmachine {}, {}, seed {}\n\n", result.machine, result.fidelity, result.seed);
  if (!result.parameters.empty()) text += TableText(result, colour);
  text += BudgetsText(result);
  std::vector<std::string> steps;
  for (const Step& step : result.steps) {
    steps.push_back(fmt::format("{:>2}  {}", steps.size() + 1, StepText(step)));
  }
  text += ListText("What was done", steps);
  std::vector<std::string> blind;
  for (const Observability& o : result.observability) blind.push_back(o.statement);
  text += ListText("What the measurements tell, and what not", blind);
  std::vector<std::string> messages;
  for (const Message& message : result.messages) messages.push_back(message.text);
  text += ListText("Messages", messages);
  text += ChecksText(result, colour);
  const auto [passed, all] = Score(result);
  text += fmt::format(
      "\n{}: {} of {} expectations met; {} touches, {:.0f} s on the "
      "machine, {:.2f} s here\n",
      Painted(result.passed ? "PASSED" : "FAILED", result.passed, colour),
      passed,
      all,
      result.touches,
      result.machine_time_s,
      result.cpu_s);
  if (result.lost) text += "A process or link was lost on the way.\n";
  if (result.interrupted) text += "Interrupted; what was done until then is above.\n";
  return text;
}

std::string ResultBrief(const RunResult& result, bool colour) {
  const RunVerdict verdict = VerdictOf(result);
  std::string text =
      fmt::format("{}: {}\n",
                  Painted(result.passed ? "PASSED" : "FAILED", result.passed, colour),
                  verdict.sentence);
  for (const std::string& remark : verdict.remarks) text += remark + "\n";
  text += fmt::format(
      "\n{}\nmachine {}, {}, seed {}; {} touches, {:.0f} s on the machine\n\n",
      result.about.empty() ? result.scenario : result.about,
      result.machine,
      result.fidelity,
      result.seed,
      result.touches,
      result.machine_time_s);
  if (!result.parameters.empty()) text += TableText(result, colour);
  text += ChecksText(result, colour, /*only_failed=*/true);
  return text + fmt::format(
                    "\n--verbose shows how sure each is and why, {} steps and {} "
                    "messages.\n",
                    result.steps.size(),
                    result.messages.size());
}

std::string ResultLine(const RunResult& result, bool colour) {
  const auto [passed, all] = Score(result);
  return fmt::format(
      "{}  {}  seed {}  {}  {} of {} expectations  {:.2f} s",
      Painted(result.passed ? "passed" : "FAILED", result.passed, colour),
      result.scenario,
      result.seed,
      result.outcome,
      passed,
      all,
      result.cpu_s);
}

std::string SummaryText(std::span<const RunResult> results) {
  const auto passed = std::ranges::count_if(results, &RunResult::passed);
  const double rate = results.empty() ? 0
                                      : static_cast<double>(passed) /
                                            static_cast<double>(results.size());
  std::string text = fmt::format("{} runs, {} passed ({:.1f} %)",
                                 results.size(),
                                 passed,
                                 PercentFromFraction(rate));
  if (const auto coverage = Coverage95(results)) {
    text += fmt::format("; the stated 95 % intervals held the truth in {:.1f} %",
                        PercentFromFraction(*coverage));
  }
  return text + "\n";
}

}  // namespace caltwin
