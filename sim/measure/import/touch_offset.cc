#include "sim/measure/import/touch_offset.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {

std::optional<std::array<double, 3>> TouchOfTinyG(const ConsoleLine& said) {
  const std::size_t at = said.lower.find("\"prb\":{");
  if (at == std::string::npos) return std::nullopt;
  const std::string probed = said.lower.substr(at, said.lower.find('}', at) - at);
  if (NumberAfter(probed, "\"e\":") != 1.0) return std::nullopt;
  std::array<double, 3> at_mm{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value_mm = NumberAfter(probed, fmt::format("\"{}\":", "xyz"[k]));
    if (!value_mm) return std::nullopt;
    at_mm[k] = *value_mm;
  }
  return at_mm;
}

std::optional<GrblTouch> TouchOfGrbl(const ConsoleLine& said) {
  if (!said.lower.starts_with("[prb:")) return std::nullopt;
  const std::size_t colon = said.lower.find(':', 5);
  if (colon == std::string::npos) return std::nullopt;
  const std::vector<double> axes = NumbersApart(said.lower.substr(5, colon - 5));
  const auto num_commas =
      std::count(said.lower.begin() + 5,
                 said.lower.begin() + static_cast<std::ptrdiff_t>(colon),
                 ',');
  if (axes.size() < 3 || std::ssize(axes) != num_commas + 1) return std::nullopt;
  return GrblTouch{{axes[0], axes[1], axes[2]},
                   said.lower.compare(colon, 2, ":0") != 0};
}

void TouchOffset::Take(const ConsoleLine& said, int line) {
  if (said.lower.find("g38.") != std::string::npos) {
    target_mm_ = WordOf(said, 'z').value_or(kUnknown);
  } else if (IsCommand(said, "g10") && said.lower.find("l2 ") != std::string::npos &&
             WordOf(said, 'z')) {
    set_mm_ = *WordOf(said, 'z');
    line_ = line;
  } else if (const auto touch_mm = TouchOfTinyG(said)) {
    touch_mm_ = (*touch_mm)[2];
  } else if (const auto touch = TouchOfGrbl(said); touch && touch->has_touched) {
    touch_mm_ = touch->at_mm[2];
  }
}

void TouchOffset::Tell(Imported* imported) const {
  constexpr double kSame_mm = 1e-6, kApart_mm = 0.01;
  const bool is_target = std::abs(set_mm_ - target_mm_) < kSame_mm;
  const double off_mm = set_mm_ - touch_mm_;
  if (!is_target || !(std::abs(off_mm) > kApart_mm)) return;
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "work_offset",
       .sentence = fmt::format(
           "Line {}: Z of the work offset was set to {:g}, where the touch was told to "
           "end at most; it touched at {:.3f}. Work zero lies {:.3f} mm {} the touch. "
           "The macro wrote the offset before the touch was over (the controller "
           "answers at once, the position is known later). Take the position that the "
           "probe reports, {:.3f}, less the plate's thickness. One touch says nothing "
           "of the axis or the probe",
           line_,
           set_mm_,
           touch_mm_,
           std::abs(off_mm),
           off_mm < 0 ? "below" : "above",
           touch_mm_),
       .fact = "offset",
       .axis = "z",
       .word = "zero",
       .figures = {{"change_um", UmFromMm(off_mm)}}});
}

}  // namespace caltwin
