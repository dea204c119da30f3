#include "sim/effects/catalog.h"

#include <array>

#include "sim/base/require.h"

namespace caltwin {
namespace {

template <std::size_t... kIndex>
constexpr std::array<const Effect*, kNumEffects> Declarations(
    std::index_sequence<kIndex...>) {
  return {&std::tuple_element_t<kIndex, EffectList>::kDeclaration...};
}

constexpr auto kDeclarations = Declarations(std::make_index_sequence<kNumEffects>{});

}  // namespace

std::span<const Effect* const> AllEffects() {
  return kDeclarations;
}

const Effect& EffectAt(int index) {
  Require(index >= 0 && index < static_cast<int>(kNumEffects), "no such effect");
  return *kDeclarations[static_cast<std::size_t>(index)];
}

std::optional<int> FindEffect(std::string_view name) {
  for (std::size_t i = 0; i < kNumEffects; ++i) {
    if (kDeclarations[i]->name == name) return static_cast<int>(i);
  }
  return std::nullopt;
}

}  // namespace caltwin
