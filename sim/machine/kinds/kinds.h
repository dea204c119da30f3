#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

class MachineKind;

/// @name Every kind there is
const MachineKind* CartesianKind();
/// `kinematics: cartesian` with `beam:`.
const MachineKind* GantryOfTwoMotorsKind();
const MachineKind* DeltaKind();
const MachineKind* TripleZKind();
const MachineKind* ZStationKind();
const MachineKind* MotorStageKind();
const MachineKind* CoreXyKind();
/// `kinematics: corexy` with `screws:`.
const MachineKind* CoreXyOnScrewsKind();

std::vector<const MachineKind*> AllMachineKinds();
/// Their words in files, cartesian first.
std::vector<std::string> MachineKindNames();
/// The kind of that name; CartesianKind() for what is none.
const MachineKind* MachineKindNamed(std::string_view name);

}  // namespace caltwin
