#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace blind {

/// One finding of a diagnosis, judged.
struct JudgedFinding {
  std::string cause{}, axis{};
  double probability = 0;
  bool alone = false;  ///< No other candidate above 5 %, no structural one.
  bool right = false;  ///< It is a hidden cause.
  bool holds = false;  ///< A hidden cause is among its candidates.
  /// `unknown` or `pitch_map` in the right variable, or what else is no wrong
  /// mechanism.
  bool tolerable = false;
};

/// A case, judged: only here do truth and answer meet.
struct Judgement {
  std::string kind{}, name{};  ///< "single", "cyclic_lead x".
  unsigned long long seed = 0;
  bool physics = false;     ///< Performed by MuJoCo.
  double sigma = 0;         ///< Smallest of the hidden causes [sigma of one reading].
  double sum_squares = 0;   ///< Of the effect the plan can see; smallest.
  double separation = 1e9;  ///< From the nearest twin.
  bool ran = false;         ///< The diagnosis ended with 0 and a readable answer.
  std::string verdict{};
  std::vector<JudgedFinding> findings{};
  int hidden = 0, hidden_named = 0;  ///< Causes there are, and those named first.
  /// Those named, or, where a twin imitates them under this plan, in a reported set.
  int hidden_told = 0;
  bool first_right = false;        ///< The largest finding is a hidden cause.
  bool set_holds = false;          ///< Each hidden cause is in some set.
  double explained = -1;           ///< Share of the variance; below 0: not told.
  int intervals = 0, covered = 0;  ///< 95 % intervals of parameters.
  bool rediagnosed = false, idempotent = false;
  double seconds = 0;
};

/// `answer` and `again` (the diagnosis with the extended model; null if there is none)
/// as `caltwin diagnose --json` writes them.
Judgement Judge(const nlohmann::json& truth,
                const nlohmann::json& answer,
                const nlohmann::json& again);

/// One line for people.
std::string Line(const Judgement& judgement);

}  // namespace blind
