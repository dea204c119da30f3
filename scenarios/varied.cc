#include "scenarios/varied.h"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::string_view kInstruments = "instruments.";
constexpr std::string_view kBuilt = "built.";
constexpr const char* kHysteresis = "built.probe.hysteresis_mm";
constexpr std::string_view kArtefacts = "built.artefacts.";
constexpr std::array<std::string_view, 3> kSizes = {
    "least_um", "middle_um", "largest_um"};
constexpr Bounds kUm{0, 1e5};
constexpr Bounds kOff_um{-1000, 1000};
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

// "built.artefacts.ID.SIZE" in two; the size as place in kSizes, none where unknown.
struct SizeName {
  std::string id{};
  std::optional<std::size_t> size{};
};

SizeName PartedSize(const std::string& name) {
  if (!name.starts_with(kArtefacts)) return {};
  const std::string rest = name.substr(kArtefacts.size());
  const std::size_t dot = rest.rfind('.');
  if (dot == std::string::npos) return {};
  const auto* const found = std::ranges::find(kSizes, rest.substr(dot + 1));
  if (found == kSizes.end()) return {};
  return {.id = rest.substr(0, dot),
          .size = static_cast<std::size_t>(found - kSizes.begin())};
}

bool HasSizes(const Artefact& artefact, const std::string& id) {
  return artefact.id == id && artefact.type == ArtefactType::kBlock123;
}

Bounds BoundsOf(const std::string& name) {
  if (name == kHysteresis) return kHysteresisBounds_mm;
  return name.starts_with(kArtefacts) ? kOff_um : kUm;
}

double Drawn(const VariedNumber& number, std::uint64_t seed, std::uint64_t sample) {
  Rng rng(seed, sample, number.name);
  return Draw(number.value, &rng);
}

double DrawnInBounds(const VariedNumber& number,
                     std::uint64_t seed,
                     std::uint64_t sample) {
  const Bounds bounds = BoundsOf(number.name);
  return std::clamp(Drawn(number, seed, sample), bounds.min, bounds.max);
}

std::string KnownNames(const Instruments& instruments,
                       const std::vector<Artefact>& artefacts) {
  std::vector<std::string> names;
  for (const auto& [id, instrument] : instruments) {
    names.push_back(fmt::format("instruments.{}.sigma_um", id));
  }
  for (const Artefact& artefact : artefacts) {
    if (!HasSizes(artefact, artefact.id)) continue;
    names.push_back(fmt::format("{}{}.{}", kArtefacts, artefact.id, kSizes.front()));
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
                              const Instruments& instruments,
                              const std::vector<Artefact>& artefacts) {
  const bool is_instrument = name.starts_with(kInstruments);
  const InstrumentName parted = is_instrument ? Parted(name) : InstrumentName{};
  const SizeName of_size = PartedSize(name);
  const bool is_size =
      of_size.size && std::ranges::any_of(artefacts, [&](const Artefact& artefact) {
        return HasSizes(artefact, of_size.id);
      });
  const bool is_known = is_instrument
                            ? parted.key != nullptr && instruments.contains(parted.id)
                            : is_size || name == kHysteresis;
  if (!is_known) {
    value.Fail("names no number of this scenario's instruments, blocks or machine",
               "there are " + KnownNames(instruments, artefacts));
    return {};
  }
  return {.name = name, .value = value.NumberOrDistribution(BoundsOf(name))};
}

Instruments DrawInstruments(Instruments instruments,
                            const std::vector<VariedNumber>& varied,
                            std::uint64_t seed,
                            std::uint64_t sample) {
  for (const VariedNumber& number : varied) {
    if (!number.name.starts_with(kInstruments)) continue;
    const InstrumentName parted = Parted(number.name);
    instruments.at(parted.id).*parted.key->value = DrawnInBounds(number, seed, sample);
  }
  return instruments;
}

std::vector<Artefact> DrawArtefacts(std::vector<Artefact> artefacts,
                                    const std::vector<VariedNumber>& varied,
                                    std::uint64_t seed,
                                    std::uint64_t sample) {
  for (const VariedNumber& number : varied) {
    const SizeName parted = PartedSize(number.name);
    if (!parted.size) continue;
    for (Artefact& artefact : artefacts) {
      if (!HasSizes(artefact, parted.id)) continue;
      artefact.off_mm[*parted.size] = MmFromUm(DrawnInBounds(number, seed, sample));
    }
  }
  return artefacts;
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
            : DrawnInBounds(number, seed, sample);
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
