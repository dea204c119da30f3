#include "renders/compare_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "renders/chart.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

std::string Um(double value_um) {
  return LengthText(MmFromUm(value_um));
}

bool HasFigure(const Contender& one) {
  return one.failures < one.machines && one.error_um.median > 0;
}

// The least median among those that fail on no more machines than the steadiest.
const Contender* Best(const std::vector<Contender>& contenders) {
  const Contender* best = nullptr;
  for (const Contender& one : contenders) {
    if (!HasFigure(one)) continue;
    const bool is_better =
        best == nullptr || one.failures < best->failures ||
        (one.failures == best->failures && one.error_um.median < best->error_um.median);
    if (is_better) best = &one;
  }
  return best;
}

std::string VerdictSentence(const std::vector<Contender>& contenders) {
  const Contender* const best = Best(contenders);
  if (best == nullptr) return "No procedure told a value on these machines.";
  return fmt::format(
      "{} leaves least: {} (median of {} machines), {} on 95 of 100; {}.",
      best->name,
      Um(best->error_um.median),
      best->machines,
      Um(best->error_um.p95),
      best->failures == 0 ? "it never failed"
                          : fmt::format("it failed on {}", best->failures));
}

// One contender a row: the median with its interval, and a tick where 95 of 100 end.
std::string Drawing(const std::vector<Contender>& contenders) {
  constexpr double kWide = 760, kNames = 210, kRow = 26, kFoot = 40, kRight = 112;
  double low = INFINITY, high = 0;
  for (const Contender& one : contenders) {
    if (!HasFigure(one)) continue;
    low = std::min(low, one.error_um.median);
    high = std::max(high, one.error_um.p95);
  }
  if (!(high > 0)) return "";
  low = std::pow(10, std::floor(std::log10(low)));
  high = std::pow(10, std::ceil(std::log10(high)));
  const auto x = [&](double um) {
    return kNames + (kWide - kNames - kRight) *
                        std::log10(std::clamp(um, low, high) / low) /
                        std::log10(high / low);
  };
  const double bottom = kRow * static_cast<double>(contenders.size()) + 4;
  std::string svg = SvgOpen(kWide, bottom + kFoot, "what each procedure leaves");
  const auto decades = std::lround(std::log10(high / low));
  for (long decade = 0; decade <= decades; ++decade) {
    const double tick = low * std::pow(10, static_cast<double>(decade));
    svg += fmt::format(
        "<path d=\"M{:.1f} 2V{:.1f}\" {}/>\n", x(tick), bottom, StrokeOf(Ink::kGrid));
    svg += SvgText(x(tick), bottom + 15, Um(tick), "middle", Ink::kDim, 11);
  }
  double y = kRow / 2;
  for (const Contender& one : contenders) {
    svg += SvgText(kNames - 10, y + 4, one.name, "end");
    if (HasFigure(one)) {
      const Spread& error_um = one.error_um;
      if (std::isfinite(error_um.low)) {
        svg +=
            fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke-width=\"2\" {}/>\n",
                        x(error_um.low),
                        y,
                        x(error_um.high),
                        StrokeOf(Ink::kAfter));
      }
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" {}/>\n",
                         x(error_um.median),
                         y,
                         FillOf(Ink::kAfter));
      svg += fmt::format("<path d=\"M{:.1f} {:.1f}v12\" stroke-width=\"2\" {}/>\n",
                         x(error_um.p95),
                         y - 6,
                         StrokeOf(Ink::kBefore));
    }
    const std::string failed =
        one.failures == 0 ? ""
                          : fmt::format("{} of {} failed", one.failures, one.machines);
    svg += SvgText(kWide - kRight + 8, y + 4, failed, "start", Ink::kDim, 11);
    y += kRow;
  }
  return svg + "</svg>\n";
}

std::string About(const std::vector<Contender>& contenders) {
  std::string rows;
  for (const Contender& one : contenders) {
    rows += fmt::format(
        "<tr><th scope=\"row\"><code>{}</code></th><td class=\"words\">{}</td>{}{}{}"
        "</tr>\n",
        Escaped(one.name),
        Escaped(one.about),
        NumberCell(HasFigure(one) ? Um(one.error_um.median) : "–"),
        NumberCell(HasFigure(one) ? Um(one.error_um.p95) : "–"),
        NumberCell(fmt::format("{}", one.failures)));
  }
  return TableHtml("A dash: it told nothing on any machine.",
                   {"procedure", "what it is", "median", "95 of 100", "failed"},
                   rows);
}

}  // namespace

Document CompareDocument(const std::vector<Contender>& contenders,
                         const CompareNotes& notes) {
  const std::string drawing = Drawing(contenders);
  const int machines = contenders.empty() ? 0 : contenders.front().machines;
  return {.kind = "comparison",
          .name = notes.kind,
          .about = "The same machines for every procedure, in closed form.",
          .tone = Tone::kPlain,
          .verdict = VerdictSentence(contenders),
          .tiles = {{"machines", fmt::format("{}", machines)},
                    {"procedures", fmt::format("{}", contenders.size())},
                    {"caltwin", CALTWIN_VERSION}},
          .sections = {{"standings",
                        "What each leaves",
                        FigureHtml("Error after the procedure",
                                   "dot: the median over the machines, with its 95 % "
                                   "interval; tick: 95 of 100 machines end below it. "
                                   "Logarithmic.",
                                   drawing)},
                       {"procedures", "The procedures", About(contenders)},
                       {"text",
                        "The standings as printed",
                        fmt::format("<pre>{}</pre>\n", Escaped(notes.text))},
                       {"provenance",
                        "How to make this report again",
                        fmt::format("<pre><code>{}</code></pre>\n",
                                    Escaped(notes.command))}},
          .drawings = {{"standings", drawing}}};
}

}  // namespace caltwin
