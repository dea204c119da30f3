#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/base/text_file.h"
#include "sim/measure/columns.h"
#include "sim/measure/csv.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

std::string Text(double value) {
  if (!Known(value)) return "";
  Require(std::isfinite(value), "a measured row holds an infinite number");
  return fmt::format("{}", value);
}
std::string Text(const std::optional<std::int64_t>& value) {
  return value ? fmt::format("{}", *value) : "";
}
std::string Text(const std::string& value) {
  return CsvQuoted(value);
}

std::string TextOf(const Column& column, const Row& row) {
  if (const auto* component = std::get_if<Component>(&column.member)) {
    return Text((row.*component->numbers)[component->index]);
  }
  if (const auto* number = std::get_if<double Row::*>(&column.member)) {
    return Text(row.**number);
  }
  if (const auto* integer =
          std::get_if<std::optional<std::int64_t> Row::*>(&column.member)) {
    return Text(row.**integer);
  }
  return Text(row.*std::get<std::string Row::*>(column.member));
}

}  // namespace

std::string RowsText(const RowTable& table) {
  std::vector<const Column*> columns;
  for (const Column& column : AllColumns()) {
    const bool is_used = std::ranges::any_of(
        table.rows, [&](const Row& row) { return !TextOf(column, row).empty(); });
    if (is_used || column.name == "campaign") columns.push_back(&column);
  }
  const bool is_numbered =
      std::ranges::any_of(table.rows, [](const Row& row) { return row.row != 0; });
  std::string text;
  for (const std::string& comment : table.comments) {
    text += comment.empty() ? "#\n" : "# " + comment + "\n";
  }
  text += is_numbered ? "row,kind" : "kind";
  for (const Column* column : columns) text += fmt::format(",{}", column->name);
  text += ",value_mm";
  for (const std::string& extra : table.extra_columns) text += "," + CsvQuoted(extra);
  text += "\n";
  for (const Row& row : table.rows) {
    Require(row.extra.size() == table.extra_columns.size(),
            "a row has other extra columns than its table");
    if (is_numbered) text += fmt::format("{},", row.row);
    text += kRowKinds[static_cast<std::size_t>(row.kind)];
    for (const Column* column : columns) text += "," + TextOf(*column, row);
    text += "," + Text(row.value_mm);
    for (const std::string& extra : row.extra) text += "," + CsvQuoted(extra);
    text += "\n";
  }
  return text;
}

void WriteRows(const std::filesystem::path& file, const RowTable& table) {
  WriteTextFile(file, RowsText(table));
}

}  // namespace caltwin
