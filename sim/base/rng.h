#pragma once

#include <cstdint>
#include <string_view>

namespace caltwin {

/// A stream of random numbers that belongs to one user of chance.
///
/// `Rng(seed, sample, "trigger_scatter")` gives the same numbers whatever else draws,
/// in any order and on any thread: the three are hashed to the start of an independent
/// stream (splitmix64). Distributions are our own, so that the same binary gives the
/// same bytes with any standard library.
class Rng {
 public:
  Rng(std::uint64_t seed, std::uint64_t sample, std::string_view user);

  std::uint64_t Next();
  double Uniform();  ///< In (0, 1): neither end ever comes.
  double Normal();   ///< Mean 0, standard deviation 1 (Box-Muller, one of the pair).

 private:
  std::uint64_t state_;
};

}  // namespace caltwin
