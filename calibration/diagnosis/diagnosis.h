#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/diagnosis/gain.h"
#include "calibration/diagnosis/observed.h"
#include "calibration/diagnosis/search.h"
#include "calibration/diagnosis/table_parts.h"
#include "calibration/facts/fact.h"
#include "sim/measure/data_header.h"
#include "sim/measure/import/import.h"
#include "sim/measure/row.h"

namespace caltwin {

enum class DiagnosisVerdict { kNone, kNamed, kAmbiguous, kUnknownStructure };
std::string ToString(DiagnosisVerdict verdict);

/// A cause that could stand for a finding; the first of a finding's is itself.
struct FindingCandidate {
  std::string cause{};
  std::string axis{};
  double probability = 0;
  bool structural = false;
};

struct FindingParameter {
  std::string name{};  ///< As the effect declares it: "amplitude_um".
  double value = 0;
  double sd = 0;
};

/// A smooth function over one or two covariates, as a table: what a finding without a
/// formula (pitch_map, unknown) is carried on as.
struct FreeMap {
  std::string channel{};  ///< x y z, probe or bed.
  std::vector<std::string> covariates{};
  std::vector<std::vector<double>> knots{};  ///< By covariate, ascending.
  std::vector<double> values_um{};           ///< First covariate slowest.
  std::vector<double> sds_um{};
  /// What it is made of: a line (order 1), a bow (2) and cosines of k half-waves over
  /// the range of each covariate (of angles: waves), order k held back to a prior
  /// variance of 1 / (1 + (k - 1)^2) of the first.
  int terms = 0;
  double prior_size_um = 0;  ///< Standard deviation of the whole, as the rows chose it.
  std::vector<TablePart> parts{};
};

/// One cause found.
struct Finding {
  std::string cause{};
  std::string axis{};
  double probability = 0;
  double log_odds = 0;  ///< Against none.
  std::vector<FindingCandidate> candidates{};
  std::vector<FindingParameter> parameters{};
  double share = 0;
  std::vector<std::string> covariates{};
  bool is_by_order = false;  ///< `t` is the order of the rows: their times are unknown.
  int rows = 0;
  double peak_um = 0;                ///< Near-peak of what it does in these rows.
  std::optional<Injected> effect{};  ///< What the extended machine gets.
  std::vector<double> sds{};         ///< Of its values.
  std::optional<FreeMap> map{};
  Eigen::VectorXd change_mm{};  ///< What it does to each row.
  /// It follows from the numbers by themselves (Fact::cause); no model was fitted to
  /// it.
  bool is_of_facts = false;
};

/// One line of the evidence table: how likely a cause is before any was accepted.
struct EvidenceLine {
  std::string cause{};
  std::string axis{};
  std::vector<std::string> covariates{};
  double log_odds = 0;    ///< Against none, prior included.
  std::string channel{};  ///< x y z (motion), probe or bed: where it shows.
};

/// What would best settle what is open.
struct NextCampaign {
  std::string kind{};
  std::map<std::string, std::string> options{};  ///< That differ from the usual.
  std::vector<std::string> separates{};
  double minutes = 0;
  double separation_sigma = 0;
};

struct Absorbed {
  std::string what{};
  std::string into{};
};

struct BaselineLine {
  std::string name{};
  std::string unit{};
  double value = 0;
  double sd = 0;
  bool is_determined = true;  ///< By these rows, beside the other lines.
};

/// The answer to the four questions: show, name, extend, gain.
struct Diagnosis {
  DiagnosisVerdict verdict = DiagnosisVerdict::kNone;
  std::vector<Finding> findings{};  ///< Largest share first.
  /// Smaller effects were not asked for [um]; 0: all.
  double min_effect_um = 0;
  GainFigures gain{};
  std::vector<Absorbed> absorbed{};
  std::optional<NextCampaign> next_campaign{};
  std::vector<std::int64_t> outlier_rows{};
  std::vector<BaselineLine> baseline{};
  std::vector<std::string> remarks{};  ///< What a person should know.
  Facts facts{};                       ///< What the rows say without a model.
  /// The model at hand already holds effects: what the rows say by themselves may be
  /// theirs, and leads no answer.
  bool is_extended = false;
  bool has_model = true;  ///< False: too few rows, or too far from any, to fit one.
  double wander_um_per_sqrt_h = 0;

  /// @name For pictures
  Eigen::VectorXd residual_before_mm{};  ///< Baseline fitted.
  Eigen::VectorXd residual_after_mm{};   ///< Findings fitted too.
  std::vector<EvidenceLine> evidence{};  ///< The likeliest first.
  std::vector<EvidenceLine> weighed{};   ///< Every candidate, the likeliest first.
  Eigen::VectorXd sigma_mm{};            ///< Of each row, as judged.
};

struct DiagnoseOptions {
  SearchOptions search{};
  /// Findings with a smaller peak are not reported; 0: all of them. They are found all
  /// the same, or something larger would stand in for them.
  double min_effect_um = 0;
  /// Told of progress in words; may be empty.
  std::function<void(const std::string&)> progress{};
  LevellingLog levelling{};  ///< Of a console, where the rows are from one.
  /// False: positions are indices of a grid; only what rows say by themselves is told.
  bool has_places = true;
  /// False: what is assumed of the machine does not hold of it; the same.
  bool has_machine = true;
};

/// Diagnoses rows against a machine. Throws InputError where rows lack what they must
/// have (a direction).
Diagnosis Diagnose(const Observed& observed, const DiagnoseOptions& options);

}  // namespace caltwin
