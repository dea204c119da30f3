#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/plain_table.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

Imported ReadSentences(const std::string& sentences,
                       const std::string& name,
                       const ImportOptions& options) {
  Imported imported = ReadOneTable(sentences, sentences, name, options);
  imported.assumed.emplace_back(
      "what the sentences say of sizes was read, and no other line");
  return imported;
}

void AddNew(const std::vector<std::string>& from, std::vector<std::string>* to) {
  for (const std::string& text : from) {
    if (std::ranges::find(*to, text) == to->end()) to->push_back(text);
  }
}

// Rows of a further table of the same text. False: they are of another sort, and left.
bool Join(Imported more, Imported* all) {
  RowTable& table = all->table;
  if (more.table.rows.empty() || more.is_deviation != all->is_deviation ||
      more.has_places != all->has_places) {
    return false;
  }
  if (table.extra_columns.empty()) table.extra_columns = more.table.extra_columns;
  const bool are_alike = more.table.extra_columns.empty() ||
                         more.table.extra_columns == table.extra_columns;
  if (!are_alike) return false;
  for (Row& row : more.table.rows) table.rows.push_back(std::move(row));
  for (Row& row : table.rows) row.extra.resize(table.extra_columns.size());
  all->header.instruments.merge(more.header.instruments);
  all->header.campaigns.merge(more.header.campaigns);
  all->header.settings.merge(more.header.settings);
  AddNew(more.assumed, &all->assumed);
  AddNew(more.warnings, &all->warnings);
  for (FileNote& note : more.notes) all->notes.push_back(std::move(note));
  return true;
}

// "with LEADSCREW_HMM 293" as a campaign's name.
std::string CampaignOf(const TextTable& table, std::size_t number) {
  constexpr std::size_t kLongest = 40;
  std::string name;
  for (const char c : Lowered(table.title)) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (is_plain) {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  name = name.substr(0, kLongest);
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name.empty() ? fmt::format("table_{}", number) : name;
}

void NameCampaign(const std::string& campaign, Imported* imported) {
  const bool has_one = std::ranges::all_of(imported->table.rows, [&](const Row& row) {
    return row.campaign == imported->table.rows.front().campaign;
  });
  if (!has_one) return;
  for (Row& row : imported->table.rows) row.campaign = campaign;
}

// The one axis that the line before a table names: "Y, reversing in little steps".
std::string AxisIn(const TextTable& table) {
  std::string axis;
  for (const std::string& token : TokensOf(table.title)) {
    if (token != "x" && token != "y" && token != "z") continue;
    if (!axis.empty() && axis != token) return "";
    axis = token;
  }
  return axis;
}

Imported ReadTitled(const TextTable& table,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  ImportOptions titled = options;
  if (titled.axis.empty()) titled.axis = AxisIn(table);
  return ReadOneTable(table.text, text, name, titled);
}

std::optional<Imported> ReadIfItCan(const TextTable& table,
                                    const std::string& text,
                                    const std::string& name,
                                    const ImportOptions& options) {
  try {
    return ReadTitled(table, text, name, options);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

Imported ReadTables(const std::vector<TextTable>& tables,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  Imported all = ReadTitled(tables.front(), text, name, options);
  std::size_t num_read = 1, num_lines = all.table.rows.size();
  for (std::size_t i = 1; i < tables.size(); ++i) {
    auto more = ReadIfItCan(tables[i], text, name, options);
    if (!more) continue;
    if (num_read == 1 && options.campaign.empty()) {
      NameCampaign(CampaignOf(tables[0], 1), &all);
    }
    if (options.campaign.empty()) NameCampaign(CampaignOf(tables[i], i + 1), &*more);
    const std::size_t num_more = more->table.rows.size();
    if (!Join(std::move(*more), &all)) continue;
    ++num_read;
    num_lines += num_more;
  }
  if (num_read > 1) {
    all.recognised.insert(
        all.recognised.begin(),
        fmt::format("{} tables of one text: {} readings", num_read, num_lines));
    std::ranges::stable_sort(
        all.table.rows, {}, [](const Row& row) { return row.place.line; });
  }
  all.assumed.push_back(
      fmt::format("the lines around the table{} are remarks and were "
                  "not read",
                  num_read > 1 ? "s" : ""));
  return all;
}

}  // namespace

Imported ReadPlainTable(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  // Where sentences say more than one thing, no table does.
  constexpr long kFewest = 4;
  const std::string sentences = SentencesAsTable(text);
  const bool are_sentences = std::ranges::count(sentences, ',') >= 2 * kFewest;
  try {
    if (are_sentences) return ReadSentences(sentences, name, options);
    Imported whole = ReadOneTable(text, text, name, options);
    // What has no headings when all blanks part it may have some when two do.
    const bool lacks_headings = std::ranges::any_of(
        whole.assumed,
        [](const std::string& assumed) { return assumed.starts_with("column "); });
    if (!lacks_headings) return whole;
    const std::vector<TextTable> tables = TablesInText(text);
    if (tables.empty() || !tables.front().has_heading) return whole;
    return ReadTables(tables, text, name, options);
  } catch (const InputError&) {
    std::vector<TextTable> tables = TablesInText(text);
    if (tables.empty()) tables = ArrowTables(text);
    if (tables.empty() && sentences.empty()) throw;
    if (tables.empty()) return ReadSentences(sentences, name, options);
    return ReadTables(tables, text, name, options);
  }
}

}  // namespace caltwin
