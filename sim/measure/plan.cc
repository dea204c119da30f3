#include "sim/measure/plan.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/require.h"
#include "sim/base/text_file.h"
#include "sim/measure/plan_kinds.h"
#include "sim/measure/plan_session.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMostCount = 100'000;
constexpr std::size_t kMostNumbers = 1000;
constexpr std::size_t kMostRows = 200'000;
constexpr double kSecondsPerMinute = 60;

CampaignOptions::Value ReadOption(const PlanOption& option, const YamlValue& value) {
  switch (option.type) {
    case OptionType::kNumber:
      return value.Number(option.bounds, option.doc);
    case OptionType::kCount:
      return static_cast<double>(value.Integer(
          static_cast<std::int64_t>(std::max(0.0, option.bounds.min)),
          static_cast<std::int64_t>(std::min(option.bounds.max, double{kMostCount}))));
    case OptionType::kFlag:
      return value.Flag();
    case OptionType::kText:
      return value.Text();
    case OptionType::kWord:
      return value.Word({option.words.begin(), option.words.end()});
    case OptionType::kNumbers:
      break;
  }
  std::vector<double> numbers;
  if (value.is_scalar()) return std::vector<double>{value.Number(option.bounds)};
  for (const YamlValue& each : value.List()) {
    numbers.push_back(each.Number(option.bounds, option.doc));
    if (numbers.size() > kMostNumbers) {
      value.Fail(fmt::format("has more than {} numbers", kMostNumbers));
      break;
    }
  }
  return numbers;
}

// The declared default, read as a file would be.
CampaignOptions::Value DefaultOf(const PlanOption& option) {
  Faults faults;
  YamlMap map = ReadYamlText(
      fmt::format("{}: {}", option.name, option.otherwise), "default", &faults);
  const auto value = ReadOption(option, *map.Required(std::string(option.name)));
  Require(faults.empty(), fmt::format("the default of '{}' is not valid", option.name));
  return value;
}

CampaignOptions ReadOptions(const CampaignKind& kind, const YamlValue& value) {
  CampaignOptions options = DefaultCampaign(kind.id).options;
  if (value.is_null()) return options;
  YamlMap map = value.Map();
  for (const PlanOption& option : kind.options) {
    const auto written = map.Optional(std::string(option.name));
    if (!written) continue;
    options.Set(option.name, ReadOption(option, *written));
    options.MarkWritten(option.name);
  }
  map.NoMoreKeys();
  return options;
}

std::vector<std::string> KindIds() {
  std::vector<std::string> ids;
  for (const CampaignKind& kind : AllCampaignKinds()) ids.emplace_back(kind.id);
  return ids;
}

void FailUnknownKind(const YamlValue& value, const std::string& id) {
  const std::string nearest = NearestWord(id, KindIds());
  value.Fail(fmt::format("names no kind of campaign: '{}'", id),
             nearest.empty() ? fmt::format("there are: {}", fmt::join(KindIds(), ", "))
                             : fmt::format("did you mean '{}'?", nearest));
}

// `- iso230: {axis: x}`, `- iso230:` or `- iso230`.
void ReadCampaign(const YamlValue& entry, std::vector<PlannedCampaign>* campaigns) {
  std::string id;
  std::optional<YamlValue> options;
  if (entry.is_scalar()) {
    id = entry.Text();
  } else {
    const auto entries = entry.Map().Entries();
    if (entries.size() != 1) {
      entry.Fail("must be one campaign",
                 "write `- iso230: {axis: x}`: a dash, the kind, its options");
      return;
    }
    id = entries.front().first;
    options = entries.front().second;
  }
  const CampaignKind* kind = FindCampaignKind(id);
  if (kind == nullptr) {
    FailUnknownKind(entry, id);
    return;
  }
  PlannedCampaign campaign = DefaultCampaign(id);
  campaign.place = entry.place();
  if (options) campaign.options = ReadOptions(*kind, *options);
  campaigns->push_back(std::move(campaign));
}

// The name in the rows: as given, else the kind, numbered from the second on.
void NameCampaigns(std::vector<PlannedCampaign>* campaigns, Faults* faults) {
  std::set<std::string> taken;
  for (PlannedCampaign& campaign : *campaigns) {
    const std::string& given = campaign.options.Text("name");
    campaign.name = given.empty() ? campaign.id : given;
    for (int i = 2; given.empty() && taken.contains(campaign.name); ++i) {
      campaign.name = fmt::format("{}_{}", campaign.id, i);
    }
    if (!taken.insert(campaign.name).second) {
      faults->Add(campaign.place,
                  fmt::format("the name '{}' is used twice", campaign.name),
                  "rows of one campaign share their instrument and its zero: each "
                  "campaign needs a name of its own");
    }
  }
}

CertifiedArtefact ReadCertified(YamlMap map) {
  CertifiedArtefact artefact{.type = map.TextOr("type", "")};
  if (const auto sizes = map.Optional("sizes_mm")) {
    for (const YamlValue& size : sizes->List()) {
      artefact.sizes_mm.push_back(size.Number(kPositive));
    }
  }
  artefact.u_um = map.NumberOr("u_um", 0, {0, 1e4});
  if (const auto expansion = map.Optional("expansion_per_k")) {
    artefact.expansion_per_k = expansion->Number({-1e-3, 1e-3});
  }
  map.NoMoreKeys();
  return artefact;
}

Plan ReadFrom(YamlMap map, Faults* faults) {
  Plan plan{.file = map.file()};
  map.IntegerOr("format", 1, 1, 1);
  map.TextOr("about", "");
  plan.machine = map.TextOr("machine", "");
  plan.seed = static_cast<std::uint64_t>(map.IntegerOr("seed", 1, 0, INT64_MAX));
  if (const auto instruments = map.Optional("instruments")) {
    plan.instruments = ReadInstruments(instruments->Map());
  }
  if (const auto artefacts = map.Optional("artefacts")) {
    for (const auto& [id, value] : artefacts->Map().Entries()) {
      plan.artefacts[id] = ReadCertified(value.Map());
    }
  }
  if (const auto campaigns = map.Required("campaigns")) {
    for (const YamlValue& entry : campaigns->List()) {
      ReadCampaign(entry, &plan.campaigns);
    }
    if (campaigns->is_list() && plan.campaigns.empty() && faults->empty()) {
      campaigns->Fail("is empty", "name at least one, such as `- iso230: {axis: x}`");
    }
  }
  map.NoMoreKeys();
  NameCampaigns(&plan.campaigns, faults);
  faults->ThrowIfAny();
  return plan;
}

struct ToWritten {
  std::string operator()(double number) const { return fmt::format("{}", number); }
  std::string operator()(bool flag) const { return flag ? "true" : "false"; }
  std::string operator()(const std::string& text) const { return text; }
  std::string operator()(const std::vector<double>& numbers) const {
    return fmt::format("[{}]", fmt::join(numbers, ", "));
  }
};

}  // namespace

void CampaignOptions::Set(std::string_view name, Value value) {
  values_.insert_or_assign(std::string(name), std::move(value));
}
bool CampaignOptions::is_written(std::string_view name) const {
  return written_.contains(name);
}
void CampaignOptions::MarkWritten(std::string_view name) {
  written_.emplace(name);
}

const CampaignOptions::Value& CampaignOptions::At(std::string_view name) const {
  const auto found = values_.find(name);
  Require(found != values_.end(), fmt::format("no campaign option '{}'", name));
  return found->second;
}
double CampaignOptions::Number(std::string_view name) const {
  return std::get<double>(At(name));
}
int CampaignOptions::Count(std::string_view name) const {
  return static_cast<int>(Number(name));
}
bool CampaignOptions::Flag(std::string_view name) const {
  return std::get<bool>(At(name));
}
const std::string& CampaignOptions::Text(std::string_view name) const {
  return std::get<std::string>(At(name));
}
const std::vector<double>& CampaignOptions::Numbers(std::string_view name) const {
  return std::get<std::vector<double>>(At(name));
}
Axis CampaignOptions::axis(std::string_view name) const {
  return AxisNamed(Text(name)).value();
}

std::map<std::string, std::string> CampaignOptions::AsWritten() const {
  std::map<std::string, std::string> texts;
  for (const auto& [name, value] : values_) {
    std::string text = std::visit(ToWritten{}, value);
    if (!text.empty() && text != "[]") texts.emplace(name, std::move(text));
  }
  return texts;
}

Plan ReadPlan(const fs::path& file) {
  Faults faults;
  return ReadFrom(ReadYamlFile(file, &faults), &faults);
}

Plan ReadPlanText(const std::string& text, const std::string& name) {
  Faults faults;
  return ReadFrom(ReadYamlText(text, name, &faults), &faults);
}

PlannedCampaign DefaultCampaign(std::string_view id) {
  const CampaignKind* kind = FindCampaignKind(id);
  Require(kind != nullptr, fmt::format("there is no kind of campaign '{}'", id));
  PlannedCampaign campaign{.id = std::string(id), .name = std::string(id)};
  for (const PlanOption& option : kind->options) {
    campaign.options.Set(option.name, DefaultOf(option));
  }
  return campaign;
}

namespace {

std::string CampaignsOf(const MachineKind* machine) {
  std::vector<std::string_view> ids;
  for (const CampaignKind& kind : AllCampaignKinds()) {
    if (kind.PlanOn(machine) != nullptr) ids.push_back(kind.id);
  }
  return fmt::format("{}", fmt::join(ids, ", "));
}

}  // namespace

PlannedSession PlanSession(const Plan& plan,
                           const Machine& machine,
                           std::uint64_t seed) {
  MeasuringSession session(plan, machine, seed);
  for (const PlannedCampaign& campaign : plan.campaigns) {
    const CampaignKind* kind = FindCampaignKind(campaign.id);
    Require(kind != nullptr, fmt::format("no kind of campaign '{}'", campaign.id));
    const std::string& instrument = campaign.options.Text("instrument");
    const auto plan_it = kind->PlanOn(machine.kind);
    if (plan_it == nullptr) {
      throw InputError(campaign.place,
                       fmt::format("'{}' is no campaign on this machine", campaign.id),
                       fmt::format("it can perform {}", CampaignsOf(machine.kind)));
    }
    session.Begin(campaign,
                  instrument.empty() ? std::string(kind->instrument) : instrument);
    session.Wait(campaign.options.Number("pause_s"));
    plan_it(campaign, &session);
    if (session.num_rows() > kMostRows) {
      session.Fail(fmt::format("brings the plan to more than {} readings", kMostRows),
                   "fewer positions, runs or repeats will do");
    }
  }
  return std::move(session).Done();
}

std::vector<Row> PlannedRows(const Plan& plan,
                             const Machine& machine,
                             std::uint64_t seed) {
  return PlanSession(plan, machine, seed).rows;
}

double Minutes(const PlannedCampaign& campaign, const Machine& machine) {
  const Plan plan{.campaigns = {campaign}};
  return PlanSession(plan, machine, plan.seed).duration_s / kSecondsPerMinute;
}

}  // namespace caltwin
