#pragma once

#include <string>

#include "tests/blind/case.h"

namespace blind {

/// What performs a plan: the program under test, run as anybody runs it.
struct Simulator {
  std::string binary{};             ///< Path of `caltwin`.
  std::string folder{};             ///< Of the case. Gets `model.xml`, un-edited.
  std::string model = BLIND_MODEL;  ///< A router's model.xml.
  /// Leave the machine as built there: built.yaml and built.xml.
  bool keep_built = false;
};

/// Makes `made` from its request: a machine as drawn, its model.xml edited as text so
/// that it has what is hidden, and `caltwin simulate` without a truth file to measure
/// it. MuJoCo gives the readings; what a model cannot have is added to them: how
/// artefacts stand, noise, blemishes. The edited model is gone afterwards.
void MakePhysicsCase(const Simulator& simulator,
                     const CaseRequest& request,
                     Case* made);

/// Its parts. First a plan that shows what is hidden, performed by the ordinary machine
/// (noise-free readings, in `made`), and each hidden cause's form and size.
Weather PreparePhysicsCase(const Simulator& simulator,
                           const CaseRequest& request,
                           Case* made);
/// Then the same plan with all edits: noise-free values with and without them.
struct PhysicsReadings {
  std::vector<double> without_mm{}, with_mm{};
};
PhysicsReadings HideInModel(const Simulator& simulator, const Case& made);

/// A plan as `caltwin simulate` reads it.
std::string PlanYaml(const std::vector<CampaignRequest>& campaigns,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan);

}  // namespace blind
