#include "calibration/facts/scale.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/ratios.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kSure = 4;

// A ratio that people know.
void AddKnownRatio(const Line& line,
                   const KnownRatio& known,
                   const Fact& scale,
                   Facts* facts) {
  const std::size_t axis =
      scale.axis.empty() ? 0 : static_cast<std::size_t>(scale.axis[0] - 'x');
  const char letter = "XYZ"[axis];
  const double factor = scale.figures[0].value, sd = scale.figures[0].sd;

  facts->all.push_back(
      {.id = "known_ratio",
       .axis = kAxisNames[axis],
       .word = known.reading,
       .also = known.also,
       .figures = scale.figures,
       .sigmas = scale.sigmas,
       .sentence = fmt::format("{} moves {} times what is commanded, and {}",
                               letter,
                               WithSd(factor, sd, ""),
                               known.sentence),
       .is_answer = true});
  const bool is_of_file = known.reading == "inches" && !line.are_moves;
  if (known.has_rival) {
    facts->not_determined.emplace_back("cause");
    facts->cannot.push_back(fmt::format(
        "which of the two makes the factor of {}: {}", letter, known.sentence));
  } else if (facts->not_the_machine.reason.empty() && known.reading != "sign") {
    facts->not_the_machine = {
        is_of_file ? "file" : "settings",
        is_of_file
            ? "Sizes at 1/25.4: the program's numbers are inches and are read as "
              "millimetres. Put G20 at its start, or write it in millimetres; leave "
              "steps/mm alone"
            : facts->all.back().sentence};
  }
}

// A figure near to 1 whose uncertainty nobody knows needs its fourth digit, too.
std::string FactorInWords(double factor, double sd) {
  return Known(sd) ? WithSd(factor, sd, "") : fmt::format("{:.4g}", factor);
}

// A constant beside a scale: a size of one length makes the one of the other.
bool AddBoth(const Line& line, double noise_mm, std::size_t axis, Facts* facts) {
  constexpr double kLeast_mm = 0.02, kLeastPlace_mm = 1, kOfResidual = 5,
                   kOfScale = 0.3;
  const bool is_of_sizes =
      line.least_mm > kLeastPlace_mm && line.has_senses_unknown && !line.are_moves;
  const double at_ends_mm = std::abs(line.slope) * (line.most_mm - line.least_mm);
  const double left_mm = line.dof >= 1 ? std::sqrt(line.left_mm2 / line.dof) : kUnknown;
  const double doubt_mm =
      (Known(noise_mm) ? noise_mm : left_mm) * std::max(1.0, line.offset_unit_sd);
  const bool is_there = is_of_sizes && std::abs(line.offset_mm) > kLeast_mm &&
                        std::abs(line.offset_mm) > kOfScale * at_ends_mm &&
                        std::abs(line.offset_mm) > kOfResidual * doubt_mm;
  if (!is_there) return false;
  const double sd_mm = Known(noise_mm) ? noise_mm * line.offset_unit_sd : kUnknown;
  const char letter = "XYZ"[axis];
  facts->not_determined.push_back(fmt::format("scale.{}", kAxisNames[axis]));
  facts->cannot.push_back(fmt::format(
      "steps/mm of {}: sizes are off by a constant beside what goes with their length; "
      "set from one size they are wrong for every other",
      letter));
  facts->all.push_back(
      {.id = "offset",
       .axis = kAxisNames[axis],
       .word = "sizes",
       .figures = {{"change_um", UmFromMm(line.offset_mm), UmFromMm(sd_mm)},
                   {"factor", 1 + line.slope, noise_mm * line.slope_unit_sd}},
       .sentence = fmt::format(
           "Sizes along {} are too {} by a constant {}, whatever their length, and "
           "beside it {:.4g} times what they should be: no steps/mm makes all of them "
           "right. What takes a constant comes first (the width of the cut or the "
           "line, "
           "play at reversals, how the calliper sits): measure one part inside and "
           "outside, or a long line between two marks, then set steps/mm by the screw "
           "or pulley",
           letter,
           line.offset_mm > 0 ? "large" : "small",
           WithSd(std::abs(line.offset_mm), sd_mm, "mm"),
           1 + line.slope),
       .is_answer = true});
  return true;
}

// What was read is hardly any of what was told, or scatters too much: no figure. False:
// it is one.
bool IsNoFigure(double factor, double sd, std::size_t axis, Facts* facts) {
  constexpr double kHardlyAny = 0.02, kNoFigure = 0.02;
  const char letter = "XYZ"[axis];
  std::string why;
  if (std::abs(factor) < kHardlyAny) {
    why = fmt::format(
        "steps/mm of {}: what was read is hardly any of what was told. Either these "
        "readings are deviations and no positions, in which case the column's heading "
        "should say so, or the axis does not move",
        letter);
  } else if (Known(sd) && sd > kNoFigure) {
    why = fmt::format(
        "steps/mm of {}: what was read scatters too much, they could be off by {:.2g} "
        "%",
        letter,
        PercentFromFraction(sd));
  }
  if (why.empty()) return false;
  facts->not_determined.push_back(fmt::format("scale.{}", kAxisNames[axis]));
  facts->cannot.push_back(why);
  return true;
}

// What steps/mm are to be multiplied by, and what they were.
void TellFactor(
    double factor, double sd, bool are_parts, double steps_per_mm, Fact* fact) {
  const double steps_sd = sd / (factor * factor);
  fact->sentence = fmt::format(
      "{} moves {} times what is commanded: multiply its steps/mm by {} (divide its "
      "rotation_distance by it){}",
      static_cast<char>(fact->axis[0] - 'a' + 'A'),
      FactorInWords(factor, sd),
      FactorInWords(1 / factor, steps_sd),
      Known(sd) ? "" : ". Its uncertainty is not known: nothing was measured twice");
  if (Known(steps_per_mm)) {
    fact->figures.push_back(
        {"steps_per_mm", steps_per_mm / factor, steps_per_mm * steps_sd});
    fact->sentence += fmt::format(
        ". {:g} steps/mm were set: {:.6g}", steps_per_mm, steps_per_mm / factor);
  }
  constexpr double kMostShrinkage = 0.03;  // Polyamide 1 to 2 %, PLA 0.2 to 0.5 %.
  if (are_parts && factor < 1 && factor > 1 - kMostShrinkage) {
    fact->sentence +=
        ". Sizes of parts do not tell it from material that shrinks (plastics by 0.2 "
        "to "
        "2 %): measure a move of the head before steps/mm are changed";
  }
  const FineRatio fine = FineRatioOf(factor, sd);
  if (fine.reading.empty()) return;
  fact->also = {std::string(fine.reading)};
  fact->sentence += fmt::format(". {}", fine.sentence);
}

void AddScale(const Line& line,
              double noise_mm,
              std::size_t axis,
              double steps_per_mm,
              Facts* facts) {
  constexpr double kNothing = 1e-6, kOfAFewKelvin = 50e-6;
  // What scatters more than ratios differ is none of them.
  constexpr double kMostOfRatio = 0.1;
  const double factor = 1 + line.slope;
  const double sd = noise_mm * line.slope_unit_sd;
  const bool is_told = !Known(sd) || sd < kMostOfRatio * std::abs(factor);
  const KnownRatio known = is_told ? KnownRatioOf(factor, sd) : KnownRatio{};
  const char letter = "XYZ"[axis];
  const double sigmas =
      Known(sd) ? std::abs(line.slope) / std::max(sd, 1e-12) : kUnknown;
  Fact fact{.id = "scale",
            .axis = kAxisNames[axis],
            .figures = {{"factor", factor, sd},
                        {"steps_factor", 1 / factor, sd / (factor * factor)}},
            .sigmas = sigmas,
            .is_answer = known.reading.empty() && Known(sd) && sigmas > kSure};
  if (!known.reading.empty()) AddKnownRatio(line, known, fact, facts);
  if (IsNoFigure(factor, sd, axis, facts)) return;
  if (!Known(sd) && std::abs(line.slope) < kNothing) {
    fact.sentence = fmt::format(
        "{} moves what is commanded, as far as these few readings show", letter);
  } else if (Known(sd) && sigmas < kSure / 2) {
    fact.sentence = fmt::format(
        "{} moves what is commanded, to {} ppm (standard uncertainty): nothing speaks "
        "against its steps/mm",
        letter,
        TwoDigits(PpmFromFraction(sd)));
  } else if (Known(sd) && std::abs(line.slope) < kOfAFewKelvin) {
    fact.sentence = fmt::format(
        "{} moves {} {} than commanded. One kelvin does 11 to 23 ppm to steel and "
        "aluminium: mind the temperature before its steps/mm",
        letter,
        WithSd(std::abs(PpmFromFraction(line.slope)), PpmFromFraction(sd), "ppm"),
        line.slope > 0 ? "more" : "less");
  } else {
    TellFactor(factor, sd, line.are_parts, steps_per_mm, &fact);
  }
  facts->all.push_back(std::move(fact));
}

// Sizes that are all off by the same amount, whatever their length: no steps/mm does
// that.
bool AddSurplus(const Line& line, double noise_mm, std::size_t axis, Facts* facts) {
  constexpr double kLeast_mm = 0.02, kLeastPlace_mm = 1;
  const bool is_of_sizes = line.least_mm > kLeastPlace_mm && line.has_senses_unknown;
  const double at_ends_mm = line.slope * (line.most_mm - line.least_mm);
  const double sd_mm = noise_mm * line.offset_unit_sd;
  const bool is_offset = std::abs(line.offset_mm) > kLeast_mm &&
                         (!Known(sd_mm) || std::abs(line.offset_mm) > kSure * sd_mm);
  if (!is_of_sizes || !is_offset ||
      std::abs(at_ends_mm) > 0.3 * std::abs(line.offset_mm)) {
    return false;
  }
  // Lines and cutters are narrower.
  constexpr double kWidest_mm = 4;
  const bool is_of_walls = std::abs(line.offset_mm) < kWidest_mm;
  if (!is_of_walls) {
    facts->not_determined.push_back(fmt::format("scale.{}", kAxisNames[axis]));
    facts->not_determined.emplace_back("cause");
    facts->cannot.push_back(fmt::format(
        "what takes a fixed {:.3g} mm from sizes along {}: look at the size "
        "that the slicer or sender shows, and at which file was used",
        std::abs(line.offset_mm),
        "XYZ"[axis]));
  }
  const std::string why =
      is_of_walls
          ? fmt::format(
                "a constant on both walls (plastic or cutter width, how the "
                "calliper sits), not steps/mm. Leave steps/mm alone; correct "
                "extrusion, line width or tool diameter by {} a wall",
                WithSd(std::abs(line.offset_mm) / 2, sd_mm / 2, "mm"))
          : "no steps/mm does that, and no width of a line or cutter either. The file "
            "that was made is not the one that was drawn, or a size was misread";
  facts->all.push_back(
      {.id = "offset",
       .axis = kAxisNames[axis],
       .word = "surplus",
       .figures = {{"change_um", UmFromMm(line.offset_mm), UmFromMm(sd_mm)},
                   {"factor", 1 + line.slope, noise_mm * line.slope_unit_sd}},
       .sigmas =
           Known(sd_mm) ? std::abs(line.offset_mm) / std::max(sd_mm, 1e-12) : kUnknown,
       .sentence =
           fmt::format("Every size along {} is too {} by {}, whatever its length: {}",
                       "XYZ"[axis],
                       line.offset_mm > 0 ? "large" : "small",
                       WithSd(std::abs(line.offset_mm), sd_mm, "mm"),
                       why),
       .is_answer = true});
  return true;
}

// Moves that all end short by the same amount, beside what goes with their length.
void AddLostPerMove(const Line& line, double noise_mm, std::size_t axis, Facts* facts) {
  constexpr double kLeast_mm = 0.02;
  const double sd_mm = noise_mm * line.offset_unit_sd;
  const bool is_sure = Known(sd_mm) && std::abs(line.offset_mm) > kSure * sd_mm &&
                       std::abs(line.offset_mm) > kLeast_mm;
  if (!line.are_moves || !is_sure) return;
  facts->all.push_back(
      {.id = "offset",
       .axis = kAxisNames[axis],
       .word = "per_move",
       .figures = {{"change_um", UmFromMm(line.offset_mm), UmFromMm(sd_mm)}},
       .sigmas = std::abs(line.offset_mm) / std::max(sd_mm, 1e-12),
       .sentence = fmt::format(
           "Each move of {} ends {} {}, whatever its length, beside what goes with its "
           "length: the play that is lost at a reversal, if each move turned round. A "
           "move of one length alone hides it in the steps/mm; take out the play, then "
           "set steps/mm by the scale above",
           "XYZ"[axis],
           WithSd(std::abs(line.offset_mm), sd_mm, "mm"),
           line.offset_mm < 0 ? "short" : "far"),
       .is_answer = true});
}

}  // namespace

void FactsOfLine(const Line& line,
                 double noise_mm,
                 std::size_t axis,
                 double steps_per_mm,
                 Facts* facts) {
  if (AddSurplus(line, noise_mm, axis, facts) || AddBoth(line, noise_mm, axis, facts)) {
    return;
  }
  AddScale(line, noise_mm, axis, steps_per_mm, facts);
  AddLostPerMove(line, noise_mm, axis, facts);
}

void KeepSurestScales(Facts* facts) {
  const auto agrees = [](const Fact& fact) {
    return fact.id == "scale" && Known(fact.sigmas) && fact.sigmas < kSure / 2;
  };
  const auto sd = [](const Fact& fact) {
    return fact.figures.front().sd;
  };
  std::map<std::string, double> surest;
  for (const Fact& fact : facts->all) {
    if (!agrees(fact)) continue;
    const auto [least, is_first] = surest.emplace(fact.axis, sd(fact));
    least->second = std::min(least->second, sd(fact));
  }
  std::set<std::string> kept;
  std::erase_if(facts->all, [&](const Fact& fact) {
    if (!agrees(fact)) return false;
    return sd(fact) > surest.at(fact.axis) || !kept.insert(fact.axis).second;
  });
}

}  // namespace caltwin
