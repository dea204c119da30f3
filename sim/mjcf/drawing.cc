#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/machine/machine_kind.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {
namespace {

// What models/gantry_router/model.xml is without its looks.
constexpr const char* kGenericCartesian = R"(
<mujoco model="cartesian">
  <compiler angle="radian" autolimits="true" boundmass="0"/>
  <option timestep="0.0002" integrator="Euler" solver="Newton" iterations="20" tolerance="1e-15" ccd_tolerance="1e-12">
    <flag island="disable"/>
  </option>
  <visual><global offwidth="1280" offheight="960"/></visual>
  <default>
    <geom contype="0" conaffinity="0" mass="0"/>
    <default class="nut"><joint type="slide" armature="1e6"/></default>
    <default class="rail"><joint type="slide"/></default>
    <default class="stylus"><joint type="slide" stiffness="15000" damping="30"/></default>
  </default>
  <worldbody>
    <light pos="0.15 -0.6 1" dir="0 0.6 -1" directional="true"/>
    <body name="table"/>
    <body name="y_nut"><joint name="y_nut" class="nut" axis="0 1 0"/><inertial pos="0 0 0" mass=".05" diaginertia="1e-4 1e-4 1e-4"/></body>
    <body name="y_carriage">
      <joint name="y" class="rail" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <geom type="box" pos=".15 .06 .26" size=".22 .02 .04" group="2"/>
      <body name="x_nut"><joint name="x_nut" class="nut" axis="1 0 0"/><inertial pos="0 0 0" mass=".05" diaginertia="1e-4 1e-4 1e-4"/></body>
      <body name="x_carriage">
        <joint name="x" class="rail" axis="1 0 0"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <geom type="box" pos="0 .03 .26" size=".05 .008 .07" group="2"/>
        <body name="z_nut"><joint name="z_nut" class="nut" axis="0 0 1"/><inertial pos="0 0 0" mass=".05" diaginertia="1e-4 1e-4 1e-4"/></body>
        <body name="z_carriage">
          <joint name="z" class="rail" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <geom type="cylinder" pos="0 0 .11" size=".03 .06" group="2"/>
          <body name="stylus">
            <joint name="stylus_x" class="stylus" axis="1 0 0"/>
            <joint name="stylus_y" class="stylus" axis="0 1 0"/>
            <joint name="stylus_z" class="stylus" axis="0 0 1"/>
            <inertial pos="0 0 0" mass=".02" diaginertia="1e-6 1e-6 1e-6"/>
            <geom name="tip" type="sphere" size=".001"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <tendon>
    %PLAYS%
  </tendon>
  <equality>
    <tendon name="x_rigid" tendon1="x_play"/>
    <tendon name="y_rigid" tendon1="y_play"/>
    <tendon name="z_rigid" tendon1="z_play"/>
  </equality>
</mujoco>
)";

// A tendon a drive: what it moves less where its nut stands.
std::string PlaysOf(const DriveMap* drives) {
  std::string plays;
  for (const Axis axis : kAxes) {
    plays += fmt::format(R"(<fixed name="{}_play">)", Name(axis));
    const Vec3<double> by_axis =
        drives == nullptr ? Unit(axis) : drives->drives_by_axis.row(Index(axis));
    for (const Axis moved : kAxes) {
      if (by_axis[Index(moved)] == 0) continue;
      plays += fmt::format(
          R"(<joint joint="{}" coef="{}"/>)", Name(moved), by_axis[Index(moved)]);
    }
    plays += fmt::format(R"(<joint joint="{}_nut" coef="-1"/></fixed>)", Name(axis));
  }
  return plays;
}

}  // namespace

Mjcf Mjcf::GenericCartesian(const DriveMap* drives) {
  std::array<char, 1000> error{};
  std::string text = kGenericCartesian;
  constexpr std::string_view kPlays = "%PLAYS%";
  text.replace(text.find(kPlays), kPlays.size(), PlaysOf(drives));
  mjSpec* spec = mj_parseXMLString(text.c_str(), nullptr, error.data(), error.size());
  Require(spec != nullptr, error.data());
  return Mjcf(spec);
}

void ApplyDrawing(const Machine& machine, Mjcf* model) {
  for (const Axis axis : kAxes) {
    model->SetMovingMass(axis, machine.axis(axis).moving_mass_kg);
    model->SetRailFriction(axis, machine.axis(axis).rail_friction_n);
  }
  model->SetStylus(machine.probe.tip_radius_mm,
                   machine.probe.stiffness_n_per_mm,
                   machine.probe.disc_radius_mm);
}

Mjcf ModelOf(const Machine& machine) {
  Mjcf model = machine.model.empty() ? Mjcf::GenericCartesian(machine.kind->drive_map())
                                     : Mjcf::FromFile(machine.model);
  ApplyDrawing(machine, &model);
  return model;
}

}  // namespace caltwin
