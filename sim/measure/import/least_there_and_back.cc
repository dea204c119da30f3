#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// Positions in the order of the text, and what was read at each, there and back.
struct Curves {
  std::vector<double> at{};
  std::array<std::vector<double>, 2> read{};
  double step_um = kUnknown;
  bool has_heading = false;
};

bool HasAny(const std::string& lower, std::initializer_list<const char*> words) {
  return std::ranges::any_of(
      words, [&](const char* word) { return lower.find(word) != std::string::npos; });
}

// "position  HFR going out  HFR coming in": what is least at the best place, both ways.
bool IsHeading(const std::string& lower) {
  const bool is_size = HasAny(
      lower, {"hfr", "hfd", "fwhm", "size", "diameter", "width", "blur", "spot"});
  const bool is_both =
      (HasAny(lower, {"out"}) && HasAny(lower, {" in", "inward"})) ||
      (HasAny(lower, {" up"}) && HasAny(lower, {"down"})) ||
      (HasAny(lower, {"forward", "there"}) && HasAny(lower, {"back"})) ||
      (HasAny(lower, {"rising"}) && HasAny(lower, {"falling"}));
  return is_size && is_both;
}

// "one step = 4 um of drawtube", "0.004 mm per step"
double StepIn(const std::string& lower) {
  if (lower.find("step") == std::string::npos) return kUnknown;
  for (const auto& [unit, um] :
       {std::pair{" um", 1.0}, std::pair{" micron", 1.0}, std::pair{" mm", 1000.0}}) {
    const std::size_t at = lower.find(unit);
    if (at == std::string::npos) continue;
    if (const auto value = NumberBefore(lower, at)) return *value * um;
  }
  return kUnknown;
}

Curves CurvesIn(const std::string& text) {
  Curves curves;
  for (const TextLine& line : LinesOf(text)) {
    const std::string lower = Lowered(line.text);
    if (curves.at.empty()) curves.has_heading |= IsHeading(lower);
    if (const double step_um = StepIn(lower); Known(step_um)) curves.step_um = step_um;
    std::vector<double> numbers;
    for (const CsvField& word : line.words) {
      const auto number = NumberOf(word.text);
      if (!number) break;
      numbers.push_back(*number);
    }
    if (!curves.has_heading || numbers.size() != 3 || line.words.size() != 3) continue;
    curves.at.push_back(numbers[0]);
    curves.read[0].push_back(numbers[1]);
    curves.read[1].push_back(numbers[2]);
  }
  return curves;
}

/// Where a curve has its least.
struct Least {
  double at = kUnknown, sd = kUnknown, value = 0;
};

// The squares of such sizes lie on a parabola (a cone of light through focus): its
// vertex, by least squares over the places whose size is within twice the least.
Least LeastOf(const std::vector<double>& at, const std::vector<double>& read) {
  constexpr std::size_t kFewest = 5;
  constexpr double kWithin = 2;
  const auto lowest = std::ranges::min_element(read);
  const auto index = static_cast<std::size_t>(lowest - read.begin());
  if (index < 2 || index + 2 >= read.size() || *lowest <= 0) return {};
  // Moments about the lowest place: sums of u^k and of u^k y.
  std::array<double, 5> u{};
  std::array<double, 3> uy{};
  std::vector<std::pair<double, double>> points;
  const double unit = std::abs(at[1] - at[0]);
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (read[i] > kWithin * *lowest) continue;
    points.emplace_back((at[i] - at[index]) / unit, read[i] * read[i]);
  }
  if (points.size() < kFewest) return {};
  for (const auto& [x, y] : points) {
    for (std::size_t k = 0; k < u.size(); ++k) u[k] += std::pow(x, k);
    for (std::size_t k = 0; k < uy.size(); ++k) uy[k] += std::pow(x, k) * y;
  }
  const auto det = [](const std::array<double, 3>& a,
                      const std::array<double, 3>& b,
                      const std::array<double, 3>& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) +
           c[0] * (a[1] * b[2] - a[2] * b[1]);
  };
  const std::array one = {u[0], u[1], u[2]}, linear = {u[1], u[2], u[3]},
                   square = {u[2], u[3], u[4]};
  const double whole = det(one, linear, square);
  const double c = det(uy, linear, square) / whole, b = det(one, uy, square) / whole,
               a = det(one, linear, uy) / whole;
  if (!(a > 0)) return {};
  double left = 0;
  for (const auto& [x, y] : points) left += std::pow(y - c - b * x - a * x * x, 2);
  const double sd_y = std::sqrt(left / static_cast<double>(points.size() - 3));
  const double sd_b = sd_y / std::sqrt(u[2]);
  return {at[index] - b / (2 * a) * unit, sd_b / (2 * a) * unit, *lowest};
}

std::string TextOf(const Least& out, const Least& in, double step_um) {
  const double gap = out.at - in.at, sd = std::hypot(out.sd, in.sd);
  const std::string length =
      Known(step_um) ? fmt::format(" ({})", WithSd(gap * step_um, sd * step_um, "um"))
                     : std::string(" (how long a step is the text does not say)");
  return fmt::format(
      "Both runs have their least, as deep as each other, at {:.0f} on the way out and "
      "{:.0f} on the way back: {:.1f} steps apart{}. That is lost motion when the "
      "direction changes, and no other focus. Always come to the place from the same "
      "side, or let the controller take up {:.0f} steps",
      out.at,
      in.at,
      std::abs(gap),
      length,
      std::abs(gap));
}

}  // namespace

std::optional<Imported> LeastThereAndBackIn(const std::string& text) {
  constexpr std::size_t kFewest = 7;
  constexpr double kAsDeep = 0.25, kSure = 3;
  const Curves curves = CurvesIn(text);
  if (curves.at.size() < kFewest) return std::nullopt;
  const Least out = LeastOf(curves.at, curves.read[0]);
  const Least in = LeastOf(curves.at, curves.read[1]);
  if (!Known(out.at) || !Known(in.at)) return std::nullopt;
  const double gap = out.at - in.at, sd = std::hypot(out.sd, in.sd);
  Imported imported{
      .recognised = {fmt::format("two runs over {} positions, and the least of each",
                                 curves.at.size())}};
  const bool is_seen = std::abs(gap) > kSure * sd;
  if (!is_seen || std::abs(out.value / in.value - 1) > kAsDeep) {
    imported.notes.push_back(
        {.kind = FileNote::Kind::kOpen,
         .what = "backlash",
         .sentence = fmt::format(
             "lost motion: the leasts lie {:.1f} +- {:.1f} steps apart ({:.3g} and "
             "{:.3g} deep), which the scatter of the curves may be. Run both ways "
             "again "
             "with more positions near the least",
             gap,
             sd,
             out.value,
             in.value)});
    return imported;
  }
  FileNote note{.kind = FileNote::Kind::kFact,
                .sentence = TextOf(out, in, curves.step_um),
                .fact = "reversal",
                .word = "least",
                .figures = {{"gap_steps", gap, sd}}};
  if (Known(curves.step_um)) {
    note.figures.insert(note.figures.begin(),
                        {"gap_um", gap * curves.step_um, sd * curves.step_um});
    note.cause = "backlash";
    note.parameters = {
        {"gap_mm", MmFromUm(gap * curves.step_um), MmFromUm(sd * curves.step_um)}};
  }
  imported.notes.push_back(std::move(note));
  return imported;
}

}  // namespace caltwin
