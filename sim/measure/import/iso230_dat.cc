#include "sim/measure/import/iso230_dat.h"

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/positioning.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

// The first line that is no comment names the columns of measured rows.
bool AreRowsAlready(const std::string& text) {
  for (const TextLine& line : LinesOf(text)) {
    if (line.text.starts_with('#')) continue;
    return line.text.find("campaign") != std::string_view::npos &&
           line.text.find("value_mm") != std::string_view::npos;
  }
  return false;
}

Imported Unchanged(const std::string& text, const std::string& name) {
  Imported imported{.table = ParseRows(text, name)};
  imported.recognised = {fmt::format("{} measured rows already, taken as they are",
                                     imported.table.rows.size())};
  imported.warnings = imported.table.remarks;
  return imported;
}

}  // namespace

Imported PositioningRows(const std::vector<PositionReading>& readings,
                         const std::string& axis,
                         const ImportOptions& options) {
  const std::size_t index = axis == "x" ? 0 : axis == "y" ? 1 : 2;
  Require(axis == "x" || axis == "y" || axis == "z", "an axis is x, y or z");
  const std::string campaign =
      options.campaign.empty() ? "iso230_" + axis : options.campaign;
  Imported imported;
  for (const PositionReading& reading : readings) {
    Row row{.campaign = campaign, .rep = reading.run, .place = reading.place};
    row.cmd_mm[index] = reading.target_mm;
    row.dir[index] = reading.sense;
    row.n = {0, 0, 0};
    row.n[index] = 1;
    row.value_mm = reading.value_mm;
    imported.table.rows.push_back(std::move(row));
  }
  imported.header.campaigns[campaign] = {.plan = "iso230", .options = {{"axis", axis}}};
  return imported;
}

std::string AxisOr(const std::string& fallback,
                   const ImportOptions& options,
                   std::vector<std::string>* assumed) {
  const std::string& axis = options.axis;
  if (axis.empty()) {
    if (!fallback.empty()) return fallback;
    assumed->push_back("the axis is x: the file does not name it (--axis x, y or z)");
    return "x";
  }
  if (axis != "x" && axis != "y" && axis != "z") {
    throw InputError({.file = "--axis"},
                     fmt::format("the axis '{}' is not known", axis),
                     "it may be: x, y, z");
  }
  return axis;
}

Imported ReadIso230Dat(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options) {
  if (text.find("TGT_DATA[") != std::string::npos) {
    return ReadEcmcIso230(text, name, options);
  }
  if (text.find("Run Target Data:") != std::string::npos) {
    return ReadRenishawRtl(text, name, options);
  }
  if (AreRowsAlready(text)) return Unchanged(text, name);
  return ReadRunSheet(text, name, options);
}

}  // namespace caltwin
