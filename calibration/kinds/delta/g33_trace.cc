#include "calibration/kinds/delta/g33_trace.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/delta/g33.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

// "  Ex:-0.35": a plus where it is above nought.
std::string Signed(const char* name, double value) {
  constexpr double kRounding = 1e-9;  // Of angles in rad and back.
  const double shown = std::abs(value) < kRounding ? 0 : value;
  return fmt::format("  {}:{}{:.2f}", name, shown > 0 ? "+" : "", shown);
}

constexpr std::size_t kNextLine = 13;
constexpr std::size_t kBeforeDeviation = 32;
constexpr std::size_t kBeforeDryDeviation = 35;

std::string Spaces(std::size_t num) {
  return std::string(num, ' ');
}

}  // namespace

void G33Trace::Begin(double radius_mm, const DeltaModel<double>& settings) {
  lines_.emplace_back("G33 Auto Calibrate");
  lines_.push_back(
      fmt::format("Checking... AC at radius:{:.2f}{}",
                  radius_mm,
                  options_.verbosity == G33Verbosity::kDryRun ? " (DRY-RUN)" : ""));
  Settings(settings);
}

void G33Trace::Settings(const DeltaModel<double>& settings) {
  // M666 takes no endstop above 0: the carriage backs off by it.
  const double height_mm = *std::ranges::min_element(settings.endstop_mm);
  const bool has_endstops = options_.points >= 2;
  const bool has_angles = options_.points >= 3 && options_.tower_angles;
  std::string line = fmt::format(".Height:{:.2f}", height_mm);
  constexpr std::array kEndstop = {"Ex", "Ey", "Ez"}, kAngle = {"Tx", "Ty", "Tz"};
  constexpr std::array kDrawn_deg = {210.0, 330.0, 90.0};
  for (std::size_t i = 0; has_endstops && i < kEndstop.size(); ++i) {
    line += Signed(kEndstop[i], height_mm - settings.endstop_mm[i]);
  }
  line += fmt::format("  Radius:{:.2f}", settings.radius_mm[0]);
  lines_.push_back(line);
  if (!has_angles) return;
  line = "." + Spaces(kNextLine);
  for (std::size_t i = 0; i < kAngle.size(); ++i) {
    line += Signed(kAngle[i], DegFromRad(settings.angle_rad[i]) - kDrawn_deg[i]);
  }
  lines_.push_back(line);
}

void G33Trace::Results(const G33Heights& heights_mm) {
  const bool is_asked = options_.verbosity == G33Verbosity::kDryRun ||
                        options_.verbosity == G33Verbosity::kResults;
  if (!is_asked) return;
  const bool is_full = options_.points >= 3;
  const bool has_towers = is_full || (options_.points == 2 && options_.tower_angles);
  const bool has_opposite = is_full || (options_.points == 2 && !options_.tower_angles);
  std::string line = ".    " + Signed("c", heights_mm[0]);
  if (has_towers) {
    line += Signed(" x", heights_mm[1]) + Signed(" y", heights_mm[3]) +
            Signed(" z", heights_mm[5]);
  }
  if (is_full) {
    lines_.push_back(line);
    line = "." + Spaces(kNextLine);
  }
  if (has_opposite) {
    line += Signed("yz", heights_mm[4]) + Signed("zx", heights_mm[6]) +
            Signed("xy", heights_mm[2]);
  }
  lines_.push_back(line);
}

void G33Trace::Iteration(int iterations,
                         double deviation_mm,
                         const DeltaModel<double>& settings) {
  constexpr int kMost = 31;
  const std::string head = iterations < kMost
                               ? fmt::format("Iteration : {:02}", iterations)
                               : "No convergence";
  lines_.push_back(
      fmt::format("{}{}std dev:{:.3f}", head, Spaces(kBeforeDeviation), deviation_mm));
  if (options_.verbosity > G33Verbosity::kEnds) Settings(settings);
}

void G33Trace::End(bool rolls_back,
                   double least_mm,
                   const DeltaModel<double>& settings) {
  lines_.push_back(
      "Calibration OK" + Spaces(kBeforeDeviation) +
      (rolls_back ? "rolling back." : fmt::format("std dev:{:.3f}", least_mm)));
  Settings(settings);
  lines_.emplace_back("Save with M500 and/or copy to Configuration.h");
}

void G33Trace::EndDryRun(double deviation_mm) {
  lines_.push_back(fmt::format(
      "End DRY-RUN{}std dev:{:.3f}", Spaces(kBeforeDryDeviation), deviation_mm));
}

void G33Trace::ProbeFailed() {
  lines_.emplace_back("Correct delta settings with M665 and M666");
}

}  // namespace caltwin
