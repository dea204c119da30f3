#include "tests/blind/judge.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/blind/causes.h"

namespace blind {
namespace {

using nlohmann::json;

constexpr double kTwo_sided95 = 1.96;

bool SameCause(const json& hidden, const json& named) {
  const std::string cause = hidden.at("cause");
  if (named.value("cause", "") != cause) return false;
  const Cause* known = FindCause(cause);
  const bool has_one_axis = known != nullptr && known->axes.size() == 1;
  return has_one_axis || hidden.at("axis") == named.value("axis", "");
}

/// Is the answer "something varies with this" true of a hidden cause?
bool RightVariable(const json& hidden, const json& finding) {
  const std::string axis = hidden.at("axis");
  const std::string channel = finding.value("axis", "");
  const json& covariates = hidden.at("covariates");
  const bool by_axis = axis.size() == 1 && channel == axis;
  if (by_axis) return true;
  for (const json& found : finding.value("covariates", json::array())) {
    const std::string word = found;
    for (const json& truth : covariates) {
      const std::string wanted =
          truth.get<std::string>() == "q" ? axis : truth.get<std::string>();
      if (word == wanted || word.rfind(wanted + "_", 0) == 0) return true;
    }
  }
  return false;
}

bool Tolerable(const json& hidden, const json& finding) {
  const std::string cause = finding.value("cause", "");
  const json& acceptable = hidden.at("acceptable");
  if (std::ranges::find(acceptable, json(cause)) != acceptable.end()) return true;
  if (cause != "unknown" && cause != "pitch_map") return false;
  // Of a cause of the catalogue, no list says what it varies with: "unknown" is honest.
  return hidden.at("covariates").empty()
             ? cause == "unknown" || RightVariable(hidden, finding)
             : RightVariable(hidden, finding);
}

JudgedFinding JudgeFinding(const json& truth, const json& finding) {
  JudgedFinding judged;
  judged.cause = finding.value("cause", "");
  judged.axis = finding.value("axis", "");
  judged.probability = finding.value("probability", 0.0);
  judged.alone = true;
  const json candidates = finding.value("candidates", json::array());
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    if (candidates[i].value("structural", false) ||
        candidates[i].value("probability", 0.0) > 0.05) {
      judged.alone = false;
    }
  }
  for (const json& hidden : truth.at("causes")) {
    judged.right |= SameCause(hidden, finding);
    judged.tolerable |= Tolerable(hidden, finding);
    judged.holds |= judged.right;
    for (const json& candidate : candidates) {
      judged.holds |= SameCause(hidden, candidate);
    }
  }
  return judged;
}

/// Counts the stated intervals that hold the truth, of the parameters both sides name.
void CountIntervals(const json& truth, const json& finding, Judgement* judgement) {
  for (const json& hidden : truth.at("causes")) {
    if (!SameCause(hidden, finding)) continue;
    for (const json& told : finding.value("parameters", json::array())) {
      for (const json& real : hidden.at("parameters")) {
        const double sd = told.contains("sd") && told["sd"].is_number()
                              ? told["sd"].get<double>()
                              : 0.0;
        if (told.value("name", "") != real.at("name").get<std::string>() || sd <= 0)
          continue;
        double error = told.value("value", 0.0) - real.at("value").get<double>();
        if (real.at("name").get<std::string>() == "phase_deg")
          error = std::remainder(error, 360.0);
        ++judgement->intervals;
        if (std::abs(error) <= kTwo_sided95 * sd) ++judgement->covered;
      }
    }
  }
}

/// Does another cause imitate it under this plan?
bool HasTwin(const json& hidden) {
  constexpr double kSeparated = 9;
  const json& left = hidden.at("separation");
  return std::any_of(left.begin(), left.end(), [](const json& squares) {
    return squares.get<double>() < kSeparated;
  });
}

void ReadTruth(const json& truth, Judgement* judgement) {
  judgement->kind = truth.at("kind");
  judgement->seed = truth.at("seed");
  judgement->physics = truth.value("physics", false);
  std::vector<std::string> names;
  judgement->sigma = judgement->sum_squares = 1e9;
  for (const json& hidden : truth.at("causes")) {
    const std::string axis = hidden.at("axis");
    names.push_back(hidden.at("cause").get<std::string>() +
                    (axis.empty() ? "" : " " + axis));
    const bool by_size = FindCause(hidden.at("cause")) != nullptr &&
                         FindCause(hidden.at("cause"))->fixed_size > 0;
    if (!by_size) {
      judgement->sigma =
          std::min(judgement->sigma, hidden.at("peak_sigma").get<double>());
      judgement->sum_squares =
          std::min(judgement->sum_squares, hidden.at("sum_squares").get<double>());
    }
    for (const auto& [rival, left] : hidden.at("separation").items()) {
      judgement->separation = std::min(judgement->separation, left.get<double>());
    }
  }
  judgement->hidden = static_cast<int>(names.size());
  judgement->name = names.empty() ? "-" : fmt::format("{}", fmt::join(names, " + "));
}

}  // namespace

Judgement Judge(const json& truth, const json& answer, const json& again) {
  Judgement judgement;
  ReadTruth(truth, &judgement);
  judgement.ran = answer.is_object() && answer.contains("verdict");
  if (!judgement.ran) return judgement;
  judgement.verdict = answer.at("verdict");
  const json findings = answer.value("findings", json::array());
  for (const json& finding : findings) {
    judgement.findings.push_back(JudgeFinding(truth, finding));
    CountIntervals(truth, finding, &judgement);
  }
  judgement.first_right = !judgement.findings.empty() && judgement.findings[0].right;
  judgement.set_holds = judgement.hidden > 0;
  for (const json& hidden : truth.at("causes")) {
    bool named = false;
    bool held = false;
    for (const json& finding : findings) {
      named |= SameCause(hidden, finding);
      for (const json& candidate : finding.value("candidates", json::array())) {
        held |= SameCause(hidden, candidate);
      }
    }
    judgement.hidden_named += named ? 1 : 0;
    judgement.hidden_told += named || (held && HasTwin(hidden)) ? 1 : 0;
    judgement.set_holds &= held || named;
  }
  const json gain = answer.value("gain", json::object());
  if (gain.contains("explained_fraction") && gain["explained_fraction"].is_number()) {
    judgement.explained = gain["explained_fraction"];
  }
  judgement.rediagnosed = again.is_object() && again.contains("verdict");
  judgement.idempotent = judgement.rediagnosed && again["verdict"] == "none";
  return judgement;
}

std::string Line(const Judgement& judgement) {
  std::vector<std::string> found;
  for (const JudgedFinding& finding : judgement.findings) {
    found.push_back(fmt::format("{}{}{} {:.3f}{}{}",
                                finding.cause,
                                finding.axis.empty() ? "" : " ",
                                finding.axis,
                                finding.probability,
                                finding.alone ? "" : " (not alone)",
                                finding.right       ? " right"
                                : finding.holds     ? " holds"
                                : finding.tolerable ? " tolerable"
                                                    : " WRONG"));
  }
  const std::string size =
      judgement.sigma > 1e8
          ? "-"
          : fmt::format("{:.1f} sigma, {:.0f}", judgement.sigma, judgement.sum_squares);
  return fmt::format(
      "{:7} {} {:34} {:18} seed {:<10} {:9} {:5.1f} s  {}{}",
      judgement.kind,
      judgement.physics ? "M" : " ",
      judgement.name,
      size,
      judgement.seed,
      judgement.ran ? judgement.verdict : "FAILED",
      judgement.seconds,
      fmt::join(found, "; "),
      judgement.rediagnosed && !judgement.idempotent ? "; again: not none" : "");
}

}  // namespace blind
