#include "tools/commands/import_account.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/correlation.h"
#include "calibration/kinds/delta/klipper_fit.h"
#include "calibration/kinds/delta/mesh_shape.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/kinds/klipper_delta.h"
#include "sim/measure/import/klipper_mesh.h"

namespace caltwin {
namespace {

constexpr double kTouch_mm = MmFromUm(10.0);

std::string UmImportAccount(double mm) {
  const double um = UmFromMm(mm);
  return fmt::format("{:.1f}", std::abs(um) < 0.05 ? 0.0 : um);
}

std::string DeviationsText(const KlipperFit& fit, const DeltaModel<double>& saved) {
  const auto arc_mm = [&](std::size_t i) {
    return (fit.model.angle_rad[i] - saved.angle_rad[i]) * saved.radius_mm[0];
  };
  std::string text = fmt::format(
      "fit less saved [um]: delta radius {}, endstops {} {} {}, towers a, b along "
      "their "
      "circle {} {}",
      UmImportAccount(fit.model.radius_mm[0] - saved.radius_mm[0]),
      UmImportAccount(fit.model.endstop_mm[0] - saved.endstop_mm[0]),
      UmImportAccount(fit.model.endstop_mm[1] - saved.endstop_mm[1]),
      UmImportAccount(fit.model.endstop_mm[2] - saved.endstop_mm[2]),
      UmImportAccount(arc_mm(0)),
      UmImportAccount(arc_mm(1)));
  if (fit.last_step.x.size() == kKlipperNine) {
    text += fmt::format(", arms {} {} {}",
                        UmImportAccount(fit.model.arm_mm[0] - saved.arm_mm[0]),
                        UmImportAccount(fit.model.arm_mm[1] - saved.arm_mm[1]),
                        UmImportAccount(fit.model.arm_mm[2] - saved.arm_mm[2]));
  }
  return text;
}

std::string VerdictText(const KlipperAssessment& assessment) {
  switch (assessment.verdict) {
    case SavedVerdict::kBelongs:
      return "the saved geometry belongs to these touches";
    case SavedVerdict::kMovedTogether:
      return fmt::format(
          "all endstops were moved by {} um after the calibration (a new z offset?); "
          "the "
          "rest belongs to these touches",
          UmImportAccount(assessment.saved_mean_mm));
    case SavedVerdict::kStale:
      return "STALE: the saved geometry does not belong to these touches. It was "
             "changed "
             "by hand, or is another calibration's: run DELTA_CALIBRATE again";
  }
  return "";
}

std::string HoldOutText(const KlipperAssessment& assessment) {
  if (!assessment.hold_out_rms_mm) {
    return "too few readings to leave one out";
  }
  return fmt::format(
      "each touch foretold by all other readings: {} um rms ({} reading{} beyond the "
      "{} "
      "numbers fitted{})",
      UmImportAccount(*assessment.hold_out_rms_mm),
      assessment.spare,
      assessment.spare == 1 ? "" : "s",
      assessment.fit.last_step.x.size(),
      assessment.spare <= 1 ? ": it checks next to nothing" : "");
}

std::string SdText(const KlipperFit& fit) {
  if (!fit.last_step.identifiable) {
    return fmt::format("the readings determine {} of {} numbers",
                       fit.last_step.rank,
                       fit.last_step.x.size());
  }
  std::string text = "standard deviations [um] if a touch is good to 10 um:";
  for (Eigen::Index i = 0; i < fit.last_step.x.size(); ++i) {
    text += fmt::format("{} {} {}",
                        i == 0 ? "" : ",",
                        kKlipperNames[static_cast<std::size_t>(i)],
                        UmImportAccount(fit.last_step.sd(i)));
  }
  return text;
}

// What the readings themselves leave says more of them than a guess, where some are to
// spare.
std::string OwnScatterText(const KlipperAssessment& assessment,
                           std::size_t num_distances,
                           double distance_sigma_mm) {
  if (assessment.spare < 1) return "";
  const KlipperFit& fit = assessment.fit;
  double left_mm2 =
      std::pow(fit.height_rms_mm, 2) * static_cast<double>(fit.residuals_mm.size());
  if (num_distances > 0) {
    left_mm2 += std::pow(fit.distance_rms_mm * kTouch_mm / distance_sigma_mm, 2) *
                static_cast<double>(num_distances);
  }
  const double own_mm = std::sqrt(left_mm2 / assessment.spare);
  return fmt::format(
      "what the fit leaves is that of touches good to {} um ({} degree{} of "
      "freedom{}): the standard deviations are then {:.1f} times as large",
      UmImportAccount(own_mm),
      assessment.spare,
      assessment.spare == 1 ? "" : "s",
      assessment.spare == 1 ? ", so known within a factor of a few" : "",
      own_mm / kTouch_mm);
}

std::string CorrelatedText(const KlipperFit& fit) {
  const auto count = static_cast<std::size_t>(fit.last_step.x.size());
  const std::vector<std::string> names(kKlipperNames.begin(),
                                       kKlipperNames.begin() + count);
  if (!fit.last_step.identifiable) return "";
  const std::string pairs =
      MostCorrelatedText(CorrelationsOf("klipper", names, fit.last_step.covariance));
  return pairs.empty() ? "" : "most correlated: " + pairs;
}

/// The readings as the fit takes them, weighed as Klipper weighs.
struct Readings {
  std::vector<DeltaTouch> touches{};
  std::vector<DeltaDistance> distances{};
  double distance_sigma_mm = 0;
};

Readings ReadingsOf(const KlipperCalibration& read) {
  Readings readings;
  std::size_t num_probed = 0;
  for (const KlipperTouch& touch : read.touches) {
    readings.touches.push_back({.motors_mm = touch.motors_mm,
                                .height_mm = touch.height_mm,
                                .sigma_mm = kTouch_mm});
    if (!touch.is_manual) ++num_probed;
  }
  readings.distance_sigma_mm =
      KlipperDistanceSigma_mm(kTouch_mm, num_probed, read.distances.size());
  for (const KlipperDistance& distance : read.distances) {
    readings.distances.push_back({.length_mm = distance.length_mm,
                                  .from_mm = distance.from_mm,
                                  .to_mm = distance.to_mm,
                                  .sigma_mm = readings.distance_sigma_mm});
  }
  return readings;
}

std::string DistancesText(double off_mm, double sigma_mm) {
  constexpr double kTooMuch_mm = MmFromUm(100.0);
  return fmt::format(
      "distances on the print: {} um rms; Klipper weighs them as if good to {} um{}",
      UmImportAccount(off_mm),
      UmImportAccount(sigma_mm),
      off_mm > kTooMuch_mm ? ". They contradict each other, or the heights: measure "
                             "again before you believe the arms"
                           : "");
}

// Why a geometry may not belong to its touches though nobody changed all of it.
std::vector<std::string> StaleTexts(const KlipperCalibration& read,
                                    const KlipperFit& fit,
                                    const ImportOptions& import) {
  constexpr double kSame_mm = MmFromUm(1.0);
  constexpr double kSameStep = 0.005;
  const DeltaModel<double>& saved = read.geometry.model;
  double most_mm = 0;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    most_mm =
        std::max(most_mm, std::abs(fit.model.endstop_mm[i] - saved.endstop_mm[i]));
  }
  if (most_mm < kSame_mm) {
    return {
        "its endstops are those of these touches: delta radius or angles were "
        "changed after them"};
  }
  const double likely_mm = LikelyStep_mm(read.geometry, read.touches);
  const bool is_doubtful = import.step_mm && Known(likely_mm) &&
                           std::abs(likely_mm / *import.step_mm - 1) > kSameStep;
  if (!is_doubtful) return {};
  return {
      fmt::format("or --step-mm {:g} is not this machine's motor step: the touch "
                  "nearest to the middle suggests {:.3g}, if the endstops are "
                  "theirs",
                  *import.step_mm,
                  likely_mm)};
}

std::vector<std::string> DeltaAccount(const KlipperCalibration& read,
                                      const ImportOptions& import) {
  const Readings readings = ReadingsOf(read);
  const KlipperAssessment assessment =
      AssessKlipper(readings.touches, readings.distances, read.geometry.model);
  if (!assessment.fit.is_converged) {
    return {"a fit of Klipper's model to these touches does not converge"};
  }
  std::vector<std::string> lines = {
      VerdictText(assessment),
      fmt::format(
          "heights: {} um rms as saved, {} um by a fit of Klipper's own {} numbers",
          UmImportAccount(assessment.saved_rms_mm),
          UmImportAccount(assessment.fit.height_rms_mm),
          assessment.fit.last_step.x.size()),
      DeviationsText(assessment.fit, read.geometry.model),
      HoldOutText(assessment),
      SdText(assessment.fit)};
  const std::vector<std::string> more = {
      OwnScatterText(assessment, readings.distances.size(), readings.distance_sigma_mm),
      CorrelatedText(assessment.fit)};
  for (const std::string& line : more) {
    if (!line.empty()) lines.push_back(line);
  }
  if (assessment.verdict == SavedVerdict::kStale) {
    const auto why = StaleTexts(read, assessment.fit, import);
    lines.insert(lines.begin() + 1, why.begin(), why.end());
  }
  if (!readings.distances.empty()) {
    lines.push_back(
        DistancesText(assessment.fit.distance_rms_mm, readings.distance_sigma_mm));
  }
  lines.push_back(
      fmt::format("heights alone do not tell the arms: 1 mm longer, they fit to {} um "
                  "rms with a delta "
                  "radius {:+.3f} mm, and prints differ by {:.2f} %",
                  UmImportAccount(assessment.longer_arms_rms_mm),
                  assessment.longer_arms_radius_mm,
                  PercentFromFraction(std::abs(assessment.longer_arms_scale))));
  return lines;
}

std::string HeldOutText(const MeshFit& fit) {
  return fit.hold_out_rms_mm ? UmImportAccount(*fit.hold_out_rms_mm) : "-";
}

std::string ArmsText(const MeshFit& fit, const DeltaModel<double>& settings) {
  std::string arms, believed;
  for (Eigen::Index i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    arms += fmt::format(" {:.2f} +- {:.2f}",
                        fit.model.arm_mm[at],
                        std::sqrt(fit.arm_covariance_mm2(i, i)));
    believed += fmt::format(" {:.2f}", settings.arm_mm[at]);
  }
  return fmt::format(
      "arms{} mm if a point is good to 20 um; settings{}", arms, believed);
}

std::vector<std::string> MeshLines(const KlipperMesh& mesh,
                                   const DeltaModel<double>& settings) {
  std::vector<BedPoint> points;
  for (const MeshPoint& point : mesh.points) {
    points.push_back({.x_mm = point.x_mm, .y_mm = point.y_mm, .z_mm = point.z_mm});
  }
  const MeshShape shape = ExplainMesh(points, settings);
  using enum MeshModel;
  std::vector<std::string> lines = {
      fmt::format("mesh '{}': {}: {}", mesh.name, Name(shape.verdict), shape.reason)};
  if (shape.of(kSix).hold_out_rms_mm) {
    lines.push_back(fmt::format(
        "rms fitted / on blocks left out [um]: six numbers {} / {}, free arms {} / {}, "
        "bowl, cylinder, twist {} / {}, bed of third order {} / {}",
        UmImportAccount(shape.of(kSix).rms_mm),
        HeldOutText(shape.of(kSix)),
        UmImportAccount(shape.of(kArms).rms_mm),
        HeldOutText(shape.of(kArms)),
        UmImportAccount(shape.of(kBed).rms_mm),
        HeldOutText(shape.of(kBed)),
        UmImportAccount(shape.of(kCubic).rms_mm),
        HeldOutText(shape.of(kCubic))));
  }
  if (shape.verdict == MeshVerdict::kArms) {
    lines.push_back(ArmsText(shape.of(kArms), settings));
    lines.emplace_back(
        "a plate bent like x r^2 (one side of the rim up, the other down) would look "
        "the "
        "same: turn it by 180 degrees and probe again; arms do not turn");
  }
  return lines;
}

std::vector<std::string> MeshAccount(const KlipperBed& bed) {
  if (!bed.geometry) return {};
  std::vector<std::string> lines;
  // Leaving out blocks takes a tenth of a second for a usual mesh.
  constexpr std::size_t kMostPoints = 4000;
  std::size_t num_points = 0;
  for (const KlipperMesh& mesh : bed.meshes) {
    num_points += mesh.points.size();
    if (num_points > kMostPoints) {
      lines.push_back(fmt::format(
          "mesh '{}' and what follows are read, not judged: more than {} points",
          mesh.name,
          kMostPoints));
      break;
    }
    for (std::string& line : MeshLines(mesh, bed.geometry->model)) {
      lines.push_back(std::move(line));
    }
  }
  lines.emplace_back(
      "height, tilt, bowl, cylinder and twist of a bed also pass for endstops, delta "
      "radius and tower angles: a mesh does not part them");
  return lines;
}

}  // namespace

std::vector<std::string> ImportAccount(const std::string& kind,
                                       const std::string& text,
                                       const std::string& name,
                                       const ImportOptions& options) {
  if (kind == "klipper-delta") {
    return DeltaAccount(ReadKlipperCalibration(text, name, options), options);
  }
  if (kind == "klipper-mesh") return MeshAccount(ReadKlipperBed(text, name));
  return {};
}

}  // namespace caltwin
