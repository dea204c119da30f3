#pragma once

#include <limits>
#include <string>
#include <vector>

namespace caltwin {

/// One line of a GUM budget: what one input adds to the uncertainty of a result.
struct Contribution {
  std::string input{};  ///< "readings", "block sizes", "tip radius".
  double u = 0;         ///< |c| u(x): standard uncertainty, in the result's unit.
  /// Degrees of freedom of u(x): of a scatter that n repeats told n - 1; infinite of
  /// what somebody states.
  double dof = std::numeric_limits<double>::infinity();
  /// A rounding to steps, u = step / sqrt(12), that no other reading shakes; else the
  /// input counts as normal.
  bool is_rectangular = false;
  /// What is off where this input is, if others stand on it too: "tip radius", or the
  /// estimate it comes from, "backlash.x". Empty: nobody else's.
  std::string source{};
  double sense = 1;  ///< -1: the result falls as that rises.
};

/// An estimated number. Where it is not identifiable, value and sd mean nothing.
struct Uncertain {
  double value = 0;
  /// Standard uncertainty, everything stated included, such that value +- 1.96 sd hold
  /// 95 %: the standard uncertainty itself where degrees of freedom are many, U / 1.96
  /// (Expand) where they are few.
  double sd = 0;
  bool identifiable = false;
  /// What the uncertainty is made of; empty where nobody took it apart.
  std::vector<Contribution> budget{};
};

/// A number that an estimate takes from elsewhere, and how well it is known there.
struct Given {
  double value = 0;
  double sd = 0;  ///< 0: exact; infinite: not known at all. As in Uncertain.
  double dof = std::numeric_limits<double>::infinity();  ///< What sd was told by.
  std::string source{};                                  ///< As Contribution's.
  double sense = 1;                                      ///< As Contribution's.
};

/// What nobody has measured yet.
inline const Given kNotGiven{.sd = std::numeric_limits<double>::infinity()};

/// An estimate as input to the next one: what was not identifiable is not given.
inline Given AsGiven(const Uncertain& estimate) {
  if (!estimate.identifiable) return kNotGiven;
  return {.value = estimate.value, .sd = estimate.sd};
}

}  // namespace caltwin
