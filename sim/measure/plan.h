#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/base/yaml.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/instrument.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a campaign's option may hold.
enum class OptionType { kNumber, kCount, kFlag, kWord, kText, kNumbers };

/// One option of a kind of campaign; its name ends in its unit.
struct PlanOption {
  std::string_view name;
  OptionType type = OptionType::kNumber;
  std::string_view otherwise;  ///< The default, as a file would say it.
  std::string_view doc;
  Bounds bounds = kAnyNumber;                 ///< Of the number, count or each number.
  std::span<const std::string_view> words{};  ///< Of a kWord: what it may say.
};

/// Options of one campaign: every one its kind declares has a value.
class CampaignOptions {
 public:
  using Value = std::variant<double, bool, std::string, std::vector<double>>;

  void Set(std::string_view name, Value value);
  /// Whether the file, or whoever made the campaign, said it.
  bool is_written(std::string_view name) const;
  void MarkWritten(std::string_view name);

  double Number(std::string_view name) const;
  int Count(std::string_view name) const;
  bool Flag(std::string_view name) const;
  const std::string& Text(std::string_view name) const;
  const std::vector<double>& Numbers(std::string_view name) const;
  /// A kWord that names an axis.
  Axis axis(std::string_view name) const;
  /// As a data header writes them.
  std::map<std::string, std::string> AsWritten() const;

 private:
  const Value& At(std::string_view name) const;
  std::map<std::string, Value, std::less<>> values_{};
  std::set<std::string, std::less<>> written_{};
};

/// One campaign of a plan.
struct PlannedCampaign {
  std::string id{};    ///< Of its kind: "iso230".
  std::string name{};  ///< In the rows: the id, numbered from the second on.
  CampaignOptions options{};
  Place place{};  ///< Where the plan says it.
};

/// What a machine is to measure: the schema of plan files (docs/plans.md).
struct Plan {
  std::filesystem::path file{};
  std::string machine{};  ///< A name or path, as written; empty: not said.
  std::uint64_t seed = 1;
  Instruments instruments{};
  /// What is known of artefacts beyond a campaign's own options: sizes, uncertainty.
  std::map<std::string, CertifiedArtefact> artefacts{};
  std::vector<PlannedCampaign> campaigns{};
};

/// Reads and checks a plan; throws InputError with every fault.
Plan ReadPlan(const std::filesystem::path& file);
Plan ReadPlanText(const std::string& text, const std::string& name);

/// A campaign of that kind with its defaults, for plans made in code. The kind must
/// exist.
PlannedCampaign DefaultCampaign(std::string_view id);

/// What the machine would have to do: every reading in the order it is taken, with all
/// its circumstances, and the header that explains them. `value_mm` is 0: still to be
/// measured.
struct PlannedSession {
  std::vector<Row> rows{};
  DataHeader header{};
  double duration_s = 0;
};

/// Turns a plan into readings. Time runs on from campaign to campaign, as a machine
/// with this one's feeds would take; temperatures are steady to 0.3 K unless a campaign
/// starts from cold. Random places and orders come from `seed`. Throws InputError where
/// a campaign does not fit the machine's travel.
PlannedSession PlanSession(const Plan& plan,
                           const Machine& machine,
                           std::uint64_t seed);
std::vector<Row> PlannedRows(const Plan& plan,
                             const Machine& machine,
                             std::uint64_t seed);

/// Machine time of one campaign [min].
double Minutes(const PlannedCampaign& campaign, const Machine& machine);

}  // namespace caltwin
