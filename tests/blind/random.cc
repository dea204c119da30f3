#include "tests/blind/random.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace blind {
namespace {

std::uint64_t SplitMix(std::uint64_t* state) {
  std::uint64_t z = (*state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::string_view stream) {
  std::uint64_t mixed = seed;
  for (const char letter : stream) {
    mixed = SplitMix(&mixed) ^ static_cast<unsigned char>(letter);
  }
  for (std::uint64_t& word : state_) word = SplitMix(&mixed);
}

std::uint64_t Random::Next() {
  const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::Uniform() {
  return static_cast<double>(Next() >> 11) * 0x1.0p-53;
}

double Random::LogUniform(double low, double high) {
  return low * std::pow(high / low, Uniform());
}

double Random::Normal() {
  const double u = 1.0 - Uniform();
  const double angle_rad = 2 * std::numbers::pi * Uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(angle_rad);
}

int Random::Index(int count) {
  return static_cast<int>(Uniform() * count);
}

}  // namespace blind
