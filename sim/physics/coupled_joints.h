#pragma once

#include <array>
#include <span>
#include <vector>

#include <mujoco/mujoco.h>

namespace caltwin {

/// The joint equalities of a model, whoever wrote them: an effect's act or a person who
/// edited model.xml. Each says where one sliding or hinged joint stands, by a
/// polynomial of another:
///
///   q1 - q1_0 = a0 + a1 d + a2 d^2 + a3 d^3 + a4 d^4,  d = q2 - q2_0
///
/// While the machine is stepped the solver keeps them. When it is placed somewhere they
/// must be set, or the solver would take up the difference with a blow.
class CoupledJoints {
 public:
  /// @param placed  joints that stand where they are put: never moved by `Follow`
  CoupledJoints(const mjModel* model, std::span<const int> placed);

  /// Puts every joint that an active equality ties to a placed one, directly or through
  /// others, where that equality wants it, and gives it that speed.
  void Follow(const mjModel* model, mjData* data) const;

 private:
  struct Tie {
    int equality = 0;
    int follower = 0;         ///< Joint that is moved.
    int leader = -1;          ///< Joint that says where; -1: a constant.
    bool is_inverse = false;  ///< The equality gives the leader from the follower.
  };
  std::vector<Tie> ties_{};  ///< In an order in which each leader is settled before.
};

}  // namespace caltwin
