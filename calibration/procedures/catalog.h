#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/loop/bench.h"
#include "calibration/loop/outcome.h"
#include "sim/base/yaml.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A procedure made ready by its options: run it on a bench.
using PreparedProcedure = std::function<ProcedureResult(Bench* bench)>;

/// What a procedure asks of the drives of a machine that is led like a gantry: an axis
/// of its own for each, nothing, or that some of them move the axes together.
enum class DrivesAsked { kOwn, kAny, kCoupled };

/// One published or own calibration procedure.
struct Procedure {
  std::string_view name{};       ///< Its id in scenarios: "next_dual_dimension".
  std::string_view about{};      ///< What it does; of a kind's own, its options too.
  std::string_view source{};     ///< Where it was published.
  std::string_view published{};  ///< What the text says, with its formula.
  std::string_view physics{};  ///< What is wrong with that, if anything, and the cure.
  bool has_variants = false;   ///< as_published and corrected differ.
  bool takes_axes = false;     ///< `axes: [x, y]`, not `axis: x`.
  /// Reads the options of a scenario step ({axis: x, variant: corrected, ...})
  /// strictly, adding faults; the result must not be called where there were any.
  /// `drawing`: the machine that it is for.
  PreparedProcedure (*prepare)(YamlMap options, const Machine& drawing) = nullptr;
  DrivesAsked drives = DrivesAsked::kOwn;
  /// The kind of machine whose own it is, and that alone: "delta". Empty: machines
  /// that are led like a gantry.
  std::string_view kind{};
};

using Procedures = std::vector<const Procedure*>;

/// Every procedure there is, in the order help lists them.
const Procedures& AllProcedures();
/// Those of machines that are led like a gantry, for that machine's drives.
Procedures ProceduresFor(const MachineKind& kind);
/// Those that only the kind of that name has: delta, triple_z, z_station, motor_stage;
/// "": those of machines that are led like a gantry.
Procedures ProceduresOf(std::string_view kind);
/// By id; null where there is none.
const Procedure* FindProcedure(std::string_view name, const Procedures& among);

}  // namespace caltwin
