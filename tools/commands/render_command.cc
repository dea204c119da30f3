#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renders/kinds/still.h"
#include "renders/scene.h"
#include "tools/commands/command.h"
#include "tools/commands/spare_files.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr int kLeastPixels = 16, kMostPixels = 4096;
constexpr double kMostExaggeration = 1e6;

struct RenderAsked {
  std::string file{};
  std::string out{};
  std::string camera{};
  double exaggerate = 1;
  int width = 1280;
  int height = 960;
};

void CheckCamera(const mjModel* model, const std::string& camera) {
  if (camera.empty() || HasCamera(model, camera)) return;
  throw InputError({.file = "--camera"},
                   fmt::format("the model has no camera '{}'", camera),
                   fmt::format("it has: {}", fmt::join(CameraNames(model), ", ")));
}

void Draw(const RenderAsked& options, const mjModel* model, mjData* data) {
  CheckCamera(model, options.camera);
  WritePng(options.out,
           DrawScene(model,
                     data,
                     {.width = options.width,
                      .height = options.height,
                      .camera = options.camera}));
  std::cout << fmt::format("picture: {}\n", options.out);
}

int Render(const RenderAsked& options) {
  if (fs::path(options.out).extension() != ".png") {
    throw InputError({.file = "--out"},
                     fmt::format("'{}' does not end in .png", options.out),
                     "pictures are PNG files");
  }
  RefuseOverwriting({{"the file", options.file}}, {{"--out", options.out}});
  const Still still = StillOf(options.file, options.exaggerate);
  Draw(options, still.model, still.data);
  return kPassed;
}

}  // namespace

Action DeclareRender(CLI::App* app) {
  auto options = std::make_shared<RenderAsked>();
  app->add_option("FILE", options->file, "a machine or a scenario (YAML)")->required();
  app->add_option("--out", options->out, "the picture to write (FILE.png)")->required();
  app->add_option("--exaggerate",
                  options->exaggerate,
                  "draw squareness, bed tilt and backlash so many times too large")
      ->check(CLI::Range(0.0, kMostExaggeration));
  app->add_option("--camera", options->camera, "a camera of the model, by name");
  app->add_option("--width", options->width, "pixels across")
      ->check(CLI::Range(kLeastPixels, kMostPixels))
      ->capture_default_str();
  app->add_option("--height", options->height, "pixels down")
      ->check(CLI::Range(kLeastPixels, kMostPixels))
      ->capture_default_str();
  app->footer("Needs no screen: OSMesa draws in memory.");
  return [options] {
    return Render(*options);
  };
}

}  // namespace caltwin
