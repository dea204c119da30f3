#include "calibration/facts/advice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/one_size.h"

namespace caltwin {
namespace {

/// What the rows hold of one axis.
struct Coverage {
  std::set<long> places{};    ///< Of positions read along it.
  std::set<double> senses{};  ///< Of those.
  bool is_read = false, is_touched = false;
};

std::array<Coverage, 3> CoverageOf(const Rows& rows) {
  std::array<Coverage, 3> axes;
  for (const Row* row : rows) {
    const int along = AxisAlong(*row);
    if (along < 0) continue;
    const auto k = static_cast<std::size_t>(along);
    Coverage& axis = axes[k];
    const bool is_gauged = row->kind == RowKind::kPosition;
    axis.is_read |= is_gauged;
    axis.is_touched |= !is_gauged;
    if (Known(row->cmd_mm[k])) axis.places.insert(std::lround(row->cmd_mm[k] * 1e3));
    if (Known(row->dir[k]) && row->dir[k] != 0) axis.senses.insert(row->dir[k]);
  }
  return axes;
}

void Cannot(const std::string& what, const std::string& sentence, Facts* facts) {
  facts->not_determined.push_back(what);
  facts->cannot.push_back(sentence);
}

void AddLimits(const Rows& rows, const Repeats& repeats, Facts* facts) {
  const std::array<Coverage, 3> axes = CoverageOf(rows);
  for (std::size_t k = 0; k < 3; ++k) {
    const Coverage& axis = axes[k];
    if (!axis.is_read && !axis.is_touched) continue;
    const char letter = "XYZ"[k];
    const bool is_tried = std::ranges::any_of(facts->all, [&](const Fact& fact) {
      return fact.word == "trials" && fact.axis == kAxisNames[k];
    });
    if (is_tried) {
      // Trials at several settings tell it, or tell that they do not.
    } else if (axis.places.size() < 2) {
      facts->at_one_place.push_back(fmt::format("scale.{}", kAxisNames[k]));
      Cannot(
          fmt::format("scale.{}", kAxisNames[k]),
          fmt::format("steps/mm of {}: all readings are at one position of it", letter),
          facts);
    } else if (!axis.is_read) {
      Cannot(
          fmt::format("scale.{}", kAxisNames[k]),
          fmt::format("steps/mm of {}: touches tell it only from a size that is known",
                      letter),
          facts);
    }
    if (axis.senses.size() < 2) {
      Cannot(fmt::format("backlash.{}", kAxisNames[k]),
             axis.senses.empty()
                 ? fmt::format("lost motion of {}: no row says from which side it came",
                               letter)
                 : fmt::format("lost motion of {}: it always came from the same side",
                               letter),
             facts);
    }
  }
  if (AreSizes(rows)) {
    Cannot("scale",
           "whether the machine or the part is off: sizes of parts give the product of "
           "both "
           "(shrinkage, walls); only a move measured on the head tells the axis",
           facts);
  }
  if (!Known(repeats.noise.sd_mm)) {
    Cannot(
        "uncertainty",
        "how far to trust one reading: nothing was measured twice, and no uncertainty "
        "is stated",
        facts);
  }
  const bool knows_temperature = std::ranges::any_of(rows, [](const Row* row) {
    return Known(row->temp_frame_c) || Known(row->temp_bed_c) ||
           Known(row->temp_screw_c) || Known(row->temp_chamber_c) ||
           Known(row->temp_ambient_c);
  });
  if (!knows_temperature && facts->Find("drift") != nullptr) {
    Cannot("temperature",
           "what the drift goes along with: no temperature was logged",
           facts);
  }
}

void Next(const std::string& instrument, const std::string& sentence, Facts* facts) {
  facts->next.push_back({instrument, sentence});
}

// What tells more of what the facts are.
void AddNextOfFacts(Facts* facts) {
  const Fact* drift = facts->Find("drift");
  if (drift != nullptr && drift->word == "staircase") {
    Next(
        "probe",
        "move the axis away and back ten times and touch nothing, then touch once: off "
        "by ten steps, the moves lose it; off by one, the touch does",
        facts);
  } else if (drift != nullptr) {
    Next("probe",
         "touch the same place 20 times more, without homing, once cold and once after "
         "half an hour warm, with the temperatures beside each touch: a drift that "
         "stops "
         "when warm is warming",
         facts);
  }
  if (facts->Find("homing_scatter") != nullptr) {
    Next("probe",
         "home ten times with three touches of one place after each: that parts the "
         "switch from the probe. Then look at the switch's screws and at what stops it",
         facts);
  }
  if (facts->Find("twist") != nullptr) {
    Next("ruler",
         "measure both sides of the gantry against the frame (or let it drop on two "
         "equal blocks), square it, and touch the corners again; a straight ruler "
         "across "
         "the bed's diagonals parts a twisted bed from a racked gantry",
         facts);
  }
  if (facts->Find("cross_reversal") != nullptr) {
    Next("feeler_gauge",
         "hold the carriage and rock it by hand: play that can be felt is taken out at "
         "the eccentric nuts or preload; then repeat these rows",
         facts);
  }
  if (facts->Find("skew") != nullptr) {
    Next("calliper",
         "measure both diagonals of a printed or milled square twice, turned by 90 "
         "degrees: a skew of the machine turns along with it, a poor square does not",
         facts);
  }
  if (facts->Find("known_ratio") != nullptr) {
    Next("ruler",
         "command 100 mm and measure it with a ruler, before and after the change: a "
         "ratio needs no fine gauge",
         facts);
  }
}

void AddNext(const Rows& rows, const Repeats& repeats, Facts* facts) {
  AddNextOfFacts(facts);
  const bool has_touches = std::ranges::any_of(
      rows, [](const Row* row) { return row->kind == RowKind::kTouch; });
  if (!facts->next.empty()) return;
  if (AreSizes(rows)) {
    Next("printed_part",
         "make a part three to five times as long, outside and inside, and measure it: "
         "a "
         "constant stays, a scale grows with the length",
         facts);
    return;
  }
  if (!Known(repeats.noise.sd_mm)) {
    Next(has_touches ? "probe" : "calliper",
         "measure every place twice more: without repeats nobody knows what is noise",
         facts);
  } else if (has_touches) {
    Next("probe",
         "touch the four corners and the middle, twice each: it takes a minute and "
         "tells "
         "tilt, twist and bow apart",
         facts);
  } else {
    Next("dial",
         "set a dial against the axis, move 1 mm away and back ten times from either "
         "side: that tells lost motion from scatter",
         facts);
  }
}

}  // namespace

void AddAdvice(const std::vector<const Row*>& rows,
               const Repeats& repeats,
               Facts* facts) {
  AddLimits(rows, repeats, facts);
  AddNext(rows, repeats, facts);
}

}  // namespace caltwin
