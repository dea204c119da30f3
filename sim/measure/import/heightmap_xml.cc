#include "sim/measure/import/heightmap_xml.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kMostNodes = 1000, kFarthest_mm = 100'000;

/// Where the nodes lie along one axis.
struct Nodes {
  double min_mm = 0, max_mm = 0, num = 0;

  double At_mm(double index) const {
    return num < 2 ? min_mm : min_mm + (max_mm - min_mm) * index / (num - 1);
  }
};

Place PlaceAt(std::ptrdiff_t offset, const std::string& text, const std::string& name) {
  const auto end =
      text.begin() +
      std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(text.size()));
  const auto lines = std::count(text.begin(), end, '\n');
  return {.file = name, .line = static_cast<int>(lines) + 1, .column = 1};
}

std::optional<double> Attribute(const pugi::xml_node& node, const char* key) {
  return NumberOf(node.attribute(key).value());
}

Nodes NodesAlong(const pugi::xml_node& map, char letter, const Place& place) {
  const auto min_mm = Attribute(map, fmt::format("Min{}", letter).c_str());
  const auto max_mm = Attribute(map, fmt::format("Max{}", letter).c_str());
  const auto num = Attribute(map, fmt::format("Size{}", letter).c_str());
  const bool is_whole = min_mm && max_mm && num && *num == std::round(*num) &&
                        *num >= 1 && *num <= kMostNodes &&
                        std::abs(*min_mm) < kFarthest_mm &&
                        std::abs(*max_mm) < kFarthest_mm;
  if (!is_whole) {
    throw InputError(place,
                     fmt::format("the map does not say where its nodes lie along {0}: "
                                 "Min{0}, Max{0} and Size{0}",
                                 letter),
                     "numbers, Size a count up to 1000");
  }
  return {*min_mm, *max_mm, *num};
}

}  // namespace

Imported ReadHeightmapXml(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default);
  if (!parsed) {
    throw InputError(PlaceAt(parsed.offset, text, name),
                     fmt::format("this is no XML: {}", parsed.description()));
  }
  const pugi::xml_node map = document.child("heightmap");
  if (!map) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no <heightmap> stands here",
                     "height maps of OpenCNCPilot and GRBL-Plotter are read");
  }
  const Place at = PlaceAt(map.offset_debug(), text, name);
  const std::array<Nodes, 2> nodes = {NodesAlong(map, 'X', at),
                                      NodesAlong(map, 'Y', at)};
  Imported imported;
  Faults faults;
  std::size_t num_unread = 0;
  for (const pugi::xml_node point : map.children("point")) {
    const Place place = PlaceAt(point.offset_debug(), text, name);
    const auto x = Attribute(point, "X"), y = Attribute(point, "Y");
    const bool is_node =
        x && y && *x >= 0 && *y >= 0 && *x < nodes[0].num && *y < nodes[1].num;
    if (!is_node) {
      faults.Add(place, "this point is no node of the map", "X and Y count from 0");
      continue;
    }
    const auto height_mm = NumberOf(point.text().get());
    if (!height_mm) {
      ++num_unread;
      continue;
    }
    Row row = BedTouchRow(options.campaign.empty() ? "map" : options.campaign,
                          nodes[0].At_mm(*x),
                          nodes[1].At_mm(*y),
                          *height_mm,
                          place);
    row.setup = row.feature = "table";
    row.feature = "table.top";
    imported.table.rows.push_back(std::move(row));
  }
  faults.ThrowIfAny();
  if (imported.table.rows.empty())
    throw InputError(at, "no point of this map was probed");
  imported.recognised = {
      fmt::format("a height map, {:.0f} x {:.0f}: {} points probed, {} not",
                  nodes[0].num,
                  nodes[1].num,
                  imported.table.rows.size(),
                  num_unread)};
  imported.assumed = {
      "z is the height reported at the trigger in mm, + is up; the "
      "table's nominal height is 0"};
  return imported;
}

}  // namespace caltwin
