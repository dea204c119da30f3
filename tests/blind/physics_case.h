#pragma once

#include <string>

#include "tests/blind/case.h"

namespace blind {

/// What performs a plan: the program under test, run as anybody runs it.
struct Simulator {
  std::string binary{};             ///< Path of `caltwin`.
  std::string folder{};             ///< Of the case. Gets `model.xml`, un-edited.
  std::string model = BLIND_MODEL;  ///< A router's model.xml.
};

/// Makes `made` from its request: a machine as drawn, its model.xml edited as text so
/// that it has what is hidden, and `caltwin simulate` without a truth file to measure
/// it. MuJoCo gives the readings; what a model cannot have is added to them: how
/// artefacts stand, noise, blemishes. The edited model is gone afterwards.
void MakePhysicsCase(const Simulator& simulator,
                     const CaseRequest& request,
                     Case* made);

/// The noise-free readings of a request's plan with all its edits, and without what is
/// hidden: for tests of the edits against their closed forms.
struct PhysicsReadings {
  std::vector<double> without_mm{}, with_mm{};
};
PhysicsReadings HideInModel(const Simulator& simulator, Case* made);

/// A plan as `caltwin simulate` reads it.
std::string PlanYaml(const std::vector<CampaignRequest>& campaigns,
                     const Drawing& drawing,
                     Random* random,
                     Plan* plan);

}  // namespace blind
