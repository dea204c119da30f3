// What the touches of each procedure can tell at best. The numbers are kept in
// scenarios/studies/coverage/bounds.csv, beside which tools/coverage.py puts the
// scatter of the estimates.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "tests/scenarios/fisher_of_runs.h"
#include "tests/scenarios/kept_bounds.h"

namespace caltwin {
namespace {

constexpr double kStep_mm = 1.0 / 800;

// What the touches of one axis depend on, with the gap of a router that is as good as
// all of a study together: the root mean square.
std::vector<Unknown> AxisOf(const std::string& axis, double gap_mm = 0.08) {
  return {{"steps_per_mm." + axis + ".true_steps_per_mm", 800, 4},
          {"backlash." + axis + ".gap_mm", gap_mm, 0.02},
          {"probe_pretravel." + axis + ".pretravel_mm", 0.02, 0.01},
          {"tip_size.radius_error_mm", 0, 0.01, 0.001},
          {"built.probe.hysteresis_mm", 0.0025, 0.00125, 0.0005},
          {"trigger_latency.latency_ms", 10, 5}};
}

template <typename T>
std::vector<T> With(std::vector<T> some, const std::vector<T>& more) {
  some.insert(some.end(), more.begin(), more.end());
  return some;
}

// Known beforehand: in place of not at all.
std::vector<Unknown> Known(std::vector<Unknown> all,
                           const std::string& name,
                           double known) {
  for (Unknown& one : all) {
    if (one.name == name) one.known = known;
  }
  return all;
}

const std::vector<Unknown> kSlopes = {{"bed_tilt.slope_x_mrad", 0.5, 2},
                                      {"bed_tilt.slope_y_mrad", 0.5, 2}};

const std::vector<std::string> kToldSlopes = {"bed_tilt.slope_x_mrad",
                                              "bed_tilt.slope_y_mrad"};

// Both axes of a table, and their squareness.
std::vector<Unknown> BothAxes() {
  std::vector<Unknown> all = With(AxisOf("x"), kSlopes);
  const std::vector<Unknown> y = AxisOf("y");
  all.insert(all.end(), y.begin(), y.begin() + 3);
  all.push_back({"squareness.C0Y.angle_mrad", 0, 2});
  return all;
}

// A delta as the joint estimate believes it.
std::vector<Unknown> Delta() {
  return {{"endstop.a.error_mm", 0.1, 0.5, 5},
          {"endstop.b.error_mm", 0, 0.5, 5},
          {"endstop.c.error_mm", 0, 0.5, 5},
          {"delta_radius.error_mm", 0.5, 0.5, 5},
          {"tower_angle.a.angle_deg", 0.2, 0.3, 2},
          {"tower_angle.b.angle_deg", 0, 0.3, 2},
          {"bed_tilt.slope_x_mrad", 0, 5, 10},
          {"bed_tilt.slope_y_mrad", 0, 5, 10}};
}

// And all else that an engine's model has not, or the joint estimate has for a price.
std::vector<Unknown> DeltaParts(double arm_mm) {
  std::vector<Unknown> all = Delta();
  all.push_back({"arm_length.error_mm", 0, 0.5, arm_mm});
  for (const char* rod : {"a1", "a2", "b1", "b2", "c1", "c2"}) {
    all.push_back({fmt::format("rod_mismatch.{}.length_error_mm", rod), 0, 0.2, 0.1});
  }
  for (const char* tower : {"a", "b", "c"}) {
    all.push_back({fmt::format("tower_lean.{}.radial_mrad", tower), 0, 4, 2});
    all.push_back({fmt::format("tower_lean.{}.tangential_mrad", tower), 0, 4, 2});
    all.push_back({fmt::format("tower_twist.{}.angle_deg", tower), 0, 1, 0.5});
    all.push_back({fmt::format("belt_pitch.{}.error_ppm", tower), 0, 1000, 300});
  }
  all.push_back({"tower_radius.a.error_mm", 0, 0.5, 0.3});
  all.push_back({"tower_radius.b.error_mm", 0, 0.5, 0.3});
  return all;
}

constexpr double kProbe_mm = 0.001;

// A case of a router whose steps/mm are known to so much where they are not asked for.
FisherCase Router(const std::string& study,
                  std::size_t of_case,
                  std::vector<TouchesOf> touches,
                  std::vector<Unknown> unknowns,
                  std::vector<std::string> told,
                  double known_steps_per_mm = 0) {
  for (const char* axis : {"x", "y", "z"}) {
    const std::string name = fmt::format("steps_per_mm.{}.true_steps_per_mm", axis);
    const double moved = known_steps_per_mm > 0 ? 4 : 0;
    if (std::ranges::find(unknowns, name, &Unknown::name) != unknowns.end()) continue;
    unknowns.push_back({name, 800, moved, known_steps_per_mm});
  }
  return {.study = study,
          .of_case = of_case,
          .touches = std::move(touches),
          .sigma_mm = kProbe_mm,
          .step_mm = kStep_mm,
          .unknowns = std::move(unknowns),
          .told = std::move(told)};
}

// Steps/mm are set by phase 2, gap and pre-travel by phases 2 to 4: what each is made
// of.
std::vector<FisherCase> NextCases() {
  std::vector<FisherCase> all;
  for (const std::string axis : {"x", "y", "z"}) {
    const TouchesOf phase2{"dual_dimension." + axis, axis == "z" ? 20U : 40U};
    const TouchesOf phase4{"deflection." + axis, axis == "z" ? 50U : 20U};
    const std::vector<Unknown> unknowns = With(AxisOf(axis), kSlopes);
    all.push_back(Router("next.yaml", 0, {phase2}, unknowns, {"steps_per_mm." + axis}));
    all.push_back(Router("next.yaml",
                         0,
                         {phase2, {"trigger_release." + axis}, phase4},
                         unknowns,
                         {"backlash." + axis, "probe_pretravel." + axis}));
  }
  all.push_back(Router("next.yaml", 0, {{"plane_tilt"}}, kSlopes, kToldSlopes));
  return all;
}

// Where steps/mm are right and a gap is known so well; what the trigger is late by
// counts as pre-travel.
std::vector<Unknown> DeflectionOf(const std::string& axis, double gap_u_mm) {
  std::vector<Unknown> all =
      Known(AxisOf(axis), "backlash." + axis + ".gap_mm", gap_u_mm);
  all.erase(all.begin());
  all.pop_back();
  return all;
}

std::vector<FisherCase> PhaseCases() {
  const std::vector<Unknown> rough =
      Known(AxisOf("x"), "steps_per_mm.x.true_steps_per_mm", 8);
  const std::string gantry = "coverage/gantry.yaml", alone = "coverage/deflection.yaml";
  return {
      Router(gantry, 1, {{"dual_dimension.x", 40}}, AxisOf("x"), {"steps_per_mm.x"}),
      Router(gantry, 2, {{"trigger_release.x"}}, rough, {"backlash.x"}),
      Router(gantry, 3, {{"trigger_release.x"}}, rough, {"backlash.x"}),
      Router(gantry, 5, {{"plane_tilt"}}, kSlopes, kToldSlopes, 8),
      Router(alone,
             0,
             {{"deflection.x", 20}},
             DeflectionOf("x", 0.002 / std::sqrt(12)),
             {"probe_pretravel.x"}),
      // By the dial: 0.6 um.
      Router(alone,
             1,
             {{"deflection.y", 20}},
             DeflectionOf("y", 0.0006),
             {"probe_pretravel.y"})};
}

std::vector<FisherCase> JointCases() {
  return {Router("coverage/joint.yaml",
                 0,
                 {{"joint.z"}, {"joint.ledge"}, {"joint.tilt"}},
                 With(AxisOf("z"), kSlopes),
                 With({"steps_per_mm.z",
                       "backlash.z",
                       "probe_pretravel.z",
                       "tip_size",
                       "trigger_latency"},
                      kToldSlopes),
                 2),
          Router("coverage/joint_squareness.yaml",
                 0,
                 {{"joint.x"}, {"joint.y"}, {"joint.squareness"}, {"joint.tilt"}},
                 BothAxes(),
                 With({"steps_per_mm.x",
                       "steps_per_mm.y",
                       "backlash.x",
                       "backlash.y",
                       "squareness.C0Y",
                       "probe_pretravel.x",
                       "probe_pretravel.y",
                       "tip_size",
                       "trigger_latency"},
                      kToldSlopes),
                 2)};
}

FisherCase DeltaCase(const std::string& study,
                     std::size_t of_case,
                     const std::string& campaign,
                     std::vector<Unknown> unknowns,
                     std::vector<std::string> told) {
  return {.study = study,
          .of_case = of_case,
          .touches = {{campaign}},
          .sigma_mm = 0.005,
          .step_mm = 0.0125,
          .unknowns = std::move(unknowns),
          .told = std::move(told)};
}

// Each rod's length is the drawing's, what all are longer, and its own.
FisherCase RodsByCalliper() {
  std::vector<std::string> told = {"endstop.a",
                                   "endstop.b",
                                   "endstop.c",
                                   "tower_angle.a",
                                   "tower_angle.b",
                                   "arm_length"};
  std::vector<SumRead> rods;
  for (const char* rod : {"a1", "a2", "b1", "b2", "c1", "c2"}) {
    told.push_back(fmt::format("rod_mismatch.{}", rod));
    rods.push_back({{"arm_length.error_mm", told.back() + ".length_error_mm"}, 0.020});
  }
  for (const char* tower : {"a", "b", "c"}) {
    told.push_back(fmt::format("tower_lean.{}.radial_mrad", tower));
    told.push_back(fmt::format("tower_lean.{}.tangential_mrad", tower));
    told.push_back(fmt::format("tower_twist.{}", tower));
  }
  FisherCase all = DeltaCase("coverage/delta_rods.yaml",
                             0,
                             "delta_joint",
                             DeltaParts(0.5),
                             With(std::move(told), kToldSlopes));
  all.sums = rods;
  return all;
}

std::vector<FisherCase> DeltaCases() {
  const std::vector<std::string> six = {"endstop.a",
                                        "endstop.b",
                                        "endstop.c",
                                        "delta_radius",
                                        "tower_angle.a",
                                        "tower_angle.b"};
  return {DeltaCase(
              "coverage/delta.yaml", 0, "delta_joint", Delta(), With(six, kToldSlopes)),
          RodsByCalliper()};
}

std::vector<FisherCase> BedCases() {
  // The second stands where the scenario has it.
  const std::vector<Unknown> pivots = With(kSlopes,
                                           {{"pivot_position.z1.dx_mm", 0, 5},
                                            {"pivot_position.z1.dy_mm", 0, 5},
                                            {"pivot_position.z2.dx_mm", -25, 5},
                                            {"pivot_position.z2.dy_mm", 18.33, 5},
                                            {"pivot_position.z3.dx_mm", 0, 5},
                                            {"pivot_position.z3.dy_mm", 0, 5}});
  std::vector<std::string> told;
  for (std::size_t k = kSlopes.size(); k < pivots.size(); ++k) {
    told.push_back(pivots[k].name);
  }
  const std::string study = "coverage/triple_z.yaml", pivoting = "pivots_and_wiring";
  return {{study, 0, {{"bed_tilt", 9}}, 0.010, kStep_mm, kSlopes, kToldSlopes},
          {study, 1, {{pivoting}}, 0.003, kStep_mm, pivots, told},
          {study, 1, {{pivoting, 9}}, 0.003, kStep_mm, kSlopes, kToldSlopes}};
}

struct Bound {
  std::string contender{}, quantity{};
  double bound = 0;
  std::size_t touches = 0;
};

// Moved is how a tower stands; told is the firmware's angle, which is more by the
// drawing's 1 + 30 / 130: the effector's joints stay.
double ToldPerMoved(const std::string& quantity) {
  return quantity.starts_with("tower_angle") ? 1 + 30.0 / 130 : 1;
}

std::vector<Bound> AllBounds() {
  std::vector<Bound> all;
  for (const auto& cases :
       {NextCases(), PhaseCases(), JointCases(), DeltaCases(), BedCases()}) {
    for (const FisherCase& one : cases) {
      const FisherOfRuns fisher(one);
      for (const std::string& told : one.told) {
        all.push_back({fisher.name(),
                       told,
                       ToldPerMoved(told) * fisher.Bound(told),
                       fisher.num_touches()});
      }
    }
  }
  return all;
}

// Rewrites the file where CALTWIN_WRITE_BOUNDS is set: read what has changed, and why.
TEST(Bounds, OfEveryProcedureAreThoseOfTheFile) {
  const std::vector<Bound> all = AllBounds();
  if (std::getenv("CALTWIN_WRITE_BOUNDS") != nullptr) {
    std::string text = "contender,quantity,bound,touches\n";
    for (const Bound& one : all) {
      text += fmt::format(
          "{},{},{:.5g},{}\n", one.contender, one.quantity, one.bound, one.touches);
    }
    WriteTextFile(kBoundsFile, text);
  }
  const std::map<std::string, double> kept = KeptBounds();
  EXPECT_EQ(kept.size(), all.size());
  for (const Bound& one : all) {
    const auto found = kept.find(one.contender + " " + one.quantity);
    ASSERT_NE(found, kept.end()) << one.contender << " " << one.quantity;
    EXPECT_NEAR(found->second / one.bound, 1, 0.005)
        << one.contender << " " << one.quantity << " " << one.bound;
  }
}

}  // namespace
}  // namespace caltwin
