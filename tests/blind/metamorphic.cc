#include "tests/blind/metamorphic.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/blind/text_file.h"

namespace blind {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string ReadText(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Keys x and y exchanged wherever machine file and header write axes: "  x: {" at the
/// beginning of a line, "{x: 800, y: 640" within one; and "axis: x" of a plan.
std::string MirroredYaml(const std::string& text) {
  std::string mirrored = text;
  for (std::size_t at = 0; (at = mirrored.find_first_of("xy", at)) != std::string::npos;
       ++at) {
    const bool begins = at > 0 && std::string_view(" {").find(mirrored[at - 1]) !=
                                      std::string_view::npos;
    const bool is_key = begins && mirrored.compare(at + 1, 2, ": ") == 0;
    const bool is_axis = at >= 6 && mirrored.compare(at - 6, 6, "axis: ") == 0;
    if (is_key || is_axis) mirrored[at] = mirrored[at] == 'x' ? 'y' : 'x';
  }
  return mirrored;
}

std::set<std::string> Names(const json& answer, bool mirrored) {
  std::set<std::string> names;
  for (const json& finding : answer.value("findings", json::array())) {
    const std::string axis = finding.value("axis", "");
    names.insert(finding.value("cause", "") + " " +
                 (mirrored ? MirroredAxis(axis) : axis));
  }
  return names;
}

/// None, or a set that holds the truth; never another name alone.
bool IsModest(const json& truth, const json& answer) {
  const Judgement judgement = Judge(truth, answer, nullptr);
  return judgement.ran &&
         std::ranges::all_of(judgement.findings, [](const JudgedFinding& finding) {
           return finding.holds || finding.tolerable || !finding.alone ||
                  finding.cause == "unknown";
         });
}

/// The rows with the change made; the files beside them are written too.
TextTable Changed(Change change,
                  const Case& made,
                  TextTable table,
                  const fs::path& folder) {
  Random random(made.request.seed, "change");
  if (change == Change::kShuffleRows) random.Shuffle(&table.rows);
  if (change == Change::kReorderColumns) {
    std::ranges::reverse(table.columns);
    for (auto& row : table.rows) std::ranges::reverse(row);
  }
  if (change == Change::kSwapXAndY) {
    for (const char* name : {"machine.yaml", "DATA.yaml"}) {
      if (fs::exists(folder / name)) {
        WriteText(folder / name, MirroredYaml(ReadText(folder / name)));
      }
    }
    return Mirrored(std::move(table));
  }
  if (change == Change::kDropTheCampaign) {
    std::set<std::string> shown;
    const Hidden& hidden = made.request.hidden[0];
    for (const auto& wanted : FindCause(hidden.cause)->campaigns(hidden.axis)) {
      shown.insert(wanted.kind);
    }
    const auto column = static_cast<std::size_t>(table.Column("campaign"));
    std::erase_if(table.rows, [&](const std::vector<std::string>& row) {
      return shown.contains(row[column].substr(0, row[column].find("_2")));
    });
  }
  return table;
}

const char* Word(Change change) {
  switch (change) {
    case Change::kShuffleRows:
      return "rows shuffled";
    case Change::kReorderColumns:
      return "columns reordered";
    case Change::kSwapXAndY:
      return "x and y swapped";
    case Change::kDropTheCampaign:
      return "telling campaign dropped";
  }
  return "";
}

}  // namespace

TextTable Mirrored(TextTable table) {
  for (const auto& [x, y] : {std::pair{"cmd_x_mm", "cmd_y_mm"},
                             std::pair{"dir_x", "dir_y"},
                             std::pair{"since_rev_x_mm", "since_rev_y_mm"},
                             std::pair{"nx", "ny"},
                             std::pair{"probe_off_x_mm", "probe_off_y_mm"}}) {
    const int first = table.Column(x);
    const int second = table.Column(y);
    if (first < 0 || second < 0) continue;
    std::swap(table.columns[static_cast<std::size_t>(first)],
              table.columns[static_cast<std::size_t>(second)]);
  }
  // Directions at angle a stand at 90 - a; a turn goes the other way round.
  for (const auto& [name, from_deg] :
       {std::pair{"probe_angle_deg", 90.0}, std::pair{"artefact_turn_deg", 0.0}}) {
    const int column = table.Column(name);
    if (column < 0) continue;
    for (auto& row : table.rows) {
      std::string& cell = row[static_cast<std::size_t>(column)];
      if (!cell.empty()) cell = fmt::format("{}", from_deg - std::stod(cell));
    }
  }
  return table;
}

std::string MirroredAxis(const std::string& axis) {
  return axis == "x" ? "y" : axis == "y" ? "x" : axis;
}

std::vector<ChangeResult> ExamineChanges(const Diagnoser& diagnoser,
                                         const CaseRequest& request) {
  Case made;
  MakeCase(request, &made);
  const fs::path folder =
      fs::path(diagnoser.folder) / fmt::format("change_{}", request.seed);
  WriteCase(made, folder.string());
  const json truth = json::parse(TruthJson(made));
  const json before = Diagnose(diagnoser, folder.string());
  const TextTable table = ParseTable(ReadText(folder / "DATA.csv"));
  std::vector<ChangeResult> results;
  for (const Change change : {Change::kShuffleRows,
                              Change::kReorderColumns,
                              Change::kSwapXAndY,
                              Change::kDropTheCampaign}) {
    WriteCase(made, folder.string());
    const TextTable changed = Changed(change, made, table, folder);
    if (changed.rows.size() < 20) continue;  // Nothing was left to ask.
    std::string text = ToText(changed);
    if (change == Change::kReorderColumns) text = "# columns in another order\n" + text;
    WriteText(folder / "DATA.csv", text);
    const json after = Diagnose(diagnoser, folder.string());
    ChangeResult result{.what = Word(change)};
    result.ran = before.is_object() && after.is_object();
    if (result.ran) {
      result.held =
          change == Change::kDropTheCampaign
              ? IsModest(truth, after)
              : Names(before, change == Change::kSwapXAndY) == Names(after, false);
    }
    results.push_back(result);
  }
  if (!diagnoser.keep) fs::remove_all(folder);
  return results;
}

}  // namespace blind
