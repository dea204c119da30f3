#include "renders/scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <GL/osmesa.h>
#include <mujoco/mujoco.h>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kMPerMm = 1e-3;
constexpr int kMostGeoms = 4000;

/// A software OpenGL context that draws into memory; current as long as it lives.
class OsMesa {
 public:
  OsMesa() : context_(OSMesaCreateContextExt(GL_RGBA, 24, 8, 8, nullptr)) {
    Require(context_ != nullptr, "OSMesa makes a context");
    // The picture itself goes into MuJoCo's off-screen buffer; this one is only what
    // OSMesa insists on having.
    Require(
        OSMesaMakeCurrent(
            context_, window_.data(), GL_UNSIGNED_BYTE, kWindow, kWindow) == GL_TRUE,
        "OSMesa's context becomes current");
  }
  ~OsMesa() { OSMesaDestroyContext(context_); }
  OsMesa(const OsMesa&) = delete;
  OsMesa& operator=(const OsMesa&) = delete;

 private:
  static constexpr int kWindow = 16;
  OSMesaContext context_;
  std::vector<std::uint8_t> window_ =
      std::vector<std::uint8_t>(std::size_t{4} * kWindow * kWindow);
};

/// MuJoCo's renderer: textures, meshes and shadow map of one model on that context.
class Renderer {
 public:
  Renderer(const mjModel* model, int width, int height) {
    mjr_defaultContext(&context_);
    mjr_makeContext(model, &context_, mjFONTSCALE_100);
    mjr_resizeOffscreen(width, height, &context_);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    Require(context_.currentBuffer == mjFB_OFFSCREEN, "an off-screen buffer exists");
  }
  ~Renderer() { mjr_freeContext(&context_); }
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  mjrContext* context() { return &context_; }

 private:
  mjrContext context_{};
};

/// The list of shapes to draw.
class Shapes {
 public:
  explicit Shapes(const mjModel* model) {
    mjv_defaultScene(&scene_);
    mjv_makeScene(model, &scene_, kMostGeoms);
  }
  ~Shapes() { mjv_freeScene(&scene_); }
  Shapes(const Shapes&) = delete;
  Shapes& operator=(const Shapes&) = delete;
  mjvScene* scene() { return &scene_; }

  /// Room for one more shape.
  mjvGeom* Add() {
    Require(scene_.ngeom < scene_.maxgeom, "a scene has room for its shapes");
    return &scene_.geoms[scene_.ngeom++];
  }

 private:
  mjvScene scene_{};
};

void AddArrow(const Arrow& arrow, Shapes* shapes) {
  const Vec3<double> from_m = arrow.from_mm * kMPerMm;
  // MuJoCo 4.0.1 draws an arrow half as long as it is asked for.
  const Vec3<double> to_m = from_m + 2 * (arrow.to_mm - arrow.from_mm) * kMPerMm;
  mjvGeom* geom = shapes->Add();
  mjv_initGeom(geom, mjGEOM_ARROW, nullptr, nullptr, nullptr, arrow.rgba.data());
  mjv_connector(
      geom, mjGEOM_ARROW, arrow.radius_mm * kMPerMm, from_m.data(), to_m.data());
  geom->emission = 0.3f;
}

void AddMarker(const Marker& marker, Shapes* shapes) {
  const Vec3<double> at_m = marker.at_mm * kMPerMm;
  const Vec3<double> size_m = Vec3<double>::Constant(marker.radius_mm * kMPerMm);
  mjvGeom* geom = shapes->Add();
  mjv_initGeom(
      geom, mjGEOM_SPHERE, size_m.data(), at_m.data(), nullptr, marker.rgba.data());
  geom->emission = 0.3f;
}

mjvCamera CameraNamed(const mjModel* model, const std::string& name) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  int id = model->ncam > 0 ? 0 : -1;
  if (!name.empty()) {
    id = mj_name2id(model, mjOBJ_CAMERA, name.c_str());
    Require(id >= 0, "the camera asked for is in the model");
  }
  if (id < 0) {
    mjv_defaultFreeCamera(model, &camera);
    return camera;
  }
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = id;
  return camera;
}

/// What a person wants to see: the surfaces (groups 0 to 2), no joints, no contacts.
mjvOption Surfaces() {
  mjvOption option;
  mjv_defaultOption(&option);
  std::fill(std::begin(option.sitegroup), std::end(option.sitegroup), mjtByte{0});
  option.tendongroup[0] = 0;  // Couplings; rods that are to be seen are in group 1.
  return option;
}

/// OpenGL's rows start at the bottom, a picture's at the top. Turned over where it is:
/// a second copy would be the peak of a report's memory.
Picture Upright(std::vector<std::uint8_t> rgb, int width, int height) {
  const std::ptrdiff_t stride = std::ptrdiff_t{3} * width;
  for (int row = 0; row < height / 2; ++row) {
    const auto low = rgb.begin() + row * stride;
    const auto high = rgb.begin() + (height - 1 - row) * stride;
    std::swap_ranges(low, low + stride, high);
  }
  return {.width = width, .height = height, .rgb = std::move(rgb)};
}

// A picture is drawn from top to bottom in as many strips, so that the large buffers of
// an oversampled one never exist at once: a quarter of the memory.
int StripsOf(const PictureOptions& options) {
  constexpr int kStrips = 4;
  return options.height % kStrips == 0 ? kStrips : 1;
}

// The part of the view that strip `index` of `count` shows, 0 the topmost.
mjvGLCamera Strip(mjvGLCamera camera, int index, int count) {
  const float height =
      (camera.frustum_top - camera.frustum_bottom) / static_cast<float>(count);
  camera.frustum_top -= static_cast<float>(index) * height;
  camera.frustum_bottom = camera.frustum_top - height;
  return camera;
}

}  // namespace

struct Painter::Parts {
  // The context must be there before the renderer and go after it.
  OsMesa mesa;
  Renderer renderer;
  Shapes shapes;
  const mjModel* model;

  Parts(const mjModel* m, int width, int height)
      : renderer(m, width, height), shapes(m), model(m) {}
};

Painter::Painter(const mjModel* model, const PictureOptions& options)
    : parts_(std::make_unique<Parts>(
          model,
          options.width * options.oversampling,
          options.height * options.oversampling / StripsOf(options))) {}

Painter::~Painter() = default;

Picture Painter::Draw(mjData* data, const PictureOptions& options) {
  const int strips = StripsOf(options);
  const int width = options.width * options.oversampling;
  const int height = options.height * options.oversampling / strips;
  mjrContext* context = parts_->renderer.context();
  Require(width <= context->offWidth && height <= context->offHeight,
          "a picture is no larger than its painter was made for");
  Shapes& shapes = parts_->shapes;
  mjvScene* scene = shapes.scene();
  mjvCamera camera = CameraNamed(parts_->model, options.camera);
  const mjvOption option = Surfaces();
  mjv_updateScene(parts_->model, data, &option, nullptr, &camera, mjCAT_ALL, scene);
  scene->flags[mjRND_SHADOW] = options.shadows ? 1 : 0;
  for (const Arrow& arrow : options.arrows) AddArrow(arrow, &shapes);
  for (const Marker& marker : options.markers) AddMarker(marker, &shapes);

  const mjrRect viewport{0, 0, width, height};
  const std::array<mjvGLCamera, 2> whole{scene->camera[0], scene->camera[1]};
  Picture picture{.width = options.width, .height = options.height, .rgb = {}};
  for (int strip = 0; strip < strips; ++strip) {
    for (std::size_t eye = 0; eye < whole.size(); ++eye) {
      scene->camera[eye] = Strip(whole[eye], strip, strips);
    }
    mjr_render(viewport, scene, context);
    std::vector<std::uint8_t> rgb(std::size_t{3} * width * height);
    mjr_readPixels(rgb.data(), nullptr, viewport, context);
    const Picture part =
        Shrunk(Upright(std::move(rgb), width, height), options.oversampling);
    picture.rgb.insert(picture.rgb.end(), part.rgb.begin(), part.rgb.end());
  }
  return picture;
}

std::vector<std::string> CameraNames(const mjModel* model) {
  std::vector<std::string> names;
  for (int id = 0; id < model->ncam; ++id) {
    const char* name = mj_id2name(model, mjOBJ_CAMERA, id);
    if (name != nullptr) names.emplace_back(name);
  }
  return names;
}

bool HasCamera(const mjModel* model, const std::string& name) {
  return mj_name2id(model, mjOBJ_CAMERA, name.c_str()) >= 0;
}

Picture DrawScene(const mjModel* model, mjData* data, const PictureOptions& options) {
  return Painter(model, options).Draw(data, options);
}

}  // namespace caltwin
