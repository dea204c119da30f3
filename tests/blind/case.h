#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/blind/causes.h"
#include "tests/blind/machine.h"
#include "tests/blind/visible.h"

namespace blind {

/// A cause to hide, where, and how large it shall show [sigma of one reading].
struct Hidden {
  std::string cause{}, axis{};
  double sigma = 5;
};

/// What a case shall be. Kind: null, single, pair, outside or loop (the rows of one
/// campaign, to be continued on the machine itself). Causes not given are drawn.
struct CaseRequest {
  std::string kind = "null";
  std::vector<Hidden> hidden{};
  double sigma = 5;
  std::uint64_t seed = 1;
  /// Without outliers, wrong stated sigma, missing columns, wander and clutter.
  bool clean = false;
  int max_rows = 400;
  /// MuJoCo performs the plan with a model edited as text (physics_case.h).
  bool physics = false;
};

/// How the data differ from what a careful person would have written.
struct Blemishes {
  double sigma_factor = 1;  ///< Stated / true.
  bool states_sigma = true;
  double outlier_share = 0;
  double wander_um_per_sqrt_h = 0;
  double clutter_sigma = 0;
  /// Whether the travel since a reversal is the commanded one, to the nominal point; or
  /// the true one, to the trigger.
  bool logs_commanded_travel = false;
  std::set<std::string> missing{};  ///< Columns, or groups of them.
};

/// How large a hidden effect came out, and what it may be taken for.
struct HiddenTruth {
  Defect defect{};
  double peak_sigma = 0;
  double sum_squares = 0;
  /// (effect / sigma)^2 left when another cause imitates it as well as it can.
  std::map<std::string, double> separation{};
};

/// A finished case: the data, and what is true.
struct Case {
  CaseRequest request{};
  Drawing drawing{};
  Plan plan{};
  std::vector<double> times_s{};
  Truth truth{};
  std::vector<HiddenTruth> hidden{};
  Blemishes blemishes{};
  std::map<std::string, Noise> instruments{};
  std::vector<Reading> readings{};  ///< Point into `plan`: never copy a case.
  std::vector<std::array<double, kThermometers>> temps_c{};

  Case() = default;
  Case(const Case&) = delete;
  Case& operator=(const Case&) = delete;
};

/// Makes `made` from its request, by the truth code's own closed forms.
void MakeCase(const CaseRequest& request, Case* made);

/// The request with everything drawn that it leaves open.
CaseRequest Filled(CaseRequest request);
/// Campaigns that show what is hidden, and some others.
std::vector<CampaignRequest> ChooseCampaigns(const CaseRequest& request,
                                             const Drawing& drawing,
                                             Random* random);
/// All that is wander and clutter, added to the truth's defects.
void AddDistractions(const Weather& weather, Case* made);
/// What every diagnosis fits away, in sigma.
Projector BaselineOf(const Case& made, const std::vector<Reading>& readings);
/// A form is hidden by its plan when the baseline leaves less than this of its peak.
inline constexpr double kLeastVisible = 1e-3;

/// Parts of it: the machine as drawn, the plan, the faults every machine has.
Drawing DrawMachine(const CaseRequest& request);
/// @param attempt  other plans for the same request
Plan MakePlan(const CaseRequest& request, const Drawing& drawing, int attempt = 0);
Truth DrawTruth(const CaseRequest& request, const Drawing& drawing, const Plan& plan);
Blemishes DrawBlemishes(const CaseRequest& request);
std::map<std::string, Noise> DrawInstruments(const CaseRequest& request,
                                             const Drawing& drawing);

/// Slow wander of the machine, and clutter too small to be found, as defects.
Defect Wander(const Circumstances& at, double um_per_sqrt_h);
Defect Clutter(const Circumstances& at, double amplitude_mm);

/// Noise, quantisation to motor steps and outliers, put on noise-free readings.
void AddNoise(Case* made);

/// Noise of one reading, quantisation included.
double Sigma_mm(const Case& made, const Reading& reading);

/// What a machine file says beside the drawing's axes.
struct MachineWords {
  std::string model{};  ///< Empty: none is named.
  double pretravel_mm = 0.02;
  double tip_growth_mm = 0;  ///< Against what the firmware believes.
  double microsteps = 0;     ///< Of every axis; 0: the drawing's.
};
std::string MachineYaml(const Drawing& drawing, const MachineWords& words);

/// Writes DATA.csv, DATA.yaml and machine.yaml into `folder`: all that a diagnosis
/// gets.
void WriteCase(const Case& made, const std::string& folder);
/// Writes TRUTH.json beside them, for people; the scorer keeps the truth to itself.
void WriteTruth(const Case& made, const std::string& folder);
std::string TruthJson(const Case& made);

}  // namespace blind
