#include "sim/measure/data_header.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/measure/plan_kinds.h"

namespace caltwin {
namespace {

const std::vector<std::string> kMotors = {
    "x", "y", "z", "a", "b", "c", "z1", "z2", "z3"};
const std::vector<std::string> kInstrumentKinds = {"laser",
                                                   "scale",
                                                   "dial",
                                                   "calliper",
                                                   "probe",
                                                   "ballbar",
                                                   "level",
                                                   "cmm",
                                                   "camera",
                                                   "height_gauge",
                                                   "indicator",
                                                   "feeler"};
std::vector<std::string> PlanWords() {
  std::vector<std::string> words;
  for (const CampaignKind& kind : AllCampaignKinds()) words.emplace_back(kind.id);
  return words;
}

/// How many certified sizes an artefact of this type may have.
struct SizeCount {
  const char* type;
  std::vector<std::size_t> counts;
  const char* words;
};
const std::vector<SizeCount> kArtefactSizes = {
    {"block", {3}, "[x y z]"},
    {"block123", {0, 1, 3}, "[thickness], [x y z] or []"},
    {"web", {1}, "[thickness]"},
    {"ledge", {1}, "[thickness]"},
    {"ring", {1}, "[diameter]"},
    {"pocket", {1}, "[width]"},
    {"plate", {2}, "[x y]"},
    {"straight_edge", {1}, "[length]"},
    {"square", {1}, "[length]"},
    {"ballbar", {1}, "[length]"},
    {"post", {0}, "[]"},
    {"datums", {0}, "[]"},
};

class HeaderReader {
 public:
  explicit HeaderReader(DataHeader* header) : header_(header) {}

  void Read(YamlMap* map) {
    map->IntegerOr("format", 1, 1, 1);
    header_->machine = map->TextOr("machine", "");
    if (const auto instruments = map->Optional("instruments")) {
      header_->instruments = ReadInstruments(instruments->Map());
      for (const auto& [id, instrument] : header_->instruments) {
        RemarkUnless(kInstrumentKinds,
                     instrument.kind,
                     fmt::format("instrument '{}': the kind", id));
      }
    }
    ForEach(map, "settings", [this](const std::string& id, YamlMap entry) {
      header_->settings[id] = ReadSettingsInForce(&entry);
    });
    ForEach(map, "campaigns", [this](const std::string& id, YamlMap entry) {
      header_->campaigns[id] = ReadCampaign(id, &entry);
    });
    ForEach(map, "artefacts", [this](const std::string& id, YamlMap entry) {
      header_->artefacts[id] = ReadArtefact(id, &entry);
    });
    ForEach(map, "transmission", [this](const std::string& id, YamlMap entry) {
      CheckMotor(id, entry);
      header_->transmission[id] = ReadTransmission(&entry);
    });
    header_->tip_radius_mm = OptionalNumber(map, "tip_radius_mm", {0, 50});
    map->NoMoreKeys();
  }

 private:
  template <typename ReadEntry>
  static void ForEach(YamlMap* map, const std::string& key, ReadEntry read) {
    const auto value = map->Optional(key);
    if (!value) return;
    for (const auto& [id, entry] : value->Map().Entries()) read(id, entry.Map());
  }

  static std::optional<double> OptionalNumber(YamlMap* map,
                                              const std::string& key,
                                              Bounds bounds) {
    const auto value = map->Optional(key);
    if (!value) return std::nullopt;
    return value->Number(bounds);
  }

  void RemarkUnless(const std::vector<std::string>& known,
                    const std::string& word,
                    const std::string& what) {
    if (std::ranges::find(known, word) != known.end()) return;
    const std::string nearest = NearestWord(word, known);
    header_->remarks.push_back(fmt::format(
        "{} '{}' is not known{}",
        what,
        word,
        nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest)));
  }

  static void CheckMotor(const std::string& id, const YamlMap& entry) {
    if (std::ranges::find(kMotors, id) != kMotors.end()) return;
    entry.faults()->Add(entry.place(),
                        fmt::format("{} is no axis, tower or screw", entry.path()),
                        fmt::format("it may be: {}", fmt::join(kMotors, ", ")));
  }

  static std::map<std::string, double> ByMotor(YamlMap* map,
                                               const std::string& key,
                                               Bounds bounds) {
    std::map<std::string, double> numbers;
    const auto value = map->Optional(key);
    if (!value) return numbers;
    YamlMap by_motor = value->Map();
    for (const std::string& motor : kMotors) {
      if (const auto number = by_motor.Optional(motor)) {
        numbers[motor] = number->Number(bounds);
      }
    }
    by_motor.NoMoreKeys();
    return numbers;
  }

  static SettingsInForce ReadSettingsInForce(YamlMap* map) {
    SettingsInForce settings;
    settings.steps_per_mm =
        ByMotor(map, "steps_per_mm", SettingsInForce::kSteps_per_mm);
    settings.backlash_mm = ByMotor(map, "backlash_mm", SettingsInForce::kBacklash_mm);
    settings.probe_deflection_mm = ByMotor(map, "probe_deflection_mm", {-10, 10});
    settings.tip_radius_mm = OptionalNumber(map, "tip_radius_mm", {0, 50});
    settings.switch_offset_mm = OptionalNumber(map, "switch_offset_mm", {-10, 10});
    map->NoMoreKeys();
    return settings;
  }

  CampaignHeader ReadCampaign(const std::string& id, YamlMap* map) {
    CampaignHeader campaign;
    campaign.instrument = map->TextOr("instrument", "");
    if (const auto plan = map->Optional("plan")) ReadPlan(id, *plan, &campaign);
    map->NoMoreKeys();
    return campaign;
  }

  void ReadPlan(const std::string& id,
                const YamlValue& plan,
                CampaignHeader* campaign) {
    const auto kinds = plan.Map().Entries();
    if (kinds.size() != 1) {
      plan.Fail("does not name one kind of plan", "for example {iso230: {axis: x}}");
      return;
    }
    campaign->plan = kinds[0].first;
    RemarkUnless(
        PlanWords(), campaign->plan, fmt::format("campaign '{}': the plan", id));
    if (kinds[0].second.is_null()) return;
    for (const auto& [key, option] : kinds[0].second.Map().Entries()) {
      campaign->options[key] = option.AsWritten();
    }
  }

  CertifiedArtefact ReadArtefact(const std::string& id, YamlMap* map) {
    CertifiedArtefact artefact;
    artefact.type = map->TextOr("type", id);
    const auto known = std::ranges::find_if(
        kArtefactSizes, [&](const SizeCount& s) { return s.type == artefact.type; });
    if (known == kArtefactSizes.end()) {
      std::vector<std::string> types;
      for (const SizeCount& size : kArtefactSizes) types.emplace_back(size.type);
      RemarkUnless(types, artefact.type, fmt::format("artefact '{}': the type", id));
    }
    if (const auto sizes = map->Optional("sizes_mm")) {
      for (const YamlValue& size : sizes->List()) {
        artefact.sizes_mm.push_back(size.Number({1e-3, 1e5}));
      }
      if (known != kArtefactSizes.end() &&
          std::ranges::find(known->counts, artefact.sizes_mm.size()) ==
              known->counts.end()) {
        sizes->Fail(fmt::format("has {} sizes", artefact.sizes_mm.size()),
                    fmt::format("{} has {}", artefact.type, known->words));
      }
    }
    artefact.u_um = map->NumberOr("u_um", 0, {0, 1e4});
    artefact.expansion_per_k = OptionalNumber(map, "expansion_per_k", {-1e-4, 1e-3});
    map->NoMoreKeys();
    return artefact;
  }

  static Transmission ReadTransmission(YamlMap* map) {
    Transmission transmission;
    transmission.lead_mm = OptionalNumber(map, "lead_mm", {1e-3, 1e4});
    transmission.pulley_mm_per_rev =
        OptionalNumber(map, "pulley_mm_per_rev", {1e-3, 1e4});
    transmission.full_steps_per_mm =
        OptionalNumber(map, "full_steps_per_mm", {1e-3, 1e6});
    if (transmission.lead_mm && transmission.pulley_mm_per_rev) {
      map->faults()->Add(map->place(),
                         map->path() + " has both lead_mm and pulley_mm_per_rev",
                         "a screw has a lead, a belt a pulley: keep one");
    }
    map->NoMoreKeys();
    return transmission;
  }

  DataHeader* header_;
};

DataHeader Parse(YamlMap map, const Faults& faults) {
  DataHeader header;
  HeaderReader(&header).Read(&map);
  faults.ThrowIfAny();
  return header;
}

}  // namespace

DataHeader ParseDataHeader(const std::string& text, const std::string& name) {
  Faults faults;
  return Parse(ReadYamlText(text, name, &faults), faults);
}

DataHeader ReadDataHeader(const std::filesystem::path& file) {
  Faults faults;
  return Parse(ReadYamlFile(file, &faults), faults);
}

DataHeader HeaderOf(const std::filesystem::path& rows_file) {
  const std::filesystem::path file =
      std::filesystem::path(rows_file).replace_extension(".yaml");
  std::error_code error;
  if (file == rows_file || !std::filesystem::exists(file, error)) return {};
  return ReadDataHeader(file);
}

std::vector<std::string> Unexplained(const RowTable& table, const DataHeader& header) {
  std::set<std::string> remarks;
  const auto explain = [&](const auto& known, const std::string& id, const char* what) {
    if (!id.empty() && !known.empty() && !known.contains(id)) {
      remarks.insert(fmt::format("the header does not explain {} '{}'", what, id));
    }
  };
  for (const Row& row : table.rows) {
    explain(header.campaigns, row.campaign, "the campaign");
    explain(header.settings, row.settings, "the settings");
    explain(
        header.artefacts, row.feature.substr(0, row.feature.find('.')), "the artefact");
  }
  for (const auto& [id, campaign] : header.campaigns) {
    explain(header.instruments, campaign.instrument, "the instrument");
  }
  return {remarks.begin(), remarks.end()};
}

}  // namespace caltwin
