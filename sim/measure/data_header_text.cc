#include <fmt/format.h>

#include "sim/base/text_file.h"
#include "sim/base/yaml_check.h"
#include "sim/measure/data_header.h"

namespace caltwin {
namespace {

/// Numbers in the shortest form that reads back to the same bits.
std::string Text(double value) {
  return fmt::format("{}", value);
}

void EmitOptional(const char* key,
                  const std::optional<double>& value,
                  YAML::Emitter* out) {
  if (value) *out << YAML::Key << key << YAML::Value << Text(*value);
}

void EmitByMotor(const char* key,
                 const std::map<std::string, double>& numbers,
                 YAML::Emitter* out) {
  if (numbers.empty()) return;
  *out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginMap;
  for (const auto& [motor, number] : numbers) {
    *out << YAML::Key << motor << YAML::Value << Text(number);
  }
  *out << YAML::EndMap;
}

void EmitOne(const SettingsInForce& settings, YAML::Emitter* out) {
  EmitByMotor("steps_per_mm", settings.steps_per_mm, out);
  EmitByMotor("backlash_mm", settings.backlash_mm, out);
  EmitByMotor("probe_deflection_mm", settings.probe_deflection_mm, out);
  EmitOptional("tip_radius_mm", settings.tip_radius_mm, out);
  EmitOptional("switch_offset_mm", settings.switch_offset_mm, out);
}

void EmitOne(const Instrument& instrument, YAML::Emitter* out) {
  *out << YAML::Key << "kind" << YAML::Value << instrument.kind;
  EmitOptional("sigma_um", instrument.sigma_um, out);
  EmitOptional("resolution_um", instrument.resolution_um, out);
  EmitOptional("u_um", instrument.u_um, out);
}

// A list or a mapping was kept as its own YAML; a text that only looks like one is
// text.
void EmitOption(const std::string& option, YAML::Emitter* out) {
  if (option.starts_with('[') || option.starts_with('{')) {
    try {
      CheckYamlEvents(option, "");
      *out << YAML::Load(option);
      return;
    } catch (const YAML::Exception&) {  // Text.
    } catch (const InputError&) {
    }
  }
  *out << option;
}

void EmitOne(const CampaignHeader& campaign, YAML::Emitter* out) {
  if (!campaign.instrument.empty()) {
    *out << YAML::Key << "instrument" << YAML::Value << campaign.instrument;
  }
  if (campaign.plan.empty()) return;
  *out << YAML::Key << "plan" << YAML::Value << YAML::BeginMap;
  *out << YAML::Key << campaign.plan << YAML::Value << YAML::Flow << YAML::BeginMap;
  for (const auto& [key, option] : campaign.options) {
    *out << YAML::Key << key << YAML::Value;
    EmitOption(option, out);
  }
  *out << YAML::EndMap << YAML::EndMap;
}

void EmitOne(const CertifiedArtefact& artefact, YAML::Emitter* out) {
  *out << YAML::Key << "type" << YAML::Value << artefact.type;
  if (!artefact.sizes_mm.empty()) {
    *out << YAML::Key << "sizes_mm" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double size_mm : artefact.sizes_mm) *out << Text(size_mm);
    *out << YAML::EndSeq;
  }
  EmitOptional("u_um", artefact.u_um, out);
  EmitOptional("expansion_per_k", artefact.expansion_per_k, out);
}

void EmitOne(const Transmission& transmission, YAML::Emitter* out) {
  EmitOptional("lead_mm", transmission.lead_mm, out);
  EmitOptional("pulley_mm_per_rev", transmission.pulley_mm_per_rev, out);
  EmitOptional("full_steps_per_mm", transmission.full_steps_per_mm, out);
}

template <typename Entry>
void EmitMap(const char* key,
             const std::map<std::string, Entry>& entries,
             YAML::Emitter* out) {
  if (entries.empty()) return;
  *out << YAML::Key << key << YAML::Value << YAML::BeginMap;
  for (const auto& [id, entry] : entries) {
    *out << YAML::Key << id << YAML::Value << YAML::BeginMap;
    EmitOne(entry, out);
    *out << YAML::EndMap;
  }
  *out << YAML::EndMap;
}

}  // namespace

std::string DataHeaderText(const DataHeader& header) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "format" << YAML::Value << 1;
  if (!header.machine.empty()) {
    out << YAML::Key << "machine" << YAML::Value << header.machine;
  }
  EmitMap("settings", header.settings, &out);
  EmitMap("instruments", header.instruments, &out);
  EmitMap("campaigns", header.campaigns, &out);
  EmitMap("artefacts", header.artefacts, &out);
  EmitMap("transmission", header.transmission, &out);
  EmitOptional("tip_radius_mm", header.tip_radius_mm, &out);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

void WriteDataHeader(const std::filesystem::path& file, const DataHeader& header) {
  WriteTextFile(file, DataHeaderText(header));
}

}  // namespace caltwin
