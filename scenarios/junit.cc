#include "scenarios/junit.h"

#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "scenarios/result_text.h"

namespace caltwin {
namespace {

struct Case {
  std::string name{};
  std::string failure{};  ///< Empty: passed.
};

std::vector<Case> CasesOf(const RunResult& result) {
  std::vector<Case> cases;
  for (const ParameterResult& row : result.parameters) {
    if (!row.passed) continue;
    Case parameter{.name = row.name};
    if (!*row.passed) {
      const auto text = [&](const std::optional<double>& value) {
        return value ? Sensible(*value, row.tolerance) : std::string("nothing");
      };
      parameter.failure = fmt::format("injected {} {}, recovered {}, tolerance {}",
                                      text(row.injected),
                                      row.unit,
                                      text(row.recovered),
                                      text(row.tolerance));
    }
    cases.push_back(parameter);
  }
  for (const CheckResult& check : result.checks) {
    cases.push_back({.name = check.name,
                     .failure = check.passed ? ""
                                             : fmt::format("expected {}, found {}",
                                                           check.expected,
                                                           check.found)});
  }
  return cases;
}

std::string SuiteText(const RunResult& result) {
  const std::vector<Case> cases = CasesOf(result);
  std::size_t failures = 0;
  const std::string class_name =
      XmlEscaped(std::filesystem::path(result.scenario).stem().string());
  std::string body;
  for (const Case& c : cases) {
    body += fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"0\"",
                        class_name,
                        XmlEscaped(c.name));
    if (c.failure.empty()) {
      body += "/>\n";
      continue;
    }
    ++failures;
    body += fmt::format(">\n      <failure message=\"{}\"/>\n    </testcase>\n",
                        XmlEscaped(c.failure));
  }
  const bool broken = result.lost || result.interrupted;
  if (broken) {
    body += fmt::format(
        "    <testcase classname=\"{}\" name=\"run\" time=\"0\">\n      <error "
        "message=\"{}\"/>\n    </testcase>\n",
        class_name,
        result.lost ? "a process or link was lost" : "interrupted");
  }
  return fmt::format(
      "  <testsuite name=\"{} seed {}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n{}  </testsuite>\n",
      XmlEscaped(result.scenario),
      result.seed,
      cases.size() + (broken ? 1 : 0),
      failures,
      broken ? 1 : 0,
      result.cpu_s,
      body);
}

}  // namespace

std::string XmlEscaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (c == '\'') {
      escaped += "&apos;";
    } else if (c == '\n') {
      escaped += "&#10;";
    } else if (c == '\t') {
      escaped += "&#9;";
    } else {
      escaped += code < 0x20 || code == 0x7f ? '?' : c;
    }
  }
  return escaped;
}

std::string JUnitText(std::span<const RunResult> results) {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (const RunResult& result : results) text += SuiteText(result);
  return text + "</testsuites>\n";
}

}  // namespace caltwin
