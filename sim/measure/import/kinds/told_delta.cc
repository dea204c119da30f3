#include "sim/measure/import/kinds/told_delta.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// A word by itself, and no key: "delta, glass bed", but not "[DELTA:6]".
bool HasWord(const std::string& lower, std::string_view word) {
  for (std::size_t at = lower.find(word); at != std::string::npos;
       at = lower.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const auto is_joined = [&](std::size_t i) {
      constexpr std::string_view kKeys = "_:=-[/#.";
      const char c = lower[i];
      return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
             kKeys.find(c) != std::string_view::npos;
    };
    const bool is_end_of_sentence = end + 1 == lower.size() && lower[end] == '.';
    const bool is_free = (at == 0 || !is_joined(at - 1)) &&
                         (end == lower.size() || !is_joined(end) || is_end_of_sentence);
    if (is_free) return true;
  }
  return false;
}

// "max delta 0.3", "the delta between corners": a difference, and no machine.
bool IsDifference(const std::string& lower) {
  constexpr std::array<std::string_view, 12> kOfDifferences = {"delta between",
                                                               "delta of",
                                                               "delta is",
                                                               "delta was",
                                                               "delta from",
                                                               "delta in ",
                                                               "delta z",
                                                               "max delta",
                                                               "maximum delta",
                                                               "min delta",
                                                               "z delta",
                                                               "height delta"};
  const std::size_t at = lower.find("delta ");
  const bool has_number =
      at != std::string::npos && at + 6 < lower.size() &&
      std::string_view("+-.0123456789").find(lower[at + 6]) != std::string_view::npos;
  return has_number || std::ranges::any_of(kOfDifferences, [&](std::string_view words) {
           return lower.find(words) != std::string::npos;
         });
}

bool SpeaksOfDelta(const std::string& text) {
  constexpr std::array<std::string_view, 3> kWords = {"delta", "kossel", "rostock"};
  return std::ranges::any_of(LinesOf(text), [&](const TextLine& line) {
    const std::string lower = Lowered(line.text);
    return !IsDifference(lower) &&
           std::ranges::any_of(
               kWords, [&](std::string_view word) { return HasWord(lower, word); });
  });
}

/// Sums over the places about their means.
struct Sums {
  double zz = 0, az = 0, aa = 0;
  double share() const { return zz > 0 && aa > 0 ? az * az / (zz * aa) : 0; }
};

// Heights about their nearest plane; places of a grid, whose x and y are independent.
struct Beside {
  std::vector<double> x{}, y{}, z{};
};

void TakeMean(std::vector<double>* values) {
  double mean = 0;
  for (const double value : *values)
    mean += value / static_cast<double>(values->size());
  for (double& value : *values) value -= mean;
}

Beside BesidePlane(const std::vector<Row>& rows) {
  Beside beside;
  for (const Row& row : rows) {
    beside.x.push_back(row.cmd_mm[0]);
    beside.y.push_back(row.cmd_mm[1]);
    beside.z.push_back(row.value_mm);
  }
  TakeMean(&beside.x);
  TakeMean(&beside.y);
  TakeMean(&beside.z);
  for (const std::vector<double>* along : {&beside.x, &beside.y}) {
    double up = 0, wide = 0;
    for (std::size_t i = 0; i < beside.z.size(); ++i) {
      up += (*along)[i] * beside.z[i];
      wide += (*along)[i] * (*along)[i];
    }
    for (std::size_t i = 0; i < beside.z.size() && wide > 0; ++i)
      beside.z[i] -= up / wide * (*along)[i];
  }
  return beside;
}

// How much of what the plane leaves has that shape.
Sums SumsWith(const Beside& beside, std::vector<double> shape) {
  TakeMean(&shape);
  Sums sums;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    sums.zz += beside.z[i] * beside.z[i];
    sums.az += shape[i] * beside.z[i];
    sums.aa += shape[i] * shape[i];
  }
  return sums;
}

/// The shape that most of a map has.
struct Shape {
  std::string word{};  ///< twist bowl; empty: neither.
  double size_mm = 0;  ///< Corners against corners; the rim above the middle.
  double share = 0;
};

Shape ShapeOf(const std::vector<Row>& rows) {
  constexpr double kMost = 0.5;
  const Beside beside = BesidePlane(rows);
  std::vector<double> saddle, bowl;
  double half_mm2 = 0, far_mm2 = 0;
  for (std::size_t i = 0; i < beside.z.size(); ++i) {
    const double x = beside.x[i], y = beside.y[i];
    saddle.push_back(x * y);
    bowl.push_back(x * x + y * y);
    half_mm2 = std::max(half_mm2, std::abs(x * y));
    far_mm2 = std::max(far_mm2, bowl.back());
  }
  const Sums twist = SumsWith(beside, saddle), round = SumsWith(beside, bowl);
  if (twist.share() > kMost)
    return {"twist", 2 * twist.az / twist.aa * half_mm2, twist.share()};
  if (round.share() > kMost)
    return {"bowl", round.az / round.aa * far_mm2, round.share()};
  return {};
}

// A twist comes from towers at other angles, a bowl from the radius or the rods.
void TellShape(const Shape& shape, Imported* imported) {
  constexpr double kLeast_mm = 0.1;
  if (shape.word.empty() || std::abs(shape.size_mm) < kLeast_mm) return;
  const bool is_twist = shape.word == "twist";
  imported->notes.push_back(
      {.kind = FileNote::Kind::kFact,
       .sentence = fmt::format(
           "{} of the map beside its plane is a {} ({:.2g} mm{}). A bed hardly bends "
           "like that; on a delta it comes from the geometry in the firmware, first of "
           "all {}. Do not shim the bed and do not cover it with a mesh: calibrate "
           "{}, then map again",
           fmt::format("{:.0f} %", PercentFromFraction(shape.share)),
           is_twist            ? "saddle"
           : shape.size_mm > 0 ? "bowl"
                               : "dome",
           std::abs(shape.size_mm),
           is_twist ? ", two corners against the other two"
                    : ", the rim against the middle",
           is_twist ? "the angles of the towers" : "the delta radius, then the rods",
           is_twist ? "the angles" : "the radius"),
       .fact = is_twist ? "twist" : "form",
       .figures = {
           {is_twist ? "corners_um" : "peak_to_peak_um", UmFromMm(shape.size_mm)}}});
}

}  // namespace

void TellOfDelta(const std::string& text, Imported* imported) {
  constexpr std::size_t kFewest = 9;
  const auto& rows = imported->table.rows;
  const bool is_map =
      rows.size() >= kFewest && std::ranges::all_of(rows, [](const Row& row) {
        return row.kind == RowKind::kTouch && row.n[2] > 0 && Known(row.cmd_mm[0]) &&
               !Known(row.motor_mm[0]);
      });
  if (!is_map || !imported->machine_yaml.empty() || !imported->header.machine.empty() ||
      !SpeaksOfDelta(text)) {
    return;
  }
  imported->told_kind = "delta";
  imported->warnings.emplace_back(
      "the text speaks of a delta and does not say its geometry: causes of a gantry "
      "were not tried");
  TellShape(ShapeOf(rows), imported);
  imported->notes.push_back(
      {.kind = FileNote::Kind::kOpen,
       .what = "cause",
       .sentence = "which tower, rod or radius of the delta it is, and by how much: "
                   "that takes the length of the rods and the radius"});
  if (!imported->next_instrument.empty()) return;
  imported->next_instrument = "settings";
  imported->next_sentence =
      "put the delta's settings into the same file (M665 and M666, or config.g or "
      "printer.cfg) and diagnose again: then towers, rods and radius are told apart";
}

}  // namespace caltwin
