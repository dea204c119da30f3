#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace blind {

/// Random numbers of the truth code's own (xoshiro256**, seeded by splitmix64), the
/// same on every machine. Each use takes its own stream, so that what one part draws
/// does not shift another's.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);

  double Uniform();  ///< In [0, 1).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  double LogUniform(double low, double high);
  double Normal();
  int Index(int count);  ///< 0 .. count - 1.
  bool Chance(double probability) { return Uniform() < probability; }
  double Sign() { return Chance(0.5) ? 1.0 : -1.0; }
  template <typename T>
  const T& Pick(const std::vector<T>& of) {
    return of[static_cast<std::size_t>(Index(static_cast<int>(of.size())))];
  }
  template <typename T>
  void Shuffle(std::vector<T>* items) {
    for (int i = static_cast<int>(items->size()) - 1; i > 0; --i) {
      const int j = Index(i + 1);
      std::swap((*items)[static_cast<std::size_t>(i)],
                (*items)[static_cast<std::size_t>(j)]);
    }
  }

 private:
  std::uint64_t Next();
  std::array<std::uint64_t, 4> state_{};
};

}  // namespace blind
