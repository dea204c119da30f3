#include "calibration/kinds/triple_z/printer.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "calibration/loop/controller.h"
#include "sim/link/gcode.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr std::chrono::milliseconds kPrinterPatience{120'000};
constexpr double kClear_mm = 10;  // Nozzle over the bed where screws move singly.

std::string Word(char letter, double value) {
  return letter + GcodeNumber(value, 4);
}

}  // namespace

std::optional<double> StoppedHeight_mm(const std::vector<std::string>& lines) {
  constexpr std::string_view kKey = "Stopped at height ";
  for (const std::string& line : lines) {
    const std::size_t at = line.find(kKey);
    if (at == std::string::npos) continue;
    double value = 0;
    const auto read = std::from_chars(
        line.data() + at + kKey.size(), line.data() + line.size(), value);
    const bool ends = read.ptr == line.data() + line.size() || *read.ptr == ' ';
    constexpr double kHighest_mm = 1e4;
    if (read.ec == std::errc() && ends && std::abs(value) < kHighest_mm) return value;
  }
  return std::nullopt;
}

Expected<std::vector<std::string>> TripleZPrinter::Say(const std::string& line) {
  if (is_relative_) {
    is_relative_ = false;
    if (const auto absolute = Say("G90"); !absolute) return absolute;
  }
  return bench_.link->Send(line, kPrinterPatience);
}

Expected<void> TripleZPrinter::SayAll(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (const auto answer = Say(line); !answer) return tl::unexpected(answer.error());
  }
  return {};
}

Expected<void> TripleZPrinter::Home() {
  if (is_split_) {
    if (const auto joined = SayAll({"M584 Z0:1:2 P3"}); !joined) return joined;
    is_split_ = false;
  }
  if (const auto done = SayAll({"G28"}); !done) return done;
  Heard("G28");
  return {};
}

void TripleZPrinter::Heard(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string::npos) return;
  std::string code = line.substr(begin, line.find_first_of(" ;", begin) - begin);
  code[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(code[0])));
  if (code == "G28") {
    is_homed_ = true;
    ++homings_;
    are_heights_known_ = true;
    raised_mm_.setZero();
    z_mm_ = bench_.top_mm;
    return;
  }
  z_mm_.reset();
  if (code == "G91") is_relative_ = true;
  if (code == "G90" || code == "M999") is_relative_ = false;
  constexpr std::array kUnhome = {"M18", "M84", "M112", "M999"};
  if (std::ranges::find(kUnhome, code) != kUnhome.end()) {
    is_homed_ = false;
    LoseHeights();
  }
  constexpr std::array kLift = {"M584", "G92", "G30", "G32", "M92", "M98"};
  if (std::ranges::find(kLift, code) != kLift.end()) LoseHeights();
}

void TripleZPrinter::LoseHeights() {
  are_heights_known_ = false;
  z_mm_.reset();
}

Expected<void> TripleZPrinter::NeedHome() {
  return is_homed_ ? Expected<void>{} : Home();
}

Expected<void> TripleZPrinter::HomeIfNeeded() {
  return are_heights_known_ ? NeedHome() : Home();
}

Expected<double> TripleZPrinter::Probe(const Eigen::Vector2d& at_mm) {
  if (const auto homed = NeedHome(); !homed) return tl::unexpected(homed.error());
  const std::string line =
      "G30 " + Word('X', at_mm[0]) + " " + Word('Y', at_mm[1]) + " S-1";
  const auto answer = Say(line);
  if (!answer) return tl::unexpected(Classified(answer.error()));
  ++touches_;
  z_mm_.reset();  // As far over the touch as the firmware dives.
  if (const auto height_mm = StoppedHeight_mm(*answer)) return *height_mm;
  return tl::unexpected(
      MachineFault{.reply = fmt::format("Could not parse probe response '{}' to {}: is "
                                        "a probe configured (M558), and "
                                        "does the firmware answer 'Stopped at height'?",
                                        answer->empty() ? "" : answer->back(),
                                        line)});
}

ProbeReading TripleZPrinter::ReadProbeClear() {
  if (const auto clear = SayAll({"G1 " + Word('Z', bench_.top_mm / 2)}); !clear) {
    return ProbeReading::kUnknown;
  }
  z_mm_.reset();
  const auto answer = Say(kAskProbe);
  return answer ? ProbeReadingOf(*answer) : ProbeReading::kUnknown;
}

Expected<std::vector<BedTouch>> TripleZPrinter::ProbeAll(
    const std::vector<Eigen::Vector2d>& at_mm) {
  std::vector<BedTouch> touches;
  for (const Eigen::Vector2d& place_mm : at_mm) {
    const auto height_mm = Probe(place_mm);
    if (!height_mm) return tl::unexpected(height_mm.error());
    touches.push_back({place_mm, *height_mm});
  }
  return touches;
}

// Where the firmware has Z, exactly: what it prints is rounded, so it goes there.
Expected<double> TripleZPrinter::StandingZ() {
  if (z_mm_) return *z_mm_;
  const auto answer = Say("M114");
  if (!answer) return tl::unexpected(answer.error());
  for (const std::string& line : *answer) {
    const std::size_t at = line.find(" Z:");
    double z_mm = 0;
    if (at == std::string::npos ||
        std::sscanf(line.c_str() + at, " Z:%lf", &z_mm) != 1) {
      continue;
    }
    if (const auto there = SayAll({"G1 " + Word('Z', z_mm)}); !there) {
      return tl::unexpected(there.error());
    }
    z_mm_ = z_mm;
    return z_mm;
  }
  return tl::unexpected(
      MachineFault{.reply = fmt::format("Could not parse '{}' to M114: where is Z?",
                                        answer->empty() ? "" : answer->back())});
}

// Each driver to its own Z, which M584 leaves anywhere and unhomed: G92 says where it
// stands. Afterwards they are one axis again that stands at z_after.
Expected<void> TripleZPrinter::MoveScrews(const Vec3<double>& up_mm,
                                          double z_after_mm) {
  const auto z_mm = StandingZ();
  if (!z_mm) return tl::unexpected(z_mm.error());
  const Vec3<double> to_mm = Vec3<double>::Constant(*z_mm) - up_mm;
  z_mm_ = z_after_mm;
  const auto moved = SayAll({"M584 Z0 U1 V2 P5",
                             "G92 " + Word('U', *z_mm) + " " + Word('V', *z_mm),
                             "G1 " + Word('Z', to_mm[0]) + " " + Word('U', to_mm[1]) +
                                 " " + Word('V', to_mm[2]),
                             "M400",
                             "M584 Z0:1:2 P3",
                             "G92 " + Word('Z', z_after_mm)});
  if (!moved) {
    // One axis again, so that it can be homed; where the screws stand nobody knows.
    is_split_ = !SayAll({"M584 Z0:1:2 P3"});
    LoseHeights();
  }
  return moved;
}

Expected<void> TripleZPrinter::MoveTripleZ(double x_mm,
                                           double y_mm,
                                           const Vec3<double>& heights_mm) {
  for (int i = 0; i < kNumScrews; ++i) {
    if (heights_mm[i] >= 0 && heights_mm[i] <= bench_.top_mm) continue;
    return tl::unexpected(MachineFault{
        .reply = fmt::format("{} = {} is outside 0 .. {} mm: nothing moved",
                             ScrewName(i),
                             heights_mm[i],
                             bench_.top_mm)});
  }
  if (const auto homed = HomeIfNeeded(); !homed) return homed;
  if (const auto moved = SayAll({"G1 " + Word('X', x_mm) + " " + Word('Y', y_mm)});
      !moved) {
    return moved;
  }
  const auto z_mm = StandingZ();
  if (!z_mm) return tl::unexpected(z_mm.error());
  // Where they stand: top - z + raised; where they are to: heights. Screw 1 tells Z.
  const Vec3<double> now_mm =
      Vec3<double>::Constant(bench_.top_mm - *z_mm) + raised_mm_;
  const Vec3<double> up_mm = heights_mm - now_mm;
  raised_mm_ += up_mm - Vec3<double>::Constant(up_mm[0]);
  return MoveScrews(up_mm, *z_mm - up_mm[0]);
}

Expected<void> TripleZPrinter::Raise(const Vec3<double>& raise_mm) {
  if (const auto homed = NeedHome(); !homed) return homed;
  if (const auto clear = SayAll({"G1 " + Word('Z', kClear_mm)}); !clear) return clear;
  z_mm_ = kClear_mm;
  const auto moved = MoveScrews(raise_mm, kClear_mm);
  if (moved) raised_mm_ += raise_mm;
  return moved;
}

// "Leadscrew adjustments made: 0.100 -0.200 0.300, ..."; none: heights are lost.
void TripleZPrinter::CountAdjustments(const std::vector<std::string>& said) {
  constexpr std::string_view kMade = "Leadscrew adjustments made:";
  for (const std::string& line : said) {
    const std::size_t at = line.find(kMade);
    if (at == std::string::npos) continue;
    Vec3<double> made_mm = Vec3<double>::Zero();
    if (std::sscanf(line.c_str() + at + kMade.size(),
                    "%lf %lf %lf",
                    &made_mm[0],
                    &made_mm[1],
                    &made_mm[2]) == kNumScrews) {
      raised_mm_ += made_mm;
      return;
    }
  }
  LoseHeights();
}

Expected<std::vector<std::string>> TripleZPrinter::Level(
    const std::vector<Eigen::Vector2d>& at_mm) {
  if (const auto homed = NeedHome(); !homed) return tl::unexpected(homed.error());
  std::vector<std::string> said;
  for (std::size_t i = 0; i < at_mm.size(); ++i) {
    std::string line = fmt::format("G30 P{} ", i) + Word('X', at_mm[i][0]) + " " +
                       Word('Y', at_mm[i][1]) + " Z-99999";
    if (i + 1 == at_mm.size()) line += " S3";
    const auto answer = Say(line);
    if (!answer) return tl::unexpected(answer.error());
    said.insert(said.end(), answer->begin(), answer->end());
    ++touches_;
    z_mm_.reset();
  }
  CountAdjustments(said);
  return said;
}

Expected<void> TripleZPrinter::SetPivots(const Pivots<double>& pivots_mm) {
  const auto three = [&](int i) {
    return fmt::format(
        "{:.2f}:{:.2f}:{:.2f}", pivots_mm[0][i], pivots_mm[1][i], pivots_mm[2][i]);
  };
  return SayAll({"M671 X" + three(0) + " Y" + three(1)});
}

Expected<Pivots<double>> TripleZPrinter::ReadPivots() {
  const auto answer = Say("M671");
  if (!answer) return tl::unexpected(answer.error());
  Pivots<double> read_mm;
  for (const std::string& line : *answer) {
    std::array<double, 6> n{};
    if (std::sscanf(line.c_str(),
                    "leadscrews at (%lf, %lf), (%lf, %lf), (%lf, %lf)",
                    &n[0],
                    &n[1],
                    &n[2],
                    &n[3],
                    &n[4],
                    &n[5]) != 6) {
      continue;
    }
    for (std::size_t i = 0; i < read_mm.size(); ++i) {
      read_mm[i] = {n[2 * i], n[2 * i + 1]};
    }
    return read_mm;
  }
  return tl::unexpected(MachineFault{
      .reply = fmt::format("Could not parse '{}' to M671: are three leadscrews set?",
                           answer->empty() ? "" : answer->back())});
}

std::vector<Eigen::Vector2d> ProbeGrid(const TripleZBench& bench,
                                       int columns,
                                       int rows,
                                       double margin_mm) {
  const auto along = [&](double most_mm, int i, int count) {
    return margin_mm + (most_mm - 2 * margin_mm) * i / (count - 1);
  };
  std::vector<Eigen::Vector2d> points;
  for (int j = 0; j < rows; ++j) {
    for (int k = 0; k < columns; ++k) {
      const int i = j % 2 == 0 ? k : columns - 1 - k;
      points.emplace_back(along(bench.most_mm[0], i, columns),
                          along(bench.most_mm[1], j, rows));
    }
  }
  return points;
}

TripleZBench BenchOf(const Machine& machine, Link* link, double sigma_mm) {
  constexpr double kBest_mm = 1e-3;  // No touch is believed to scatter by less.
  // A touch is counted in whole steps: as uniform as its scatter is normal.
  const double step_mm = 1 / machine.settings.steps_per_mm[2];
  return {
      .link = link,
      .drawn_mm = TripleZOf(machine).pivots_mm(),
      .top_mm = TripleZOf(machine).top_mm,
      .most_mm =
          Eigen::Vector2d(machine.axis(Axis::kX).max_mm, machine.axis(Axis::kY).max_mm),
      .sigma_mm = std::max(std::hypot(sigma_mm, step_mm / std::sqrt(12.0)), kBest_mm),
      .is_sigma_stated = sigma_mm > 0};
}

}  // namespace caltwin
