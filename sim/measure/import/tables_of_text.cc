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

void NameCampaign(const std::string& campaign, Imported* imported) {
  const bool has_one = std::ranges::all_of(imported->table.rows, [&](const Row& row) {
    return row.campaign == imported->table.rows.front().campaign;
  });
  if (!has_one) return;
  for (Row& row : imported->table.rows) row.campaign = campaign;
}

// The axis that the line before a table begins with: "Y, reversing in little steps",
// "Y axis".
std::string AxisIn(const TextTable& table) {
  const std::vector<std::string> tokens = TokensOf(table.title);
  const auto is_axis = [](const std::string& token) {
    return token == "x" || token == "y" || token == "z";
  };
  const bool is_first = !tokens.empty() && is_axis(tokens.front());
  return is_first && std::ranges::count_if(tokens, is_axis) == 1 ? tokens.front() : "";
}

Imported ReadTitled(const TextTable& table,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  ImportOptions titled = options;
  const std::string axis = AxisIn(table);
  if (titled.axis.empty()) titled.axis = axis;
  Imported imported = ReadOneTable(table.text, text, name, titled);
  if (options.axis.empty() && !axis.empty()) {
    imported.assumed.push_back(
        fmt::format("the axis is {}: the line above its table says so", axis));
  }
  return imported;
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

// The first table that can be read, and every other that goes with it.
Imported ReadTables(const std::vector<TextTable>& tables,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  std::optional<Imported> all;
  std::size_t first = 0, num_read = 0;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    auto more = ReadIfItCan(tables[i], text, name, options);
    if (!more) continue;
    if (!all) {
      all = std::move(more);
      first = i;
      num_read = 1;
      continue;
    }
    if (options.campaign.empty()) {
      if (num_read == 1)
        NameCampaign(CampaignNamed(tables[first].title, first + 1), &*all);
      NameCampaign(CampaignNamed(tables[i].title, i + 1), &*more);
    }
    num_read += Join(std::move(*more), &*all) ? 1 : 0;
  }
  // What the largest lacks is told.
  if (!all) return ReadTitled(tables.front(), text, name, options);
  if (num_read > 1) {
    all->recognised = {fmt::format(
        "{} tables of one text: {} readings", num_read, all->table.rows.size())};
    std::ranges::stable_sort(
        all->table.rows, {}, [](const Row& row) { return row.place.line; });
  }
  all->assumed.push_back(
      fmt::format("the lines around the table{} are remarks and were "
                  "not read",
                  num_read > 1 ? "s" : ""));
  return std::move(*all);
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
    const auto assumes = [&](std::string_view words) {
      return std::ranges::any_of(whole.assumed, [&](const std::string& assumed) {
        return assumed.starts_with(words);
      });
    };
    const bool lacks_headings = assumes("column "),
               lacks_axis = assumes("the axis is x");
    if (!lacks_headings && !lacks_axis) return whole;
    const std::vector<TextTable> arrows = ArrowTables(text);
    if (lacks_headings && !arrows.empty())
      return ReadTables(arrows, text, name, options);
    const std::vector<TextTable> tables = TablesInText(text);
    const bool says_axis = tables.size() == 1 && !AxisIn(tables.front()).empty();
    const bool says_more =
        lacks_headings && !tables.empty() && tables.front().has_heading;
    return says_more || (lacks_axis && says_axis)
               ? ReadTables(tables, text, name, options)
               : whole;
  } catch (const InputError&) {
    std::vector<TextTable> tables = TablesInText(text);
    if (tables.empty()) tables = ArrowTables(text);
    if (tables.empty() && sentences.empty()) throw;
    if (tables.empty()) return ReadSentences(sentences, name, options);
    return ReadTables(tables, text, name, options);
  }
}

}  // namespace caltwin
