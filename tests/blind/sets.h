#pragma once

#include <cstdint>
#include <vector>

#include "tests/blind/case.h"

namespace blind {

/// How many cases of each kind.
struct SetSizes {
  int nulls = 60, singles = 74, pairs = 20, outside = 16;
  /// Single causes in a model of MuJoCo, beside all others.
  int physics = 10;
  /// Single causes measured on, in a model of MuJoCo, until one is left.
  int loops = 10;
  /// Half of the singles and two of three nulls and pairs are performed by MuJoCo.
  bool half_physics = false;
  /// Singles: every cause in turn at two sizes; else sizes from 0.5 to 20 sigma.
  bool two_sizes = true;
};

/// The cases of a set. The first half comes from `seed`, the second from `date_seed`,
/// so that nothing can be tuned to it.
std::vector<CaseRequest> MakeSet(const SetSizes& sizes,
                                 std::uint64_t seed,
                                 std::uint64_t date_seed);

/// The command that makes the case again.
std::string RerunCommand(const CaseRequest& request);

}  // namespace blind
