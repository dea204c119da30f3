#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "renders/picture.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// An arrow drawn into a scene, in machine axes.
struct Arrow {
  Vec3<double> from_mm = Vec3<double>::Zero();
  Vec3<double> to_mm = Vec3<double>::Zero();
  double radius_mm = 1.6;
  std::array<float, 4> rgba = {0.95f, 0.40f, 0.03f, 1.0f};
};

/// A ball drawn into a scene, in machine axes: marks a place.
struct Marker {
  Vec3<double> at_mm = Vec3<double>::Zero();
  double radius_mm = 2;
  std::array<float, 4> rgba = {0.2f, 0.5f, 0.9f, 1.0f};
};

struct PictureOptions {
  int width = 1280;
  int height = 960;
  /// A camera of the model; empty: the first there is, else one that sees everything.
  std::string camera{};
  /// Each pixel is the mean of this many squared: smooth edges.
  int oversampling = 2;
  bool shadows = true;
  std::vector<Arrow> arrows{};
  std::vector<Marker> markers{};
};

/// Names of the cameras that a model file declares.
std::vector<std::string> CameraNames(const mjModel* model);
bool HasCamera(const mjModel* model, const std::string& name);

/// Draws pictures of one model without a screen (OSMesa: software OpenGL in memory).
/// Making one costs 0.3 s, a picture 0.1 to 0.5 s, so keep it for several pictures of
/// the same model. At most one may exist at a time in a thread. The same model and
/// state give the same bytes.
class Painter {
 public:
  /// Largest picture that it can draw is `width` x `height` times `oversampling`
  /// squared.
  explicit Painter(const mjModel* model, const PictureOptions& options = {});
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  /// A picture of the model in the state of `data`, whose positions must have been
  /// computed (mj_forward or mj_kinematics). `options.camera` must exist.
  Picture Draw(mjData* data, const PictureOptions& options);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// One picture: makes a Painter, draws, lets it go.
Picture DrawScene(const mjModel* model,
                  mjData* data,
                  const PictureOptions& options = {});

}  // namespace caltwin
