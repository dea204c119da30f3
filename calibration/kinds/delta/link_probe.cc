#include "calibration/kinds/delta/link_probe.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "calibration/kinds/delta/foretold_mesh.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

// A G33 touches hundreds of times.
constexpr std::chrono::milliseconds kLinkProbePatience{60'000}, kPatienceG33{3'600'000};

bool AreSame(const DeltaModel<double>& one, const DeltaModel<double>& other) {
  return one.endstop_mm == other.endstop_mm && one.radius_mm == other.radius_mm &&
         one.angle_rad == other.angle_rad && one.arm_mm == other.arm_mm;
}

// The number behind `Z: ` of "Bed X: 1.00 Y: 2.00 Z: 0.123".
std::optional<double> BedHeight_mm(const std::string& line) {
  constexpr std::string_view kKey = " Z: ";
  const std::size_t at = line.find(kKey);
  if (!line.starts_with("Bed X:") || at == std::string::npos) return std::nullopt;
  double value = 0;
  const char* from = line.data() + at + kKey.size();
  const auto read = std::from_chars(from, line.data() + line.size(), value);
  if (read.ec != std::errc()) return std::nullopt;
  return value;
}

}  // namespace

DeltaProbe DeltaLinkProbe::AsProbe() {
  return [this](const DeltaModel<double>& settings, double x_mm, double y_mm) {
    return Touch(settings, x_mm, y_mm);
  };
}

void DeltaLinkProbe::Set(const DeltaModel<double>& settings) {
  if (AreSame(settings, sent_)) return;
  std::istringstream lines(AsMarlin(settings, drawn_));
  for (std::string line; std::getline(lines, line);) Say(line);
  sent_ = settings;
  is_homed_ = false;
}

void DeltaLinkProbe::Set(const DeltaMesh& mesh) {
  std::istringstream lines(MeshAsMarlin(mesh));
  for (std::string line; std::getline(lines, line);) Say(line);
}

std::vector<std::string> DeltaLinkProbe::Say(const std::string& line) {
  const auto answer =
      link_->Send(line, line.starts_with("G33") ? kPatienceG33 : kLinkProbePatience);
  if (answer) return *answer;
  if (!fault_) {
    fault_ = fmt::format("{}: {}", line, answer.error().reply);
    fault_kind_ = answer.error().kind;
  }
  return {answer.error().reply};
}

std::optional<Vec3<double>> DeltaLinkProbe::Touch(const DeltaModel<double>& settings,
                                                  double x_mm,
                                                  double y_mm) {
  Set(settings);
  if (!is_homed_) {
    Say("G28");
    is_homed_ = true;
  }
  if (fault_) return std::nullopt;
  for (const std::string& line : Say(fmt::format("G30 X{:.4f} Y{:.4f}", x_mm, y_mm))) {
    if (const auto height_mm = BedHeight_mm(line)) {
      return DeltaMotors_mm<double>(settings, {x_mm, y_mm, *height_mm});
    }
  }
  if (!fault_) was_out_of_reach_ = true;
  return std::nullopt;
}

std::vector<Eigen::Vector2d> DiscPoints(int count, double radius_mm) {
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double out_mm = radius_mm * std::sqrt(i / std::max(count - 1.0, 1.0));
    points.emplace_back(out_mm * std::cos(golden_rad * i),
                        out_mm * std::sin(golden_rad * i));
  }
  return points;
}

}  // namespace caltwin
