#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/kinds/compare_measured.h"

namespace caltwin {
namespace {

// With one digit more than was measured there.
std::string ShownFigure(double value, double last_digit, int more) {
  const int digits =
      std::max(0, static_cast<int>(std::lround(-std::log10(last_digit))) + more);
  const bool is_zero = std::abs(value) < std::pow(10.0, -digits) / 2;
  return fmt::format("{:.{}f}", is_zero ? 0.0 : value, digits);
}

bool IsMet(const MeasuredTask& task) {
  return std::ranges::all_of(task.figures, &MeasuredFigure::is_met);
}

}  // namespace

std::string MeasuredDeltaText(const std::vector<MeasuredTask>& tasks) {
  std::string text =
      "the machine measured elsewhere: radius +0.8 mm, angles +0.35 and -0.25 deg, "
      "endstops +0.30 -0.20 +0.45 mm;\nrods: all six 0.6 mm longer; tilt: bed 2 and -1 "
      "mrad. A figure is met within its last digit, with noise within a tenth\n\n";
  text += fmt::format("{:<9}{:<36}{:>6}  {:<12}{:>8}{:>10}  {}\n",
                      "engine",
                      "task",
                      "draws",
                      "figure",
                      "there",
                      "here",
                      "met");
  for (const MeasuredTask& task : tasks) {
    bool is_first = true;
    for (const MeasuredFigure& figure : task.figures) {
      text += fmt::format(
          "{:<9}{:<36}{:>6}  {:<12}{:>8}{:>10}  {}\n",
          is_first ? task.engine : "",
          is_first ? task.task : "",
          is_first ? fmt::format("{}", task.draws) : "",
          figure.name,
          figure.there ? ShownFigure(*figure.there, figure.last_digit, 0) : "-",
          ShownFigure(figure.here, figure.last_digit, 1),
          !figure.there   ? "-"
          : figure.is_met ? "yes"
                          : "NO");
      is_first = false;
    }
    if (!IsMet(task) && !task.note.empty()) {
      text += fmt::format("{:9}{}\n", "", task.note);
    }
  }
  return text;
}

nlohmann::ordered_json MeasuredDeltaJson(const std::vector<MeasuredTask>& tasks,
                                         std::uint64_t seed) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const MeasuredTask& task : tasks) {
    nlohmann::ordered_json figures = nlohmann::ordered_json::array();
    for (const MeasuredFigure& figure : task.figures) {
      figures.push_back({{"name", figure.name},
                         {"there",
                          figure.there ? nlohmann::ordered_json(*figure.there)
                                       : nlohmann::ordered_json(nullptr)},
                         {"here", figure.here},
                         {"met", figure.is_met}});
    }
    rows.push_back({{"engine", task.engine},
                    {"task", task.task},
                    {"draws", task.draws},
                    {"figures", figures},
                    {"note", task.note}});
  }
  return {{"format", 1},
          {"kind", "delta"},
          {"machine", "measured"},
          {"seed", seed},
          {"rows", rows}};
}

}  // namespace caltwin
