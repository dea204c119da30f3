#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "scenarios/expectation.h"
#include "scenarios/external.h"
#include "scenarios/keys.h"
#include "scenarios/kind_trial.h"
#include "sim/base/yaml.h"
#include "sim/twin/twin.h"

namespace caltwin {

struct Scenario;

/// One entry of `calibrate:`, made ready by its options: a procedure, lines of G-code
/// sent as they are (`gcode`), somebody else's program (`external`), or something that
/// only one kind of machine has.
struct CalibrationStep {
  std::string name{};
  std::string variant{};          ///< As written; empty where the step says none.
  PreparedProcedure procedure{};  ///< What needs no more than a bench.
  std::function<ProcedureResult(KindTrial*)> perform{};  ///< In place of that.
  std::optional<ExternalCommand> external{};             ///< Likewise.
};

/// What chance is drawn from, and how true to nature a trial is.
struct Chance {
  std::uint64_t seed = 1;
  std::uint64_t sample = 0;
  Fidelity fidelity = Fidelity::kPhysics;
};

/// @name What a person does who is asked how high a nozzle stands: answers by TESTZ
/// Until a gauge of 0.1 mm fits under it, felt to 10 um (standard deviation); then that
/// much down.
inline constexpr std::string_view kFeelerGauge = "feeler_gauge";
/// The same with a sheet of paper, whose thickness most leave.
inline constexpr std::string_view kPaperTest = "paper_test";

/// What a scenario has of its own by the kind of its machine: how its keys are read,
/// what it calls effects and procedures, and how a trial of it begins. One class a kind
/// (scenarios/kinds); everything else in scenarios is the same for all.
class KindScenario {
 public:
  virtual ~KindScenario() = default;
  virtual std::unique_ptr<KindScenario> Clone() const = 0;

  /// Reads `effects`, `settings`, `instruments` and what else this kind alone knows:
  /// all but `calibrate` and `expect`.
  virtual void ReadKeys(YamlMap* map, Scenario* scenario) = 0;
  /// The procedures that it may be calibrated by.
  virtual Procedures KnownProcedures() const = 0;
  /// Whose its procedures and effects are, in messages: "a delta".
  virtual std::string_view Owner() const = 0;
  /// Steps that are no procedures, what an operator does or a power cut, and what they
  /// do.
  virtual std::vector<Word> ScenarioSteps() const { return {}; }
  /// One of those.
  virtual CalibrationStep ReadScenarioStep(const std::string& name,
                                           YamlMap options) const;
  /// Adds the fault that there is no such step, and whose it is.
  void RefuseStep(const std::string& name, const YamlValue& options) const;

  /// Names of procedures and scenario steps, without `gcode` and `external`.
  std::vector<std::string> StepNames() const;
  /// One entry of `calibrate:`, of one of those names.
  /// @param usual_axis  of a procedure that cannot do without one and names none; may
  ///   be empty
  CalibrationStep ReadStep(const std::string& name,
                           const YamlValue& options,
                           const Machine& machine,
                           const std::string& usual_axis) const;
  virtual Expectable CanExpect() const = 0;

  /// Words that only such scenarios have: effects that are not the catalogue's, keys.
  virtual std::span<const Word> OwnEffects() const { return {}; }
  virtual std::span<const Word> OwnKeys() const { return {}; }

  /// @name Studies
  /// Every effect that such a machine may have.
  virtual std::vector<std::string> EffectNames() const = 0;
  /// `vary: {EFFECT.PARAMETER: value}` in place of what the scenario says of it.
  virtual void Vary(const std::string& effect,
                    const std::string& parameter,
                    const YamlValue& value,
                    Scenario* scenario) = 0;
  /// Whether settings, instruments and artefacts can be varied too.
  virtual bool VariesMore() const { return false; }
  /// What only all that is varied together shows.
  virtual void CheckVaried(const Scenario& /*scenario*/, Faults* /*faults*/) const {}

  /// The machine with its numbers drawn, its controller switched on.
  virtual std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                           const Chance& chance) const = 0;
  /// Whether Klipper's own host can drive such a machine, and how such a trial begins.
  virtual bool CanBeUnderKlipper() const { return false; }
  virtual std::unique_ptr<KindTrial> BeginUnderKlipper(const Scenario& scenario,
                                                       const Chance& chance) const;
  /// What a person can do beside it then, among the lines for the host.
  virtual std::vector<std::string> PersonsActs() const {
    return {std::string(kFeelerGauge), std::string(kPaperTest)};
  }
  /// Likewise LinuxCNC.
  virtual bool CanBeUnderLinuxCnc() const { return false; }
  virtual std::unique_ptr<KindTrial> BeginUnderLinuxCnc(const Scenario& scenario,
                                                        const Chance& chance) const;
  /// Whether trials of it have rows to record.
  virtual bool HasRows() const { return true; }
};

/// A KindScenario that is copied with what holds it.
class AnyKindScenario {
 public:
  AnyKindScenario() = default;
  explicit AnyKindScenario(std::unique_ptr<KindScenario> kind)
      : kind_(std::move(kind)) {}
  AnyKindScenario(const AnyKindScenario& other)
      : kind_(other.kind_ ? other.kind_->Clone() : nullptr) {}
  AnyKindScenario(AnyKindScenario&&) noexcept = default;
  AnyKindScenario& operator=(AnyKindScenario other) noexcept {
    kind_ = std::move(other.kind_);
    return *this;
  }
  ~AnyKindScenario() = default;

  KindScenario* operator->() { return kind_.get(); }
  const KindScenario* operator->() const { return kind_.get(); }
  const KindScenario& operator*() const { return *kind_; }
  explicit operator bool() const { return kind_ != nullptr; }
  /// What it has beside the interface; null where it is of another kind.
  template <typename Kind>
  Kind* As() const {
    return dynamic_cast<Kind*>(kind_.get());
  }

 private:
  std::unique_ptr<KindScenario> kind_{};
};

/// Every entry of a list such as `calibrate:`, read by that kind for that machine.
std::vector<CalibrationStep> ReadCalibrationSteps(const YamlValue& list,
                                                  const KindScenario& kind,
                                                  const Machine& machine,
                                                  const std::string& usual_axis = "");

}  // namespace caltwin
