#include "scenarios/varied.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr std::string_view kInstruments = "instruments.";
constexpr std::string_view kBuilt = "built.";
constexpr const char* kHysteresis = "built.probe.hysteresis_mm";
constexpr Bounds kUm{0, 1e5};
constexpr Bounds kHysteresisBounds_mm{0, 2};
constexpr double kBelowPretravel = 0.95;  // Else the switch would never open.

struct InstrumentKey {
  std::string_view key;
  double Instrument::*value;
};
constexpr std::array kInstrumentKeys = {
    InstrumentKey{"sigma_um", &Instrument::sigma_um},
    InstrumentKey{"resolution_um", &Instrument::resolution_um},
    InstrumentKey{"u_um", &Instrument::u_um}};

// "instruments.ID.KEY" in two; an id may hold dots, a key does not.
struct InstrumentName {
  std::string id{};
  const InstrumentKey* key = nullptr;
};

InstrumentName Parted(const std::string& name) {
  const std::string rest = name.substr(kInstruments.size());
  const std::size_t dot = rest.rfind('.');
  if (dot == std::string::npos) return {};
  const std::string_view word = std::string_view(rest).substr(dot + 1);
  const auto* const key = std::ranges::find(kInstrumentKeys, word, &InstrumentKey::key);
  return {.id = rest.substr(0, dot),
          .key = key == kInstrumentKeys.end() ? nullptr : key};
}

double Drawn(const VariedNumber& number, std::uint64_t seed, std::uint64_t sample) {
  Rng rng(seed, sample, number.name);
  return Draw(number.value, &rng);
}

std::string KnownNames(const Instruments& instruments) {
  std::vector<std::string> names;
  for (const auto& [id, instrument] : instruments) {
    names.push_back(fmt::format("instruments.{}.sigma_um", id));
  }
  names.emplace_back(kHysteresis);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

bool IsVariedNumber(const std::string& name) {
  return name.starts_with(kInstruments) || name.starts_with(kBuilt);
}

VariedNumber ReadVariedNumber(const std::string& name,
                              const YamlValue& value,
                              const Instruments& instruments) {
  const bool is_instrument = name.starts_with(kInstruments);
  const InstrumentName parted = is_instrument ? Parted(name) : InstrumentName{};
  const bool is_known = is_instrument
                            ? parted.key != nullptr && instruments.contains(parted.id)
                            : name == kHysteresis;
  if (!is_known) {
    value.Fail("names no number of this scenario's instruments or machine",
               "there are " + KnownNames(instruments));
    return {};
  }
  return {
      .name = name,
      .value = value.NumberOrDistribution(is_instrument ? kUm : kHysteresisBounds_mm)};
}

Instruments DrawInstruments(Instruments instruments,
                            const std::vector<VariedNumber>& varied,
                            std::uint64_t seed,
                            std::uint64_t sample) {
  for (const VariedNumber& number : varied) {
    if (!number.name.starts_with(kInstruments)) continue;
    const InstrumentName parted = Parted(number.name);
    instruments.at(parted.id).*parted.key->value =
        std::clamp(Drawn(number, seed, sample), kUm.min, kUm.max);
  }
  return instruments;
}

std::vector<std::pair<std::string, double>> DrawnNumbers(
    const Machine& drawing,
    const std::vector<VariedNumber>& varied,
    std::uint64_t seed,
    std::uint64_t sample) {
  std::vector<std::pair<std::string, double>> drawn;
  for (const VariedNumber& number : varied) {
    const double value =
        number.name == kHysteresis
            ? DrawBuilt(drawing, {number}, seed, sample).probe.hysteresis_mm
            : std::clamp(Drawn(number, seed, sample), kUm.min, kUm.max);
    drawn.emplace_back(number.name, value);
  }
  return drawn;
}

Machine DrawBuilt(Machine drawing,
                  const std::vector<VariedNumber>& varied,
                  std::uint64_t seed,
                  std::uint64_t sample) {
  for (const VariedNumber& number : varied) {
    if (number.name != kHysteresis) continue;
    drawing.probe.hysteresis_mm =
        std::clamp(Drawn(number, seed, sample),
                   kHysteresisBounds_mm.min,
                   kBelowPretravel * drawing.probe.pretravel_mm);
  }
  return drawing;
}

}  // namespace caltwin
