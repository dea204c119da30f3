#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "calibration/diagnosis/kinds/delta_correction.h"
#include "calibration/diagnosis/kinds/delta_lines.h"
#include "calibration/diagnosis/kinds/kinds.h"
#include "sim/base/input_error.h"
#include "sim/effects/catalog.h"
#include "sim/effects/kinds/delta_at.h"
#include "sim/effects/linkage_at.h"
#include "sim/kinds/delta/perform.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kArmSd_mm = 2;
constexpr double kUntouchedRim_mm = 100;

// The knobs of a delta that its baseline holds, each line with all that it turns.
void AddDelta(const Observed& o, NuisanceList* builder) {
  const auto add = [&](std::string_view name, double prior_sd) {
    const auto turns = KnobsOfLine(name, 1, DeltaOf(o.machine()));
    const auto first = static_cast<std::size_t>(turns[0].knob);
    builder->Add(
        std::string(name),
        std::string(kDeltaKnobs[first].unit),
        prior_sd,
        [&](Eigen::Index row) {
          const At& at = o.at(row);
          Vec3<double> moved_mm = Vec3<double>::Zero();
          for (const auto& [knob, by] : turns) {
            moved_mm += at.linkage->by_knob.col(knob) * by *
                        kDeltaKnobs[static_cast<std::size_t>(knob)].per_unit;
          }
          return o.MotionSign(row) * at.n.dot(moved_mm);
        },
        o.turns()[first] / turns[0].by);
  };
  for (const int knob :
       {kEndstopKnob, kEndstopKnob + 1, kRadiusKnob, kAngleKnob, kAngleKnob + 1}) {
    const DeltaKnob& declared = kDeltaKnobs[static_cast<std::size_t>(knob)];
    add(declared.name, declared.prior_sd);
  }
  add("arm_length", kArmSd_mm);
  add("scale", kScaleSd_ppm);
}

// Of a delta: poses that its rods do not reach.
void DoubtReach(const RowTable& table,
                const DeltaDrawing& drawing,
                std::vector<Doubt>* doubts) {
  Doubt doubt{.kind = "outside_travel", .refuse = true};
  for (const Row& row : table.rows) {
    const Vec3<double> pose_mm(row.cmd_mm[0], row.cmd_mm[1], row.cmd_mm[2]);
    if (pose_mm.allFinite() && !DeltaMotors_mm(drawing.settings, pose_mm).allFinite()) {
      doubt.rows.push_back(row.row);
    }
  }
  if (doubt.rows.empty()) return;
  doubt.message = fmt::format(
      "{} rows are commanded where the rods of this delta do not reach, the first is "
      "row {}",
      doubt.rows.size(),
      doubt.rows.front());
  doubt.hint = "the wrong machine file, or another unit or zero of the positions";
  doubts->push_back(std::move(doubt));
}

class Delta final : public DiagnosedKind {
 public:
  void AddKinematics(const Observed& o, NuisanceList* list) const override {
    AddDelta(o, list);
  }
  std::vector<double> TurnSds() const override {
    std::vector<double> sds;
    for (const DeltaKnob& knob : kDeltaKnobs) sds.push_back(knob.prior_sd);
    return sds;
  }
  bool Turns(std::string_view line) const override {
    return !KnobsOfLine(line, 0, {}).empty();
  }
  std::vector<double> Turned(const Machine& machine,
                             std::vector<double> knobs,
                             std::span<const Nuisance> baseline,
                             const Eigen::VectorXd& values) const override {
    for (std::size_t k = 0; k < baseline.size(); ++k) {
      const double value = values[static_cast<Eigen::Index>(k)];
      for (const auto& [knob, by] :
           KnobsOfLine(baseline[k].name, value, DeltaOf(machine))) {
        // The bed's plane is straight wherever it is taken.
        if (knob < kBedKnob) knobs[static_cast<std::size_t>(knob)] += by;
      }
    }
    return knobs;
  }

  // Each row at the motors that its pose was commanded with.
  std::shared_ptr<const void> Place(const Observed& observed,
                                    std::vector<At>* at,
                                    std::vector<Injected>* model) const override {
    const DeltaModel<double>& settings = DeltaOf(observed.machine()).settings;
    const DeltaBuild<double> build = BelievedBuild(observed);
    auto placed = std::make_shared<std::vector<LinkageAt>>(at->size());
    const double rim_mm = RimOf_mm(observed.table().rows);
    for (std::size_t i = 0; i < at->size(); ++i) {
      const Row& row = observed.table().rows[i];
      const Vec3<double>& q_mm = (*at)[i].q_mm;
      const auto here = LinkageAtOf(build, settings, row, q_mm);
      if (!here) {
        throw InputError(row.place,
                         fmt::format("row {}: the rods of this machine do not reach "
                                     "({:.1f}, {:.1f}, {:.1f})",
                                     row.row,
                                     q_mm[0],
                                     q_mm[1],
                                     q_mm[2]),
                         Known(row.motor_mm[0])
                             ? "is it their machine file? motor_ columns are commanded "
                               "travel, + down from the endstop"
                             : "is it the machine file of these rows?");
      }
      (*placed)[i] = *here;
    }
    for (std::size_t i = 0; i < at->size(); ++i) {
      (*at)[i].linkage = &(*placed)[i];
      (*at)[i].rim_mm = rim_mm > 0 ? rim_mm : kUntouchedRim_mm;
    }
    // What turns the build is in the rows' places already.
    DeltaBuild<double> turned;
    *model = TurnBuild(*model, &turned);
    return placed;
  }

  // Towers move every axis.
  int AxisOfMotor(const Drive& drive) const override {
    return drive.is_motor ? drive.index : 0;
  }

  // Anywhere over its disc, as high as that is wide; where the rods of the machine as
  // stated reach next to nothing of that, at the row it was drawn from.
  std::shared_ptr<const void> PoseAnywhere(const Observed& observed,
                                           const Settings&,
                                           Rng* rng,
                                           At* at) const override {
    constexpr int kMostDraws = 200;
    const double radius_mm = DeltaOf(observed.machine()).print_radius_mm;
    const DeltaBuild<double> build = BelievedBuild(observed);
    Row row;
    for (double& dir : row.motor_dir) dir = rng->Uniform() < 1.0 / 2 ? -1 : 1;
    std::optional<LinkageAt> here;
    for (int drawn = 0; !here && drawn < kMostDraws; ++drawn) {
      const double out_mm = radius_mm * std::sqrt(rng->Uniform());
      const double angle = 2 * std::numbers::pi * rng->Uniform();
      const Vec3<double> q_mm(out_mm * std::cos(angle),
                              out_mm * std::sin(angle),
                              radius_mm * rng->Uniform());
      here = LinkageAtOf(build, DeltaOf(observed.machine()).settings, row, q_mm);
      if (here) at->q_mm = q_mm;
    }
    if (!here) return nullptr;
    auto placed = std::make_shared<LinkageAt>(*here);
    at->linkage = placed.get();
    return placed;
  }

  // The baseline is built in; the findings act.
  RowTable Performed(const Observed& observed,
                     const ReplayedTwin& twin) const override {
    DeltaPerformConfig config{.machine = observed.machine(),
                              .effects = twin.effects,
                              .header = observed.header(),
                              .fidelity = twin.fidelity,
                              .is_noisy = false,
                              .interrupted = twin.interrupted};
    const FoundDelta found = DeltaWithBaseline(observed, twin.lines);
    config.built.build = found.build;
    config.built.bed = found.bed;
    return PerformDelta(config, observed.table().rows);
  }

  double Rounding_mm(const Observed& observed, Eigen::Index i) const override {
    const auto stated = observed.header().settings.find(observed.row(i).settings);
    if (observed.at(i).linkage == nullptr ||
        stated == observed.header().settings.end()) {
      return 0;
    }
    double variance_mm2 = 0;
    for (int tower = 0; tower < kNumTowers; ++tower) {
      const auto steps = stated->second.steps_per_mm.find(TowerName(tower));
      if (steps == stated->second.steps_per_mm.end() || steps->second <= 0) continue;
      const double slope = observed.at(i).n.dot(
          observed.at(i).linkage->by_knob.col(kEndstopKnob + tower));
      variance_mm2 += std::pow(slope / steps->second, 2) / 12.0;
    }
    return std::sqrt(variance_mm2);
  }

  std::string_view FewestRowsHint() const override {
    return "a delta's calibration takes 7 touches at least";
  }
  bool CanStandAt(const Machine& machine, int axis, double position_mm) const override {
    const DeltaModel<double>& settings = DeltaOf(machine).settings;
    Vec3<double> pose_mm = Vec3<double>::Zero();
    pose_mm[axis] = position_mm;
    const double highest_mm = *std::ranges::max_element(settings.endstop_mm);
    return DeltaMotors_mm(settings, pose_mm).allFinite() &&
           std::abs(pose_mm.z()) <= (1 + kBeyondTravel) * highest_mm;
  }
  void DoubtTravel(const RowTable& table,
                   const Machine& machine,
                   std::vector<Doubt>* doubts) const override {
    DoubtReach(table, DeltaOf(machine), doubts);
  }

  void RequireSettings(ControllerKind controller) const override {
    RequireDeltaGeometry(controller);
  }
  std::vector<CorrectionFile> Correction(ControllerKind controller,
                                         const Diagnosis& diagnosis,
                                         const Observed& observed,
                                         const std::string&) const override {
    return {{.text = DeltaCorrectionText(controller, diagnosis, observed)}};
  }
};

}  // namespace

const DiagnosedKind& DiagnosedDelta() {
  static const Delta kind;
  return kind;
}

}  // namespace caltwin
