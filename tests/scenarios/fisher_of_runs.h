#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/study/study.h"
#include "scenarios/study/vary.h"
#include "sim/base/yaml.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

/// Something that touches depend on, by its name in a study's `vary`.
struct Unknown {
  std::string name{};
  double at = 0;     ///< Where the derivatives are taken, in the name's unit.
  double moved = 0;  ///< To both sides.
  double known = 0;  ///< sd that it is known to beforehand; 0: nothing is known.
};

/// A reading beside the touches: the sum of some unknowns.
struct SumRead {
  std::vector<std::string> of{};
  double sigma = 0;
};

/// So many touches of a campaign, the first ones; 0: all.
struct TouchesOf {
  std::string campaign{};
  std::size_t first = 0;
};

/// What a bound is asked of: a contender of a study, its touches and their noise.
struct FisherCase {
  std::string study{};  ///< Below scenarios/studies.
  std::size_t of_case = 0;
  std::vector<TouchesOf> touches{};
  double sigma_mm = 0;  ///< Of a trigger.
  double step_mm = 0;   ///< Of a motor; of a delta's three, as their slopes weigh them.
  std::vector<Unknown> unknowns{};
  std::vector<std::string> told{};  ///< By the names that the procedure tells them by.
  std::vector<SumRead> sums{};
};

/// Least standard deviations (Cramer-Rao) of what a procedure's touches depend on, by
/// differences of whole simulated calibrations, each with one thing moved: neither an
/// estimator's formula nor a derivative of its own. Motors of a thousandth of the step
/// move in them, so that no rounding looks like something told; their own step is
/// counted as noise. Where the block lies and how it is turned, and how high each bed
/// is, nobody knows, but of a delta, whose heights are its endstops.
class FisherOfRuns {
 public:
  explicit FisherOfRuns(const FisherCase& asked)
      : asked_(asked),
        study_(ReadStudy(std::string(CALTWIN_SOURCE_DIR "/scenarios/studies/") +
                         asked.study)) {
    const std::vector<Touch> here = Touches(asked.unknowns.size(), 0);
    slopes_ = Eigen::MatrixXd::Zero(Place(here.size()), Place(asked.unknowns.size()));
    for (std::size_t k = 0; k < asked.unknowns.size(); ++k) {
      if (asked.unknowns[k].moved == 0) continue;
      const std::vector<Touch> up = Touches(k, 1), down = Touches(k, -1);
      if (up.size() != here.size() || down.size() != here.size()) {
        ADD_FAILURE() << asked.unknowns[k].name << " changes the number of touches";
        return;
      }
      for (std::size_t i = 0; i < here.size(); ++i) {
        slopes_(Place(i), Place(k)) =
            (up[i].motor_mm - down[i].motor_mm) / (2 * asked.unknowns[k].moved);
      }
    }
    AddPlaces(here);
  }

  std::string name() const { return study_.cases.at(asked_.of_case).Name(); }
  std::size_t num_touches() const { return static_cast<std::size_t>(slopes_.rows()); }

  /// Of one that is told, in its unit. Throws std::logic_error where it is not there.
  double Bound(const std::string& told) const {
    for (const auto& [name, bound] : Bounds()) {
      if (name == told || name.substr(0, name.rfind('.')) == told) return bound;
    }
    throw std::logic_error(told);
  }

 private:
  // By name, in the name's unit.
  std::map<std::string, double> Bounds() const {
    const Eigen::Index size = slopes_.cols() + places_.cols();
    // What touches leave open is known to a metre, a second or a radian.
    Eigen::MatrixXd information = Eigen::MatrixXd::Identity(size, size) * 1e-6;
    for (std::size_t k = 0; k < asked_.unknowns.size(); ++k) {
      const double known = asked_.unknowns[k].known;
      if (known > 0) information(Place(k), Place(k)) += 1 / (known * known);
    }
    Eigen::MatrixXd rows(slopes_.rows(), size);
    rows << slopes_, places_;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      information += rows.row(i).transpose() * rows.row(i) / Variance_mm2(i);
    }
    for (const SumRead& sum : asked_.sums) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
      for (std::size_t k = 0; k < asked_.unknowns.size(); ++k) {
        row[Place(k)] =
            static_cast<double>(std::ranges::count(sum.of, asked_.unknowns[k].name));
      }
      information += row * row.transpose() / (sum.sigma * sum.sigma);
    }
    const Eigen::MatrixXd covariance =
        information.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
    std::map<std::string, double> bounds;
    for (std::size_t k = 0; k < asked_.unknowns.size(); ++k) {
      if (asked_.unknowns[k].moved == 0) continue;
      bounds[asked_.unknowns[k].name] = std::sqrt(covariance(Place(k), Place(k)));
    }
    return bounds;
  }

  static constexpr double kFiner = 1000;

  struct Touch {
    Row row{};
    std::size_t axis = 0;
    double motor_mm = 0;  ///< Where the motor stood, in drawn mm.
  };

  static Eigen::Index Place(std::size_t i) { return static_cast<Eigen::Index>(i); }

  bool IsAsked(const Row& row, std::map<std::string, std::size_t>* seen) const {
    for (const TouchesOf& some : asked_.touches) {
      if (row.campaign != some.campaign) continue;
      return ++(*seen)[row.campaign] <= some.first || some.first == 0;
    }
    return false;
  }

  // The touches of the calibration with one unknown moved to a side.
  std::vector<Touch> Touches(std::size_t moved, double side) const {
    Scenario scenario = study_.cases.at(asked_.of_case).scenario;
    MakeFiner(&scenario);
    std::string text;
    for (std::size_t k = 0; k < asked_.unknowns.size(); ++k) {
      const Unknown& unknown = asked_.unknowns[k];
      std::erase_if(scenario.varied,
                    [&](const VariedNumber& had) { return had.name == unknown.name; });
      const double value = unknown.at + (k == moved ? side * unknown.moved : 0);
      const bool is_steps = unknown.name.starts_with("steps_per_mm.");
      text += fmt::format("{}: {}\n", unknown.name, value * (is_steps ? kFiner : 1));
    }
    Faults faults;
    Vary(ReadYamlText(text, "moved", &faults), &scenario);
    faults.ThrowIfAny();
    const RunResult run = RunScenario(
        scenario, {.fidelity = Fidelity::kFast, .seed = study_.seed, .sample = 0});
    std::vector<Touch> touches;
    std::map<std::string, std::size_t> seen;
    for (const Row& row : run.rows.rows) {
      if (IsAsked(row, &seen)) touches.push_back(TouchOf(row, run, scenario));
    }
    return touches;
  }

  // Motors of smaller steps, which the firmware knows of.
  static void MakeFiner(Scenario* scenario) {
    Machine& machine = scenario->machine.machine;
    for (AxisDrawing& axis : machine.axes) axis.microsteps *= kFiner;
    for (double& steps_per_mm : machine.settings.steps_per_mm) steps_per_mm *= kFiner;
    std::erase_if(scenario->settings,
                  [](const SettingSpec& spec) { return spec.key == "steps_per_mm"; });
    if (!machine.kind->bed_is_on_screws()) return;
    for (ScrewDrawing& screw : TripleZOf(machine).screws) screw.microsteps *= kFiner;
    if (auto* const printer = scenario->kind.As<TripleZScenario>()) {
      printer->steps_per_mm *= kFiner;
    }
  }

  // What a motor counts depends on the machine alone, not on the settings that a
  // calibration has changed since. Of a printer the settings are still those of before.
  static Touch TouchOf(const Row& row, const RunResult& run, const Scenario& scenario) {
    Touch touch{.row = row};
    for (std::size_t a = 1; a < 3; ++a) {
      if (std::abs(row.n[a]) > std::abs(row.n[touch.axis])) touch.axis = a;
    }
    const std::size_t a = touch.axis;
    if (scenario.kind.As<DeltaScenario>() || scenario.kind.As<TripleZScenario>()) {
      touch.motor_mm = row.value_mm;
      return touch;
    }
    const std::string axis(1, "xyz"[a]);
    const SettingsInForce& settings = run.header.settings.at(row.settings);
    touch.motor_mm =
        row.cmd_mm[a] + row.n[a] * (row.value_mm + settings.tip_radius_mm.value());
    if (row.dir[a] < 0) touch.motor_mm -= settings.backlash_mm.at(axis);
    touch.motor_mm *= settings.steps_per_mm.at(axis) / (800 * kFiner);
    return touch;
  }

  // A setup lies where it happens to, along each axis touched, and turned.
  void AddPlaces(const std::vector<Touch>& touches) {
    places_ = Eigen::MatrixXd::Zero(slopes_.rows(), 0);
    if (study_.cases.at(asked_.of_case).scenario.kind.As<DeltaScenario>()) return;
    std::set<std::pair<std::string, std::size_t>> places;
    std::set<std::string> turned;
    for (const Touch& touch : touches) {
      places.emplace(touch.row.setup, touch.axis);
      if (touch.axis < 2) turned.insert(touch.row.setup);
    }
    places_ =
        Eigen::MatrixXd::Zero(slopes_.rows(), std::ssize(places) + std::ssize(turned));
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const Touch& touch = touches[i];
      const auto place = places.find({touch.row.setup, touch.axis});
      places_(Place(i), std::distance(places.begin(), place)) = 1;
      if (touch.axis == 2) continue;
      const double lever_mm =
          touch.axis == 0 ? -touch.row.cmd_mm[1] : touch.row.cmd_mm[0];
      places_(Place(i),
              std::ssize(places) +
                  std::distance(turned.begin(), turned.find(touch.row.setup))) =
          lever_mm;
    }
  }

  // The three motors of a printer round independently: as much as a height follows
  // each, which `endstop` tells by itself.
  double Variance_mm2(Eigen::Index row) const {
    double weight = 0;
    for (std::size_t k = 0; k < asked_.unknowns.size(); ++k) {
      if (!asked_.unknowns[k].name.starts_with("endstop.")) continue;
      weight += std::pow(slopes_(row, Place(k)), 2);
    }
    return asked_.sigma_mm * asked_.sigma_mm +
           asked_.step_mm * asked_.step_mm / 12 * (weight > 0 ? weight : 1);
  }

  FisherCase asked_;
  Study study_;
  Eigen::MatrixXd slopes_{}, places_{};
};

}  // namespace caltwin
