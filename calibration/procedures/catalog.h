#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/loop/bench.h"
#include "calibration/loop/outcome.h"
#include "sim/base/yaml.h"

namespace caltwin {

/// A procedure made ready by its options: run it on a bench.
using PreparedProcedure = std::function<ProcedureResult(Bench* bench)>;

/// @name Kinds of machines that a procedure is for
inline constexpr std::array<std::string_view, 1> kOwnDrives = {"cartesian"};
/// Of one that asks nothing of any drive alone.
inline constexpr std::array<std::string_view, 2> kAnyDrives = {"cartesian", "corexy"};

/// One published or own calibration procedure.
struct Procedure {
  std::string_view name;       ///< Its id in scenarios: "next_dual_dimension".
  std::string_view about;      ///< One sentence.
  std::string_view source;     ///< Where it was published.
  std::string_view published;  ///< What the text says, with its formula.
  std::string_view physics;    ///< What is wrong with that, if anything, and the cure.
  bool has_variants;           ///< as_published and corrected differ.
  /// Reads the options of a scenario step ({axis: x, variant: corrected, ...})
  /// strictly, adding faults; the result must not be called where there were any.
  PreparedProcedure (*prepare)(YamlMap options);
  std::span<const std::string_view> kinds = kOwnDrives;  ///< Machines that it is for.
};

/// Every procedure there is, in the order help lists them.
std::span<const Procedure> AllProcedures();
/// By id; null where there is none.
const Procedure* FindProcedure(std::string_view name);

}  // namespace caltwin
