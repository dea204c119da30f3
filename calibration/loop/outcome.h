#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibration/estimate/correlation.h"
#include "calibration/estimate/uncertain.h"
#include "calibration/loop/message.h"
#include "sim/base/yaml.h"
#include "sim/link/link.h"

namespace caltwin {

/// What a procedure says of one quantity. Names as in CONTRACT: `cause.axis`, followed
/// by
/// `.parameter` where the cause has several ("bed_tilt.slope_x_mrad").
struct Estimate {
  std::string name{};
  std::string unit{};
  double value = 0;
  double sd = 0;              ///< U / 1.96, steps and noise included (Uncertain).
  bool identifiable = false;  ///< false: value and sd mean nothing.
  bool is_setting = false;  ///< What the firmware now believes; else it has no setting.
  std::vector<Contribution> budget{};  ///< What sd is made of; empty: not taken apart.
};

enum class Verdict { kMeasured, kApplied, kRefused, kRolledBack };
std::string ToString(Verdict verdict);  ///< measured, applied, refused, rolled_back

/// One thing a procedure did to one quantity, in order.
struct Step {
  std::string procedure{};
  std::string variant{};  ///< as_published | corrected
  int iteration = 1;
  std::string name{};  ///< The quantity: "steps_per_mm.x".
  std::string unit{};  ///< Of before and after; empty: its name has it.
  double before = 0;
  bool has_before = true;  ///< false: nobody knew it before.
  double after = 0;        ///< Equal to before where nothing was applied.
  Verdict verdict = Verdict::kMeasured;
  std::string message{};  ///< One sentence for a person.
};

/// A combination the measurements cannot tell, in words and as a unit vector.
struct Observability {
  std::string statement{};
  std::map<std::string, double> blind_direction{};  ///< By parameter name, in mm.
};

/// How a procedure, or a list of them, ended, as far as the engine can know; whether it
/// was right is for the one who knows the truth (scenarios/verdict).
enum class Ending {
  kDone,
  kUnconverged,  ///< Done, and it says itself that it did not succeed.
  kNoTrigger,    ///< A probe move found nothing.
  kCollision,    ///< The stylus was bent.
  kAlarm,        ///< The machine stopped for another reason.
  kReadsZero,    ///< The result is zero within its own uncertainty, by construction.
  kConfounded,   ///< It said that it cannot tell.
  kRefused,      ///< Nothing was applied: limit, operator, or a check before.
  kLinkLost
};
/// How a run ends on that fault, by its kind and its words (Classified). A machine that
/// fell silent is taken for one that is gone.
Ending EndingOfFault(const MachineFault& fault);

struct ProcedureResult {
  Ending ending = Ending::kDone;
  std::string fault{};  ///< The machine's words where it stopped the run.
  std::vector<Step> steps{};
  std::vector<Estimate> estimates{};
  std::vector<Correlations> correlations{};  ///< Of what was fitted together.
  std::vector<Observability> observability{};
  std::vector<Message> messages{};  ///< Warnings and remedies, for a person.
  int touches = 0;
  /// What else it found: figures of scenarios ("predicted_factor", "alerts"), and what
  /// only the one who leads the procedures asks for ("rounds_steeper").
  std::map<std::string, double> figures{};
};

}  // namespace caltwin
