#include "calibration/diagnosis/kinds/triple_z_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/correction_text.h"
#include "calibration/diagnosis/extension.h"
#include "calibration/diagnosis/settings_of_rows.h"
#include "calibration/kinds/triple_z/plane.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 3> kPlaceCauses = {
    "pivot_position", "motors_swapped", "overconstrained_bed"};

// The bed's nominal point touched with all screws as high as the drawing has it.
Row NominalBedTouch(const Machine& machine, const Eigen::Vector2d& at_mm) {
  Row row{.kind = RowKind::kTouch};
  row.cmd_mm = {at_mm[0], at_mm[1], 0};
  row.n = {0, 0, 1};
  row.dir = {0, 0, -1};
  row.feed_mm_s = machine.probe.speeds_mm_s.back();
  row.feature = "bed.top";
  const ScrewCells screws = ScrewCellsOf(&row, machine.kind->drive_map() != nullptr);
  screws.mm->fill(TripleZOf(machine).top_mm);
  screws.dir->fill(1);
  return row;
}

class ScrewWriter {
 public:
  ScrewWriter(ControllerKind controller,
              const Diagnosis& diagnosis,
              const Observed& observed)
      : controller_(controller),
        diagnosis_(diagnosis),
        observed_(observed),
        out_(controller, diagnosis),
        machine_(observed.machine()),
        effects_(observed.effects()) {
    for (const Finding& finding : diagnosis.findings) {
      if (finding.effect) effects_.push_back(*finding.effect);
    }
    // Nothing is levelled against what comes and goes.
    std::erase_if(effects_, [](const Injected& effect) {
      const Effect& declared = EffectAt(effect.effect);
      return declared.bucket == Bucket::kTime || declared.name == "probe_temperature";
    });
    for (const Injected& effect : effects_) {
      if (effect.effect != EffectIndex<MotorsSwapped>()) continue;
      turned_ = MotorsSwapped::ScrewsTurned(effect.axis);
    }
    places_mm_ = Places();
  }

  std::string Make() {
    AddPlaces();
    AddSteps();
    if (const BaselineLine* play = out_.Fitted("backlash.z")) out_.SetPlay('Z', *play);
    AddRaise();
    AddRest();
    return out_.text();
  }

 private:
  // Over the place of a screw the bed follows it alone: the other two weights vanish.
  Pivots<double> Places() const {
    constexpr double kApart_mm = 100;
    Eigen::Matrix3d weights, points;
    for (int k = 0; k < kNumScrews; ++k) {
      const Eigen::Vector2d at_mm(k == 1 ? kApart_mm : 0, k == 2 ? kApart_mm : 0);
      const At at =
          AtOf(NominalBedTouch(machine_, at_mm), machine_, SettingsOfRows(observed_));
      weights.col(k) =
          BuiltWeights<double>(at, ErrorsAt<double>(machine_, at, effects_));
      points.col(k) << at_mm, 1;
    }
    const Eigen::Matrix3d places = points * weights.inverse();
    Pivots<double> places_mm;
    for (int i = 0; i < kNumScrews; ++i) {
      places_mm[static_cast<std::size_t>(i)] = places.col(i).head<2>();
    }
    return places_mm;
  }

  const Eigen::Vector2d& PlaceOfDriver_mm(int driver) const {
    const auto at = static_cast<std::size_t>(driver);
    return places_mm_[static_cast<std::size_t>(turned_[at])];
  }

  std::string InOrder(int coordinate, bool by_driver) const {
    std::array<std::string, kNumScrews> numbers;
    for (int i = 0; i < kNumScrews; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Eigen::Vector2d& place_mm =
          by_driver ? PlaceOfDriver_mm(i) : places_mm_[at];
      numbers[at] = fmt::format("{:.2f}", place_mm[coordinate]);
    }
    return fmt::format("{}", fmt::join(numbers, ":"));
  }

  // Which screws are exchanged says all of a wiring.
  static std::string PlaceSaid(const Finding& finding) {
    return finding.cause == "motors_swapped" ? KeyOf(finding) : SaidOf(finding);
  }

  static bool IsOfPlaces(const Finding& finding) {
    return finding.effect &&
           std::ranges::find(kPlaceCauses, finding.cause) != kPlaceCauses.end();
  }

  void AddPlaces() {
    std::vector<std::string> sources;
    for (const Finding& finding : diagnosis_.findings) {
      if (IsOfPlaces(finding)) sources.push_back(PlaceSaid(finding));
    }
    if (sources.empty()) {
      const bool is_unseen = std::ranges::any_of(
          diagnosis_.absorbed,
          [](const Absorbed& one) { return one.what.starts_with("pivot_position"); });
      out_.Comment(
          is_unseen
              ? "where the screws stand and which driver turns which: no row moves "
                "a screw alone, nothing to set"
              : "the screws stand and are wired as the machine file has it, "
                "nothing to set");
      return;
    }
    for (const std::string& source : sources) out_.Comment(source);
    out_.Comment(
        "mm, in the order of the drivers of Z: where the screw of each stands");
    if (controller_ == ControllerKind::kRrf) {
      out_.Add(fmt::format("M671 X{} Y{}\n", InOrder(0, true), InOrder(1, true)));
    } else if (controller_ == ControllerKind::kMarlin) {
      for (int driver = 0; driver < kNumScrews; ++driver) {
        const Eigen::Vector2d& at_mm = PlaceOfDriver_mm(driver);
        out_.Add(
            fmt::format("M422 W{} X{:.2f} Y{:.2f}\n", driver + 1, at_mm[0], at_mm[1]));
      }
    } else {
      out_.Add("[z_tilt]\nz_positions:\n");
      for (int driver = 0; driver < kNumScrews; ++driver) {
        const Eigen::Vector2d& at_mm = PlaceOfDriver_mm(driver);
        out_.Add(fmt::format("    {:.2f}, {:.2f}\n", at_mm[0], at_mm[1]));
      }
    }
    if (turned_ != std::array{0, 1, 2}) {
      out_.Comment(fmt::format("or plug the motors in as drawn, and then X{} Y{}",
                               InOrder(0, false),
                               InOrder(1, false)));
    }
  }

  double PitchError(int screw) const {
    double error = 0;
    for (const Finding& finding : diagnosis_.findings) {
      if (finding.cause == "screw_pitch" && finding.effect &&
          finding.axis == ScrewName(screw)) {
        error += FractionFromPpm(finding.effect->values[0]);
      }
    }
    return error;
  }

  static std::string ScaleSaid(const BaselineLine& scale) {
    return fmt::format("{} {:+.1f} +- {:.1f} ppm", scale.name, scale.value, scale.sd);
  }

  // What moves too far by s gets steps/mm / (1 + s).
  void AddSteps() {
    const BaselineLine* scale = out_.Fitted("scale.z");
    if (scale != nullptr && !out_.IsToBeSet(*scale)) scale = nullptr;
    const double common = scale == nullptr ? 0 : FractionFromPpm(scale->value);
    const AxisDrawing& drawing = machine_.axis(Axis::kZ);
    const double set = SettingsOfRows(observed_).steps_per_mm[2];
    const double old = set > 0 ? set : drawing.steps_per_mm();
    if (scale != nullptr && IsSetByGcode(controller_)) {
      out_.SetSteps('Z', old, common, /*steps_a_turn=*/0, ScaleSaid(*scale));
    } else if (scale != nullptr) {
      out_.Comment(
          fmt::format("steps/mm of Z were {:.6g}: {}", old, ScaleSaid(*scale)));
    }
    if (controller_ != ControllerKind::kKlipper) return;
    for (int driver = 0; driver < kNumScrews; ++driver) {
      const int screw = turned_[static_cast<std::size_t>(driver)];
      const double error = PitchError(screw);
      if (common == 0 && error == 0) continue;
      const ScrewDrawing& drawn =
          TripleZOf(machine_).screws[static_cast<std::size_t>(screw)];
      out_.Add(fmt::format("[stepper_z{}]\nrotation_distance: {:.7g}\n",
                           driver == 0 ? "" : fmt::format("{}", driver),
                           drawn.full_steps_per_rev * drawn.microsteps / old *
                               (1 + common) * (1 + error)));
    }
  }

  // The bed's slopes at the last homing: x, then y; nullptr where not determined.
  std::array<const BaselineLine*, 2> Slopes() const {
    const std::string& home = observed_.row(observed_.num_rows() - 1).home;
    std::array<const BaselineLine*, 2> slopes{};
    for (std::size_t i = 0; i < slopes.size(); ++i) {
      const std::string slope = i == 0 ? "slope_x" : "slope_y";
      const BaselineLine* line = out_.Fitted("bed_plane." + home + "." + slope);
      if (line == nullptr) line = out_.Fitted("bed_plane." + slope);
      if (line != nullptr && line->is_determined) slopes[i] = line;
    }
    return slopes;
  }

  BedPlane Touched(const std::array<const BaselineLine*, 2>& slopes) const {
    constexpr int kSide = 7;
    const AxisDrawing &x = machine_.axis(Axis::kX), &y = machine_.axis(Axis::kY);
    std::vector<BedTouch> touches;
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const Eigen::Vector2d at_mm(x.min_mm + x.travel_mm() * i / (kSide - 1),
                                    y.min_mm + y.travel_mm() * j / (kSide - 1));
        const At at =
            AtOf(NominalBedTouch(machine_, at_mm), machine_, SettingsOfRows(observed_));
        touches.push_back({at_mm,
                           Predict_mm<double>(machine_, at, effects_) +
                               RadFromMrad(slopes[0]->value) * at_mm[0] +
                               RadFromMrad(slopes[1]->value) * at_mm[1]});
      }
    }
    return FitBedPlane(touches, 1, /*is_sigma_stated=*/true);
  }

  void AddRaise() {
    const auto slopes = Slopes();
    if (slopes[0] == nullptr || slopes[1] == nullptr) {
      out_.Comment("the bed's tilt: not determined by these rows");
      return;
    }
    const BedPlane plane = Touched(slopes);
    if (!std::isfinite(plane.a()) || !std::isfinite(plane.b())) {
      out_.Comment("the bed's tilt: what was found depends on more than its place");
      return;
    }
    const Eigen::Vector2d middle_mm =
        (places_mm_[0] + places_mm_[1] + places_mm_[2]) / kNumScrews;
    std::array<std::string, kNumScrews> said;
    for (std::size_t i = 0; i < said.size(); ++i) {
      const Eigen::Vector2d from_mm = places_mm_[i] - middle_mm;
      const double raise_mm = -(plane.a() * from_mm[0] + plane.b() * from_mm[1]);
      const double sd_mm = std::hypot(RadFromMrad(slopes[0]->sd) * from_mm[0],
                                      RadFromMrad(slopes[1]->sd) * from_mm[1]);
      said[i] = fmt::format("{} {:+.3f} +- {:.3f} mm ({:+.3f} turns)",
                            ScrewName(static_cast<int>(i)),
                            raise_mm,
                            sd_mm,
                            raise_mm / TripleZOf(machine_).screws[i].lead_mm);
    }
    out_.Comment(fmt::format("level by {}: as measured, that raises {}",
                             controller_ == ControllerKind::kRrf      ? "G32"
                             : controller_ == ControllerKind::kMarlin ? "G34"
                                                                      : "Z_TILT_ADJUST",
                             fmt::join(said, ", ")));
  }

  void AddRest() {
    for (const Finding& finding : diagnosis_.findings) {
      if (IsOfPlaces(finding)) continue;
      const bool is_carried =
          controller_ == ControllerKind::kKlipper && finding.cause == "screw_pitch";
      if (is_carried) {
        out_.Comment(SaidOf(finding) + ": in the rotation_distance of its driver");
        continue;
      }
      out_.LeaveOver(finding);
    }
  }

  ControllerKind controller_;
  const Diagnosis& diagnosis_;
  const Observed& observed_;
  CorrectionText out_;
  const Machine& machine_;
  std::vector<Injected> effects_;
  std::array<int, kNumScrews> turned_{0, 1, 2};  ///< The screw of each driver.
  Pivots<double> places_mm_{};                   ///< By screw.
};

}  // namespace

void RequireScrewLevelling(ControllerKind controller) {
  if (controller == ControllerKind::kLinuxCnc) {
    throw InputError({.file = "--for"},
                     "LinuxCNC levels no bed by its screws",
                     "rrf, klipper or marlin");
  }
}

std::string TripleZCorrectionText(ControllerKind controller,
                                  const Diagnosis& diagnosis,
                                  const Observed& observed) {
  RequireScrewLevelling(controller);
  return ScrewWriter(controller, diagnosis, observed).Make();
}

}  // namespace caltwin
