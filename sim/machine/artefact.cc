#include "sim/machine/artefact.h"

#include <algorithm>
#include <cmath>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr std::array<const char*, 6> kTypeNames = {
    "block123", "web", "ring", "pocket", "ledge", "plate"};

void ReadSize(YamlMap* map, Artefact* artefact) {
  const auto side = AxisNamed(map->WordOr("side", "x", {"x", "y", "z"}));
  artefact->side = side.value_or(Axis::kX);
  switch (artefact->type) {
    case ArtefactType::kBlock123:
      artefact->size_mm = BlockLying(artefact->side, kBlockSizes_mm[2]);
      return;
    case ArtefactType::kWeb:
      artefact->size_mm = {60, 60, 30};
      artefact->size_mm[Index(artefact->side)] =
          map->NumberOr("thickness_mm", 3, {0.1, 50});
      return;
    case ArtefactType::kRing:
      artefact->size_mm = {map->NumberOr("diameter_mm", 50, {5, 250}), 0, 20};
      return;
    case ArtefactType::kPocket: {
      const double width_mm = map->NumberOr("width_mm", 50, {5, 250});
      artefact->size_mm = {width_mm, width_mm, 20};
      return;
    }
    case ArtefactType::kLedge:
      artefact->size_mm = {40, 40, map->NumberOr("thickness_mm", 10, {0.5, 50})};
      return;
    case ArtefactType::kPlate: {
      Eigen::Vector3d size_mm(260, 260, 10);
      if (const auto value = map->Optional("size_mm")) {
        const auto numbers = value->Numbers(3, {0.1, 2000});
        size_mm = {numbers[0], numbers[1], numbers[2]};
      }
      artefact->size_mm = size_mm;
      return;
    }
  }
}

}  // namespace

std::string ToString(ArtefactType type) {
  return kTypeNames[static_cast<int>(type)];
}

Vec3<double> BlockLying(Axis axis, double length_mm) {
  Vec3<double> size_mm;
  int next = Index(axis) == 0 ? 1 : 0;
  bool found = false;
  for (int i = 2; i >= 0; --i) {
    if (!found && std::abs(kBlockSizes_mm[i] - length_mm) < 1e-6) {
      size_mm[Index(axis)] = kBlockSizes_mm[i];
      found = true;
      continue;
    }
    if (next == Index(axis)) ++next;
    if (next < 3) size_mm[next++] = kBlockSizes_mm[i];
  }
  Require(found, "a length that is not one of the 1-2-3 block's");
  return size_mm;
}

std::vector<std::string> IdsOf(const std::vector<Artefact>& artefacts) {
  std::vector<std::string> ids;
  for (const Artefact& artefact : artefacts) ids.push_back(artefact.id);
  return ids;
}

std::vector<Artefact> ReadArtefacts(YamlMap map) {
  std::vector<Artefact> artefacts;
  for (const auto& [id, value] : map.Entries()) {
    Artefact artefact{.id = id};
    YamlMap entry = value.Map();
    if (const auto type = entry.Required("type")) {
      const std::string word = type->Word({kTypeNames.begin(), kTypeNames.end()});
      artefact.type = static_cast<ArtefactType>(
          std::find(kTypeNames.begin(), kTypeNames.end(), word) - kTypeNames.begin());
    }
    if (const auto at = entry.Required("at_mm")) {
      const auto numbers = at->Numbers(3, {-1e4, 1e4});
      artefact.at_mm = {numbers[0], numbers[1], numbers[2]};
    }
    ReadSize(&entry, &artefact);
    artefact.turn_deg = entry.NumberOr("turn_deg", 0, {-360, 360});
    artefact.u_um = entry.NumberOr("u_um", 0, {0, 1e4});
    entry.NoMoreKeys();
    artefacts.push_back(artefact);
  }
  return artefacts;
}

}  // namespace caltwin
