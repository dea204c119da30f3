#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/correction.h"
#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/nuisance_list.h"
#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/rng.h"
#include "sim/effects/drive.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// A channel, and the word of the one covariate of a free form in it.
using ChannelAndWord = std::pair<std::string, std::string>;

/// A machine as believed, with its baseline and findings, to be measured again.
struct ReplayedTwin {
  std::vector<Injected> effects{};
  std::vector<BaselineLine> lines{};  ///< Of the baseline, as fitted.
  Fidelity fidelity = Fidelity::kPhysics;
  std::function<bool()> interrupted{};
};

/// @name Lines of a baseline
/// What a drive's scale (1 ppm), play (1 mm) and counting in whole steps do, and the
/// pre-travel of the probe along an axis.
void AddScale(const Observed& o, int drive, NuisanceList* list);
void AddPlay(const Observed& o, int drive, NuisanceList* list);
void AddWholeSteps(const Observed& o, int drive, NuisanceList* list);
void AddPretravel(const Observed& o, Axis axis, NuisanceList* list);
/// The column of AddScale, and what it counts from: what is set, beside the drawing.
double ScaleColumn(const Observed& o, int drive, Eigen::Index row);
double PpmSetBesideDrawing(const Observed& o, int drive);

/// What a diagnosis asks of one kind of machine. Without state, one object a kind; what
/// is not overridden is as on a gantry.
class DiagnosedKind {
 public:
  DiagnosedKind() = default;
  DiagnosedKind(const DiagnosedKind&) = delete;
  DiagnosedKind& operator=(const DiagnosedKind&) = delete;
  virtual ~DiagnosedKind() = default;

  /// @name The baseline
  /// What the machine's own kinematics may be off by.
  virtual void AddKinematics(const Observed& o, NuisanceList* list) const;
  /// Where the bed and all that is touched stand.
  virtual void AddPlaces(const Observed& o, NuisanceList* list) const;
  /// Whether each homing puts bed or head anew, with baseline lines of its own: what is
  /// read after two homings is no repeat.
  virtual bool StandsAnewWhenHomed() const { return false; }
  /// How far each number of the machine's build may reasonably be off that lines of its
  /// baseline turn, which rows follow straight only so far; empty: lines are effects.
  virtual std::vector<double> TurnSds() const { return {}; }
  bool turns_build() const { return !TurnSds().empty(); }
  /// Whether that line turns the build.
  virtual bool Turns(std::string_view) const { return false; }
  /// `turns` with what these lines, so fitted, add.
  virtual std::vector<double> Turned(const Machine&,
                                     std::vector<double> turns,
                                     std::span<const Nuisance>,
                                     const Eigen::VectorXd&) const {
    return turns;
  }
  /// Places rows where the machine as believed stands (`at`), and takes from `model`
  /// what is in their places then. What it returns `at` may point into.
  virtual std::shared_ptr<const void> Place(const Observed&,
                                            std::vector<At>*,
                                            std::vector<Injected>*) const {
    return nullptr;
  }

  /// @name Causes
  /// Of motors whose axis is another's: whose steps it counts by.
  virtual int AxisOfMotor(const Drive& drive) const { return drive.index; }
  /// In place of all forms that a table may have; empty: those.
  virtual std::vector<ChannelAndWord> FreeForms() const { return {}; }
  /// What shows in so many rows or fewer cannot be told from outliers.
  virtual int FewRows() const { return 3; }
  /// What no row can show, and why.
  virtual void AddUnseen(const Observed&,
                         const std::vector<Candidate>&,
                         Diagnosis*) const {}
  /// A pose anywhere in its work space, told with these settings, in place of `at`'s;
  /// what it returns `at` may point into.
  virtual std::shared_ptr<const void> PoseAnywhere(const Observed& observed,
                                                   const Settings& settings,
                                                   Rng* rng,
                                                   At* at) const;
  /// Rows measured again.
  virtual RowTable Performed(const Observed& observed, const ReplayedTwin& twin) const;

  /// @name Noise of counting in whole steps [mm]
  /// Of one reading, where motors are no axes.
  virtual double Rounding_mm(const Observed&, Eigen::Index) const { return 0; }
  /// Whether touches end on whole steps of Z, and what repeats leave at least.
  virtual std::optional<double> LeastCounted_mm() const { return std::nullopt; }

  /// @name Whether rows are of this machine
  virtual std::string_view FewestRowsHint() const;
  virtual bool CanStandAt(const Machine& machine, int axis, double position_mm) const;
  virtual void DoubtTravel(const RowTable& table,
                           const Machine& machine,
                           std::vector<Doubt>* doubts) const;

  /// @name Its correction
  /// Throws InputError where the controller has no settings for such a machine.
  virtual void RequireSettings(ControllerKind) const {}
  virtual std::vector<CorrectionFile> Correction(ControllerKind controller,
                                                 const Diagnosis& diagnosis,
                                                 const Observed& observed,
                                                 const std::string& name) const;
};

/// The kind of that machine; a gantry's where the list has none of its name.
const DiagnosedKind& DiagnosedAs(const Machine& machine);

}  // namespace caltwin
