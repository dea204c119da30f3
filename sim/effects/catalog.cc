#include "sim/effects/catalog.h"

#include <algorithm>
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

template void AddErrors<double>(int, const Asked<double>&, Errors<double>*);

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

bool HasAxis(const Effect& effect, std::string_view axis) {
  const auto same = [&](std::string_view word) {
    return word == axis || (word == kAnyAxis && !axis.empty());
  };
  return std::ranges::any_of(effect.axes, same) ||
         std::ranges::any_of(effect.aliases, same);
}

std::string AxisOf(const Effect& effect, std::string_view written) {
  const bool is_alias =
      std::ranges::find(effect.aliases, written) != effect.aliases.end();
  return std::string(is_alias ? effect.axes[0] : written);
}

}  // namespace caltwin
