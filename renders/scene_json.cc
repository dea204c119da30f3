#include "renders/scene_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "sim/base/units.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMm_per_m = 1000;
constexpr int kHighestGroup = 2;  // Groups above are MuJoCo's hidden ones.

// Six digits: what a picture needs.
double Short(double value) {
  constexpr double kDigits = 1e6;
  return std::round(value * kDigits) / kDigits;
}

BodyPose PoseOf(const mjtNum* position_m, const mjtNum* quaternion) {
  BodyPose pose{};
  for (std::size_t i = 0; i < 3; ++i) pose[i] = position_m[i] * kMm_per_m;
  std::copy_n(quaternion, 4, pose.begin() + 3);
  return pose;
}

Json ShortJson(const BodyPose& pose) {
  Json json = Json::array();
  for (const double value : pose) json.push_back(Short(value));
  return json;
}

const char* TypeOf(int type) {
  switch (type) {
    case mjGEOM_PLANE:
      return "plane";
    case mjGEOM_SPHERE:
      return "sphere";
    case mjGEOM_CAPSULE:
      return "capsule";
    case mjGEOM_ELLIPSOID:
      return "ellipsoid";
    case mjGEOM_CYLINDER:
      return "cylinder";
    case mjGEOM_BOX:
      return "box";
    case mjGEOM_MESH:
      return "mesh";
    default:
      return nullptr;
  }
}

/// Of the material, where there is one.
Json Colour(const mjModel& model, int material, const float* rgba) {
  if (material >= 0) rgba = model.mat_rgba + std::ptrdiff_t{4} * material;
  Json colour = Json::array();
  for (int i = 0; i < 4; ++i) colour.push_back(Short(rgba[i]));
  return colour;
}

Json GeomOf(const mjModel& model, int geom) {
  Json size = Json::array();
  for (int i = 0; i < 3; ++i) {
    size.push_back(Short(model.geom_size[3 * geom + i] * kMm_per_m));
  }
  const bool is_mesh = model.geom_type[geom] == mjGEOM_MESH;
  return {
      {"body", model.geom_bodyid[geom]},
      {"type", TypeOf(model.geom_type[geom])},
      {"size_mm", std::move(size)},
      {"pose",
       ShortJson(PoseOf(model.geom_pos + std::ptrdiff_t{3} * geom,
                        model.geom_quat + std::ptrdiff_t{4} * geom))},
      {"rgba",
       Colour(
           model, model.geom_matid[geom], model.geom_rgba + std::ptrdiff_t{4} * geom)},
      {"mesh", is_mesh ? Json(model.geom_dataid[geom]) : Json()}};
}

/// A straight rod between sites of two bodies, as MuJoCo draws a spatial tendon; null:
/// it is another.
Json RodOf(const mjModel& model, int tendon) {
  const int first = model.tendon_adr[tendon];
  const bool is_rod = model.tendon_num[tendon] == 2 &&
                      model.wrap_type[first] == mjWRAP_SITE &&
                      model.wrap_type[first + 1] == mjWRAP_SITE;
  if (!is_rod || model.tendon_group[tendon] > kHighestGroup) return {};
  Json bodies = Json::array(), ends = Json::array();
  for (const int site : {model.wrap_objid[first], model.wrap_objid[first + 1]}) {
    bodies.push_back(model.site_bodyid[site]);
    Json end = Json::array();
    for (int i = 0; i < 3; ++i) {
      end.push_back(Short(model.site_pos[3 * site + i] * kMm_per_m));
    }
    ends.push_back(std::move(end));
  }
  return {{"bodies", std::move(bodies)},
          {"ends_mm", std::move(ends)},
          {"radius_mm", Short(model.tendon_width[tendon] * kMm_per_m)},
          {"rgba",
           Colour(model,
                  model.tendon_matid[tendon],
                  model.tendon_rgba + std::ptrdiff_t{4} * tendon)}};
}

Json MeshOf(const mjModel& model, int mesh) {
  Json vertices = Json::array();
  const float* const first =
      model.mesh_vert + std::ptrdiff_t{3} * model.mesh_vertadr[mesh];
  for (int i = 0; i < 3 * model.mesh_vertnum[mesh]; ++i) {
    vertices.push_back(Short(first[i] * kMm_per_m));
  }
  Json faces = Json::array();
  const int* const face =
      model.mesh_face + std::ptrdiff_t{3} * model.mesh_faceadr[mesh];
  for (int i = 0; i < 3 * model.mesh_facenum[mesh]; ++i) faces.push_back(face[i]);
  return {{"vertices_mm", std::move(vertices)}, {"faces", std::move(faces)}};
}

}  // namespace

std::vector<BodyPose> PosesOf(const mjData& data, const std::vector<int>& bodies) {
  std::vector<BodyPose> poses;
  for (const int body : bodies) {
    poses.push_back(PoseOf(data.xpos + std::ptrdiff_t{3} * body,
                           data.xquat + std::ptrdiff_t{4} * body));
  }
  return poses;
}

Json PosesJson(const mjData& data, const std::vector<int>& bodies) {
  Json poses = Json::array();
  for (const BodyPose& pose : PosesOf(data, bodies)) poses.push_back(ShortJson(pose));
  return poses;
}

std::vector<int> MovingBodies(const mjModel& model) {
  std::vector<int> moving;
  for (int body = 1; body < model.nbody; ++body) {
    const bool hangs_on_one =
        std::ranges::find(moving, model.body_parentid[body]) != moving.end();
    const bool is_mocap = model.body_mocapid[body] >= 0;
    if (model.body_jntnum[body] > 0 || hangs_on_one || is_mocap) moving.push_back(body);
  }
  return moving;
}

Json SceneJson(const Still& still) {
  const mjModel& model = *still.model;
  Json scene{{"machine", still.machine},
             {"moves", static_cast<bool>(still.move_to)},
             {"travel_mm", still.travel_mm},
             {"bodies", Json::array()},
             {"poses", Json::array()},
             {"geoms", Json::array()},
             {"rods", Json::array()},
             {"meshes", Json::array()}};
  std::vector<int> all;
  for (int body = 0; body < model.nbody; ++body) {
    const char* const name = mj_id2name(&model, mjOBJ_BODY, body);
    scene["bodies"].push_back(name == nullptr ? "" : name);
    all.push_back(body);
  }
  scene["poses"] = PosesJson(*still.data, all);
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const bool is_shown = model.geom_group[geom] <= kHighestGroup &&
                          TypeOf(model.geom_type[geom]) != nullptr;
    if (is_shown) scene["geoms"].push_back(GeomOf(model, geom));
  }
  for (int tendon = 0; tendon < model.ntendon; ++tendon) {
    Json rod = RodOf(model, tendon);
    if (!rod.is_null()) scene["rods"].push_back(std::move(rod));
  }
  for (int mesh = 0; mesh < model.nmesh; ++mesh) {
    scene["meshes"].push_back(MeshOf(model, mesh));
  }
  return scene;
}

}  // namespace caltwin
