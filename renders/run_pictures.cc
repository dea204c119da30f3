#include "renders/run_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/kinds/as_built.h"
#include "renders/machine_scene.h"
#include "renders/playback.h"
#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/runner.h"
#include "scenarios/scenario.h"

namespace caltwin {
namespace {

constexpr int kPosesAcross = 6;
constexpr double kLongestArrow_mm = 40;
constexpr double kAboveTable_mm = 3;
constexpr double kLeastArrow_mm = 0.5;

/// `low`, `high` and what lies between, evenly.
double PlaceAmong(double low, double high, int index) {
  return low + (high - low) * index / (kPosesAcross - 1);
}

/// The largest of 1, 2, 5, 10, 20, ... that is not above `value`.
double RoundedDown(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0}) {
    if (value >= step * decade) return step * decade;
  }
  return decade;
}

double Largest_mm(const std::vector<PoseError>& errors) {
  double largest_mm = 0;
  for (const PoseError& error : errors) {
    largest_mm = std::max(largest_mm, error.error_mm.norm());
  }
  return largest_mm;
}

/// The gantry at the back and the probe up, so that the table lies open.
Vec3<double> OpenPose_mm(const Machine& machine) {
  return {machine.axis(Axis::kX).mid_mm(),
          machine.axis(Axis::kY).max_mm,
          machine.axis(Axis::kZ).max_mm};
}

/// The machine from the model's camera `table`, where it has one.
PictureOptions TableView(const mjModel* model) {
  PictureOptions options = RunPictureOptions();
  if (HasCamera(model, "table")) options.camera = "table";
  return options;
}

ReportPicture MachineAsBuilt(const TwinConfig& config) {
  return {.title = "The machine as built.",
          .caption =
              fmt::format("Its geometric errors are enlarged {} times.", kExaggerate),
          .png = PngBytes(MachinePicture(config, kExaggerate, RunPictureOptions()))};
}

ReportPicture ErrorPicture(MachineScene* scene,
                           Painter* painter,
                           const std::string& title,
                           const std::vector<PoseError>& errors,
                           double magnification) {
  PictureOptions options = TableView(scene->model());
  options.arrows = ArrowsOf(errors, magnification);
  for (const PoseError& error : errors) {
    options.markers.push_back(
        {.at_mm = error.at_mm, .radius_mm = 1.4, .rgba = {0.1f, 0.1f, 0.12f, 1}});
  }
  return {.title = title,
          .caption = fmt::format(
              "From each commanded place an arrow to where the tip is, reached in + "
              "(orange) and in - (blue), enlarged {:g} times. The largest error is {}.",
              magnification,
              LengthText(Largest_mm(errors))),
          .png = PngBytes(painter->Draw(scene->data(), options))};
}

}  // namespace

std::vector<PoseError> GridErrors(const TwinConfig& config, const Settings& settings) {
  TwinConfig fast = config;
  fast.settings = settings;
  fast.fidelity = Fidelity::kFast;
  const Twin twin(fast);
  const AxisDrawing& x = config.machine.axis(Axis::kX);
  const AxisDrawing& y = config.machine.axis(Axis::kY);
  std::vector<PoseError> errors;
  Vec3<double> mean_mm = Vec3<double>::Zero();
  for (int i = 0; i < kPosesAcross * kPosesAcross * 2; ++i) {
    const bool is_forward = i % 2 == 0;
    const Vec3<double> at_mm(PlaceAmong(x.min_mm, x.max_mm, i / 2 % kPosesAcross),
                             PlaceAmong(y.min_mm, y.max_mm, i / 2 / kPosesAcross),
                             config.machine.axis(Axis::kZ).min_mm + kAboveTable_mm);
    const Vec3<double> dir = Vec3<double>::Constant(is_forward ? 1 : -1);
    const Vec3<double> error_mm = twin.PositionError_mm(at_mm, dir);
    errors.push_back({.at_mm = at_mm, .error_mm = error_mm, .is_forward = is_forward});
    mean_mm += error_mm;
  }
  mean_mm /= static_cast<double>(errors.size());
  for (PoseError& error : errors) error.error_mm -= mean_mm;
  return errors;
}

double Magnification(const std::vector<PoseError>& errors) {
  const double largest_mm = Largest_mm(errors);
  return largest_mm > 0 ? RoundedDown(kLongestArrow_mm / largest_mm) : 1;
}

std::vector<Arrow> ArrowsOf(const std::vector<PoseError>& errors,
                            double magnification) {
  std::vector<Arrow> arrows;
  for (const PoseError& error : errors) {
    const Vec3<double> length_mm = magnification * error.error_mm;
    if (length_mm.norm() < kLeastArrow_mm) continue;
    Arrow arrow{.from_mm = error.at_mm, .to_mm = error.at_mm + length_mm};
    if (!error.is_forward) arrow.rgba = {0.10f, 0.42f, 0.80f, 1};
    arrows.push_back(arrow);
  }
  return arrows;
}

ReportPictures PicturesOf(const RunResult& result) {
  const Scenario scenario = ReadScenarioText(result.verbatim, result.scenario);
  ReportPictures pictures{.playback = PlaybackHtml(scenario, result, PackedPlayer())};
  if (auto of_kind = PicturesOfKind(scenario, result.seed)) {
    pictures.pictures = *std::move(of_kind);
    return pictures;
  }
  const TwinConfig config = MakeTwinConfig(scenario, {.seed = result.seed});
  pictures.pictures.push_back(MachineAsBuilt(config));

  MachineScene scene(config);
  scene.MoveTo(OpenPose_mm(config.machine));
  Painter painter(scene.model(), TableView(scene.model()));
  const std::vector<PoseError> before = GridErrors(config, result.settings_before);
  const std::vector<PoseError> after = GridErrors(config, result.settings_after);
  const double coarse = std::min(Magnification(before), Magnification(after));
  const auto add = [&](const std::string& title,
                       const std::vector<PoseError>& errors,
                       double magnification) {
    pictures.pictures.push_back(
        ErrorPicture(&scene, &painter, title, errors, magnification));
  };
  add("Before.", before, coarse);
  add("After, to the same scale.", after, coarse);
  if (Magnification(after) > coarse) add("What is left.", after, Magnification(after));
  return pictures;
}

}  // namespace caltwin
