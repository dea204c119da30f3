#include "sim/base/normals.h"

#include <array>
#include <cmath>

namespace caltwin {
namespace {

constexpr std::size_t kLayers = 128;
constexpr double kTail = 3.442619855899;       // Where the last layer ends.
constexpr double kArea = 9.91256303526217e-3;  // Of each layer.

struct Ziggurat {
  std::array<double, kLayers + 1> edge{};
  std::array<double, kLayers> ratio{};  ///< Of the next layer's edge to this one's.

  Ziggurat() {
    double density = std::exp(-0.5 * kTail * kTail);
    edge[0] = kArea / density;
    edge[1] = kTail;
    edge[kLayers] = 0;
    for (std::size_t i = 2; i < kLayers; ++i) {
      edge[i] = std::sqrt(-2 * std::log(kArea / edge[i - 1] + density));
      density = std::exp(-0.5 * edge[i] * edge[i]);
    }
    for (std::size_t i = 0; i < kLayers; ++i) ratio[i] = edge[i + 1] / edge[i];
  }
};

// Marsaglia's: beyond the last layer.
double TailNormal(Rng* rng) {
  for (;;) {
    const double beyond = -std::log(rng->Uniform()) / kTail;
    const double height = -std::log(rng->Uniform());
    if (2 * height >= beyond * beyond) return kTail + beyond;
  }
}

}  // namespace

double QuickNormal(Rng* rng) {
  static const Ziggurat kZiggurat;
  for (;;) {
    const std::uint64_t bits = rng->Next();
    const std::size_t layer = bits & (kLayers - 1);
    // The upper 53 bits, as -1 .. 1; the layer's are not among them.
    const double u = 2 * ((static_cast<double>(bits >> 11) + 0.5) * 0x1.0p-53) - 1;
    const double x = u * kZiggurat.edge[layer];
    if (std::abs(u) < kZiggurat.ratio[layer]) return x;
    if (layer == 0) return u < 0 ? -TailNormal(rng) : TailNormal(rng);
    const double outer = kZiggurat.edge[layer], inner = kZiggurat.edge[layer + 1];
    const double low = std::exp(-0.5 * (outer * outer - x * x));
    const double high = std::exp(-0.5 * (inner * inner - x * x));
    if (high + rng->Uniform() * (low - high) < 1) return x;
  }
}

}  // namespace caltwin
