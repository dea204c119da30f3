#include "tools/commands/kinds/bed_store.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"
#include "tools/commands/api/put_aside.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

Vec3<double> ScrewsOf(const Json& tree) {
  return {tree.at("z1_mm").get<double>(),
          tree.at("z2_mm").get<double>(),
          tree.at("z3_mm").get<double>()};
}

Json TouchesOf(const BedFound& found) {
  Json touches = Json::array();
  for (const BedTouch& touch : found.touches) {
    touches.push_back({touch.at_mm[0], touch.at_mm[1], touch.height_mm});
  }
  return touches;
}

Json UncertaintyOf(const BedPlane& plane) {
  // Of three touches only what was stated of the probe.
  const double degrees = DegFromRad(1);
  return {{"a", plane.fit.slope_x.sd},
          {"b", plane.fit.slope_y.sd},
          {"c", plane.fit.height_mm.sd},
          {"tilt_x_degrees", plane.fit.slope_x.sd * degrees},
          {"tilt_y_degrees", plane.fit.slope_y.sd * degrees}};
}

Json KeptTree(const BedFound& found) {
  return {{"touches", TouchesOf(found)},
          {"reference_mm", found.reference_mm},
          {"offsets_mm", ScrewsToJson(found.offsets_mm)},
          {"raised_before_mm", ScrewsToJson(found.raised_before_mm)},
          {"is_by_printer", found.is_by_printer},
          {"is_level", found.is_level},
          {"at", found.at},
          {"notes", found.notes}};
}

BedFound FoundOf(const Json& tree, double sigma_mm) {
  BedFound found{.reference_mm = tree.at("reference_mm"),
                 .offsets_mm = ScrewsOf(tree.at("offsets_mm")),
                 .raised_before_mm = ScrewsOf(tree.at("raised_before_mm")),
                 .is_by_printer = tree.at("is_by_printer"),
                 .is_level = tree.at("is_level"),
                 .at = tree.at("at"),
                 .notes = tree.at("notes")};
  for (const Json& touch : tree.at("touches")) {
    found.touches.push_back(
        {.at_mm = {touch.at(0).get<double>(), touch.at(1).get<double>()},
         .height_mm = touch.at(2).get<double>()});
  }
  found.plane = FitBedPlane(found.touches, sigma_mm, /*is_sigma_stated=*/false);
  return found;
}

CameraIntrinsics CameraOf(const Json& tree) {
  CameraIntrinsics camera{.fx = tree.at("fx"),
                          .fy = tree.at("fy"),
                          .cx = tree.at("cx"),
                          .cy = tree.at("cy"),
                          .k1 = tree.at("k1"),
                          .k2 = tree.at("k2"),
                          .p1 = tree.at("p1"),
                          .p2 = tree.at("p2"),
                          .is_stored = true};
  if (tree.contains("baseline_mm")) camera.baseline_mm = tree.at("baseline_mm");
  return camera;
}

}  // namespace

Json ScrewsToJson(const Vec3<double>& screws_mm) {
  return {{"z1_mm", screws_mm[0]}, {"z2_mm", screws_mm[1]}, {"z3_mm", screws_mm[2]}};
}

double Residual_mm(const BedFound& found) {
  return found.plane.fit.dof > 0 ? found.plane.fit.rms_mm : 0;
}

BedPlane PlaneNow(const BedStore& store, const Pivots<double>& pivots_mm) {
  const BedFound& found = store.found.back();
  BedPlane plane = found.plane;
  if (!store.applied_mm) return plane;
  Eigen::Matrix3d at;
  for (int i = 0; i < kNumScrews; ++i) {
    const auto& pivot_mm = pivots_mm[static_cast<std::size_t>(i)];
    at.row(i) << pivot_mm[0], pivot_mm[1], 1;
  }
  const Vec3<double> turned = at.inverse() * *store.applied_mm;
  plane.fit.slope_x.value += turned[0];
  plane.fit.slope_y.value += turned[1];
  plane.fit.height_mm.value += turned[2];
  return plane;
}

Json ToJson(const CameraIntrinsics& camera) {
  Json tree{{"fx", camera.fx},
            {"fy", camera.fy},
            {"cx", camera.cx},
            {"cy", camera.cy},
            {"k1", camera.k1},
            {"k2", camera.k2},
            {"p1", camera.p1},
            {"p2", camera.p2}};
  if (camera.baseline_mm) tree["baseline_mm"] = *camera.baseline_mm;
  tree["source"] = camera.is_stored ? "stored" : "drawn";
  return tree;
}

Json ToJson(const BedFound& found) {
  const BedPlane& plane = found.plane;
  Json residuals = Json::array();
  for (const double residual_mm : plane.fit.residuals_mm)
    residuals.push_back(residual_mm);
  return {{"plane_equation", {{"a", plane.a()}, {"b", plane.b()}, {"c", plane.c_mm()}}},
          {"tilt_angles",
           {{"tilt_x_degrees", plane.TiltX_deg()},
            {"tilt_y_degrees", plane.TiltY_deg()},
            {"tilt_degrees", plane.Tilt_deg()}}},
          {"z_offsets", ScrewsToJson(found.offsets_mm)},
          {"residual_mm", Residual_mm(found)},
          {"measured_points", found.touches.size()},
          {"reference_height", found.reference_mm},
          {"source", found.is_by_printer ? "printer" : "given"},
          {"measured_at", found.at},
          {"points", TouchesOf(found)},
          {"residuals_mm", std::move(residuals)},
          {"uncertainty", plane.fit.dof > 0 ? UncertaintyOf(plane) : Json()},
          {"is_level", found.is_level},
          {"notes", found.notes}};
}

BedStore ReadBedStore(const fs::path& file, double sigma_mm, std::string* note) {
  BedStore store;
  std::error_code error;
  if (file.empty() || !fs::exists(file, error)) return store;
  try {
    const Json tree = Json::parse(ReadTextFile(file, kLargestFile_bytes));
    if (tree.at("format") != kFormat) throw InputError({}, "another format");
    if (tree.contains("intrinsics")) store.camera = CameraOf(tree.at("intrinsics"));
    for (const Json& one : tree.at("found")) {
      store.found.push_back(FoundOf(one, sigma_mm));
    }
    if (tree.contains("applied_mm")) store.applied_mm = ScrewsOf(tree.at("applied_mm"));
    return store;
  } catch (const nlohmann::json::exception&) {
  } catch (const InputError&) {
  }
  *note = PutAside(file);
  return {};
}

void WriteBedStore(const fs::path& file, const BedStore& store) {
  if (file.empty()) return;
  Json tree{{"format", kFormat}, {"found", Json::array()}};
  if (store.camera.is_stored) tree["intrinsics"] = ToJson(store.camera);
  for (const BedFound& found : store.found) tree["found"].push_back(KeptTree(found));
  if (store.applied_mm) tree["applied_mm"] = ScrewsToJson(*store.applied_mm);
  WriteDurably(file, tree.dump(1) + "\n");
}

}  // namespace caltwin
