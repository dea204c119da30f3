#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renders/chart.h"
#include "renders/diagnosis_pictures.h"

// The pictures that are tables: the evidence map, and lack of fit by campaign.
namespace caltwin {
namespace {

constexpr double kWidth = 760;

struct Named {
  std::string_view word, shown;
};
constexpr std::array<Named, 18> kCovariates = {{{"x", "X"},
                                                {"y", "Y"},
                                                {"z", "Z"},
                                                {"dir_x", "sense of X"},
                                                {"dir_y", "sense of Y"},
                                                {"dir_z", "sense of Z"},
                                                {"motor_a", "travel of A"},
                                                {"motor_b", "travel of B"},
                                                {"motor_c", "travel of C"},
                                                {"dir_a", "sense of A"},
                                                {"dir_b", "sense of B"},
                                                {"dir_c", "sense of C"},
                                                {"since_rev", "since reversal"},
                                                {"t", "time"},
                                                {"temp", "temper- ature"},
                                                {"feed", "feed"},
                                                {"load", "load"},
                                                {"theta", "touch direction"}}};
constexpr std::array<Named, 8> kChannels = {{{"x", "X moves wrongly"},
                                             {"y", "Y moves wrongly"},
                                             {"z", "Z moves wrongly"},
                                             {"a", "carriage A errs"},
                                             {"b", "carriage B errs"},
                                             {"c", "carriage C errs"},
                                             {"probe", "the probe"},
                                             {"bed", "the bed"}}};

// White below nothing, deep orange at the best.
std::string Heat(double log_odds, double most) {
  constexpr double kFloor = 3;  // Odds of 20:1.
  if (log_odds < kFloor) return "#f1f2f4";
  const double part = std::clamp(
      std::log(log_odds / kFloor + 1) / std::log(most / kFloor + 1), 0.0, 1.0);
  const auto mix = [part](double from, double to) {
    return static_cast<int>(std::lround(from + (to - from) * part));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(253, 216), mix(236, 104), mix(221, 32));
}

// The words of one list that occur in the cells, in the list's order.
template <std::size_t kSize>
std::vector<Named> Occurring(const std::array<Named, kSize>& all,
                             const std::vector<EvidenceCell>& cells,
                             std::string EvidenceCell::*which) {
  std::vector<Named> occurring;
  for (const Named& one : all) {
    const bool occurs = std::ranges::any_of(
        cells, [&](const EvidenceCell& cell) { return cell.*which == one.word; });
    if (occurs) occurring.push_back(one);
  }
  return occurring;
}

// Parted where it is nearest to the middle.
std::vector<std::string> TwoLines(const std::string& text, char at) {
  constexpr std::size_t kShort = 7;
  std::size_t best = std::string::npos;
  const auto off = [&](std::size_t i) {
    return std::abs(2 * static_cast<double>(i) - static_cast<double>(text.size()));
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != at) continue;
    if (best == std::string::npos || off(i) < off(best)) best = i;
  }
  if (best == std::string::npos || text.size() <= kShort) return {text};
  return {text.substr(0, best), text.substr(best + 1)};
}

// The size, `wanted` or smaller, at which a text is no wider than `width`.
double FittingSize(std::string_view text, double wanted, double width) {
  return std::min(wanted, wanted * width / std::max(TextWidth(text, wanted), 1.0));
}

std::string CellSvg(const EvidenceCell& cell,
                    double left,
                    double top,
                    double width,
                    double height,
                    double most) {
  std::string svg = fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"3\" "
      "fill=\"{}\"/>\n",
      left + 1.5,
      top + 1.5,
      width - 3,
      height - 3,
      Heat(cell.log_odds, most));
  // On a light fill in either scheme of the page, hence without an ink's class.
  const auto text = [&](double y, double size, std::string_view said) {
    return fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.1f}\" text-anchor=\"middle\" "
        "fill=\"#1b1e22\">{}</text>\n",
        left + width / 2,
        y,
        size,
        said);
  };
  svg += text(
      top + 19, 13, fmt::format("{:.{}f}", cell.log_odds, cell.log_odds < 10 ? 1 : 0));
  double y = top + 32;
  for (const std::string& line : TwoLines(cell.cause, '_')) {
    svg += text(y, FittingSize(line, 10, width - 6), line);
    y += 11;
  }
  return svg;
}

}  // namespace

DiagnosisPicture EvidencePicture(const PicturesData& data) {
  DiagnosisPicture picture{
      .name = "evidence_map",
      .title = "Where the residual is, and what it depends on",
      .caption =
          "Before anything was accepted: the log odds (natural) against \"nothing "
          "there\" of the best candidate that shows in a row's channel and depends "
          "on a column's covariate, and its name. Above 3 (odds of 20 to 1) it "
          "is coloured. A strong cause lights up every cell that resembles it; "
          "only the best is meant."};
  if (data.evidence_map.empty()) return picture;
  if (data.findings.empty()) {
    picture.caption += " Here nothing passed the checks of a finding.";
  }
  const auto columns =
      Occurring(kCovariates, data.evidence_map, &EvidenceCell::covariate);
  const auto rows = Occurring(kChannels, data.evidence_map, &EvidenceCell::channel);
  if (columns.empty() || rows.empty()) return picture;
  constexpr double kLeft = 116, kTop = 36, kRow = 52;
  const double width =
      std::min(120.0, (kWidth - kLeft - 6) / static_cast<double>(columns.size()));
  const double most = std::max(
      20.0, std::ranges::max(data.evidence_map, {}, &EvidenceCell::log_odds).log_odds);
  std::string svg = SvgOpen(
      kWidth, kTop + kRow * static_cast<double>(rows.size()) + 6, picture.title);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double middle = kLeft + width * (static_cast<double>(c) + 0.5);
    const auto lines = TwoLines(std::string(columns[c].shown), ' ');
    double y = lines.size() > 1 ? 14 : 27;
    for (const std::string& line : lines) {
      const double size = FittingSize(line, 12, width - 4);
      svg += SvgText(middle, y, line, "middle", Ink::kText, size);
      y += 13;
    }
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double top = kTop + kRow * static_cast<double>(r);
    svg += SvgText(kLeft - 8, top + 30, rows[r].shown, "end");
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (const EvidenceCell& cell : data.evidence_map) {
        if (cell.channel != rows[r].word || cell.covariate != columns[c].word) continue;
        svg += CellSvg(
            cell, kLeft + width * static_cast<double>(c), top, width, kRow, most);
      }
    }
  }
  picture.svg = svg + "</svg>\n";
  return picture;
}

namespace {

// Where the bars of lack of fit begin and end.
constexpr double kLeft = 190, kRight = 84, kTop = 28, kRow = 46;

// One campaign: two bars and the scatter of replicates.
std::string FitSvg(const LackOfFit& fit, double top, double most) {
  constexpr double kBar = 13;
  const auto x = [most](double um) {
    return kLeft + (kWidth - kLeft - kRight) * um / most;
  };
  std::string svg;
  svg += SvgText(kLeft - 10, top + 17, fit.campaign, "end");
  const bool repeats = std::isfinite(fit.pure_error_um);
  svg += SvgText(kLeft - 10,
                 top + 31,
                 fmt::format("{} rows, {} repeated", fit.rows, fit.replicate_dof),
                 "end",
                 Ink::kDim,
                 10.5);
  double y = top + 5;
  for (const auto& [um, ink] :
       {std::pair{fit.before_um, Ink::kBefore}, {fit.after_um, Ink::kAfter}}) {
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>\n",
        kLeft,
        y,
        std::max(x(um) - kLeft, 0.5),
        kBar,
        FillOf(ink));
    svg += SvgText(
        x(um) + 6, y + 11, fmt::format("{:.2f} µm", um), "start", Ink::kText, 11);
    y += kBar + 2;
  }
  svg +=
      fmt::format("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke-width=\"2\" {3}{4}/>\n",
                  x(repeats ? fit.pure_error_um : fit.sigma_um),
                  top + 2,
                  top + 36,
                  repeats ? "" : "stroke-dasharray=\"3 2\" ",
                  StrokeOf(Ink::kText));
  return svg;
}

}  // namespace

DiagnosisPicture LackOfFitPicture(const PicturesData& data) {
  DiagnosisPicture picture{
      .name = "lack_of_fit",
      .title = "What is left, against what repeated readings scatter by",
      .caption =
          "The rms of each campaign's residual with the baseline alone and with "
          "the findings. The line is the scatter of repeated readings (dashed: "
          "none were repeated; the noise as judged): what is left beyond it "
          "repeats, and is not explained."};
  if (data.lack_of_fit.empty()) return picture;
  double most = 1e-9;
  for (const LackOfFit& fit : data.lack_of_fit) {
    most = std::max({most, fit.before_um, fit.after_um, fit.sigma_um});
  }
  std::string svg = SvgOpen(kWidth,
                            kTop + kRow * static_cast<double>(data.lack_of_fit.size()),
                            picture.title);
  double legend = kLeft;
  for (const auto& [ink, label] : {std::pair{Ink::kBefore, "baseline alone"},
                                   {Ink::kAfter, "with the findings"}}) {
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"6\" width=\"14\" height=\"11\" {}/>\n",
                       legend,
                       FillOf(ink));
    svg += SvgText(legend + 20, 16, label);
    legend += 40 + TextWidth(label);
  }
  for (std::size_t c = 0; c < data.lack_of_fit.size(); ++c) {
    svg += FitSvg(data.lack_of_fit[c], kTop + kRow * static_cast<double>(c), most);
  }
  picture.svg = svg + "</svg>\n";
  return picture;
}

}  // namespace caltwin
