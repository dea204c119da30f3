#include "sim/measure/import/unmeasured_lines.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

using Touches = std::vector<const Row*>;

bool IsMeshTouch(const Row& row) {
  return row.kind == RowKind::kTouch && row.campaign.starts_with("mesh") &&
         Known(row.cmd_mm[0]) && Known(row.cmd_mm[1]);
}

// Rows of nothing but 0 along `axis`, in a mesh that hardly has another 0.
std::vector<Touches> LinesOfZeros(const Touches& mesh, std::size_t axis) {
  constexpr std::size_t kFewest = 3;
  constexpr double kMostOthers = 0.1;
  std::map<double, Touches> lines;
  for (const Row* row : mesh) lines[row->cmd_mm[axis]].push_back(row);
  std::vector<Touches> found;
  std::size_t in_lines = 0, zeros = 0;
  for (const Row* row : mesh) zeros += row->value_mm == 0 ? 1 : 0;
  for (const auto& [at, line] : lines) {
    const bool is_zero =
        std::ranges::all_of(line, [](const Row* row) { return row->value_mm == 0; });
    if (!is_zero || line.size() < kFewest) continue;
    in_lines += line.size();
    found.push_back(line);
  }
  const auto others = static_cast<double>(mesh.size() - in_lines);
  const bool is_odd = lines.size() >= kFewest && found.size() * 2 < lines.size() &&
                      static_cast<double>(zeros - in_lines) <= kMostOthers * others;
  return is_odd ? found : std::vector<Touches>();
}

/// How another mesh of the same places differs from one.
struct Beside {
  double there_um = 0;  ///< The largest height where the one has only 0.
  double apart_um = 0;  ///< The largest difference everywhere else.
  std::size_t num = 0;
};

Beside CompareWith(const Touches& other, const Touches& mesh, const Touches& zeros) {
  Beside beside;
  for (const Row* row : mesh) {
    const auto same = std::ranges::find_if(
        other, [&](const Row* one) { return one->cmd_mm == row->cmd_mm; });
    if (same == other.end()) continue;
    const double apart_um = std::abs(UmFromMm((*same)->value_mm - row->value_mm));
    const bool is_zero = std::ranges::find(zeros, row) != zeros.end();
    double* largest = is_zero ? &beside.there_um : &beside.apart_um;
    *largest = std::max(*largest, apart_um);
    beside.num += is_zero ? 0 : 1;
  }
  return beside;
}

FileNote NoteOf(const Touches& zeros,
                std::size_t axis,
                const std::map<std::string, Touches>& meshes) {
  const Row& first = *zeros.front();
  std::string sentence = fmt::format(
      "All {} points of {} {:g} of the mesh at line {} are exactly 0, and no others: "
      "they were not measured. The firmware printed what it had not stored",
      zeros.size(),
      axis == 0 ? "column" : "row",
      first.cmd_mm[axis],
      first.place.line);
  for (const auto& [name, other] : meshes) {
    if (name == first.campaign) continue;
    const Beside beside = CompareWith(other, meshes.at(first.campaign), zeros);
    if (beside.num == 0 || beside.there_um <= beside.apart_um) continue;
    sentence += fmt::format(
        ". Another mesh has up to {:.0f} um there, while the other {} points agree to "
        "{:.0f} um",
        beside.there_um,
        beside.num,
        beside.apart_um);
    break;
  }
  return {.kind = FileNote::Kind::kElsewhere,
          .what = "firmware",
          .sentence = sentence +
                      ". These points are left out; bed and probe are not at fault. Do "
                      "not print with this mesh: probe again, and update the firmware",
          .place = first.place};
}

}  // namespace

void TellUnmeasuredLines(Imported* imported) {
  std::map<std::string, Touches> meshes;
  for (const Row& row : imported->table.rows) {
    if (IsMeshTouch(row)) meshes[row.campaign].push_back(&row);
  }
  std::set<const Row*> out;
  for (const auto& [name, mesh] : meshes) {
    for (const std::size_t axis : {0U, 1U}) {
      for (const Touches& zeros : LinesOfZeros(mesh, axis)) {
        imported->notes.push_back(NoteOf(zeros, axis, meshes));
        out.insert(zeros.begin(), zeros.end());
      }
    }
  }
  std::vector<Row> kept;
  for (const Row& row : imported->table.rows) {
    if (!out.contains(&row)) kept.push_back(row);
  }
  imported->table.rows = std::move(kept);
}

}  // namespace caltwin
