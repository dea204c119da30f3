#pragma once

#include <string>
#include <vector>

#include "tests/blind/gantry.h"
#include "tests/blind/plan.h"
#include "tests/blind/random.h"
#include "tests/blind/weather.h"

namespace blind {

/// What a defect's shape may be drawn from.
struct Circumstances {
  const Drawing& drawing;
  const Weather& weather;
  const Plan& plan;
  const std::vector<double>& times_s;
  Random* random;
};

/// A cause that can be hidden in the data.
struct Cause {
  std::string name{};
  std::vector<std::string> axes{};
  /// Campaigns that show it and tell it from its twins.
  std::vector<CampaignRequest> (*campaigns)(const std::string& axis);
  /// Its shape with size 1; sizes are in um, urad or ms.
  Defect (*make)(const std::string& axis, const Circumstances& at);
  /// Typical size, where the scaling towards the wanted visible effect begins.
  double typical = 10;
  /// Size that is not scaled (a tip entered as diameter): above 0.
  double fixed_size = 0;
  /// Outside the library: the answers that are not wrong beside none and unknown.
  std::vector<std::string> acceptable{};
  /// Outside the library: what it varies with.
  std::vector<std::string> covariates{};
};

/// Causes of the catalogue, then those outside it.
const std::vector<Cause>& LibraryCauses();
const std::vector<Cause>& OutsideCauses();
/// Those of the catalogue that a model of MuJoCo, edited as text, can have.
const std::vector<Cause>& PhysicsCauses();
/// Of any list; nullptr if there is none of that name. `physics`: of that list only.
const Cause* FindCause(const std::string& name, bool physics = false);

std::vector<Cause> DriveCauses();
std::vector<Cause> FrameCauses();
std::vector<Cause> ProbeCauses();
std::vector<Cause> TimeCauses();

/// 0, 1, 2 for "x", "y", "z".
int AxisIndex(const std::string& axis);

}  // namespace blind
