#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/blind/causes.h"
#include "tests/blind/machine.h"

namespace blind {

/// A cause to hide, where, and how large it shall show [sigma of one reading].
struct Hidden {
  std::string cause{}, axis{};
  double sigma = 5;
};

/// What a case shall be. Kind: null, single, pair or outside. Causes not given are
/// drawn.
struct CaseRequest {
  std::string kind = "null";
  std::vector<Hidden> hidden{};
  double sigma = 5;
  std::uint64_t seed = 1;
  /// Without outliers, wrong stated sigma, missing columns, wander and clutter.
  bool clean = false;
  int max_rows = 400;
};

/// How the data differ from what a careful person would have written.
struct Blemishes {
  double sigma_factor = 1;  ///< Stated / true.
  bool states_sigma = true;
  double outlier_share = 0;
  double wander_um_per_sqrt_h = 0;
  double clutter_sigma = 0;
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

/// Makes `made` from its request.
void MakeCase(const CaseRequest& request, Case* made);

/// Parts of it: the machine as drawn, the plan, the faults every machine has.
Drawing DrawMachine(const CaseRequest& request);
Plan MakePlan(const CaseRequest& request, const Drawing& drawing);
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

/// Writes DATA.csv, DATA.yaml and machine.yaml into `folder`: all that a diagnosis
/// gets.
void WriteCase(const Case& made, const std::string& folder);
/// Writes TRUTH.json beside them, for people; the scorer keeps the truth to itself.
void WriteTruth(const Case& made, const std::string& folder);
std::string TruthJson(const Case& made);

}  // namespace blind
