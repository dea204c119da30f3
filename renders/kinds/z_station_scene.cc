#include "renders/kinds/z_station_scene.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "sim/base/require.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

constexpr double kInward_mm = ZStationWorld::kInward_mm;
constexpr double kProbeBeside_mm = 30;
constexpr double kLifted_mm = 12;  // The nozzle over the bed, where nothing moves it.
constexpr double kSteepest = 0.2;  // Of a bed that is drawn.

ModelPtr CompiledScene() {
  const SpecPtr spec = ReadSpec(ShareFolder() / "models/z_station/scene.xml");
  ModelPtr model(mj_compile(spec.get(), nullptr));
  Require(model != nullptr, "models/z_station/scene.xml compiles");
  return model;
}

}  // namespace

ZStationScene::ZStationScene(const ZStationDrawing& drawing,
                             const ZStationBuild& build,
                             double exaggerate)
    : model_(CompiledScene()), data_(mj_makeData(model_.get())) {
  const auto enlarged_mm = [&](double drawn_mm, double built_mm) {
    return drawn_mm + exaggerate * (built_mm - drawn_mm);
  };
  const double trigger_mm = enlarged_mm(drawing.trigger_mm, build.trigger_mm);
  Place("nozzle", {0, 0, enlarged_mm(0, build.tip_mm)});
  Place("probe", {kProbeBeside_mm, 0, enlarged_mm(-drawing.body_mm, build.body_mm)});
  Place("knob", {0, 0, -trigger_mm - kInward_mm});
  Place("pin",
        {drawing.switch_at_mm[0],
         drawing.switch_at_mm[1],
         enlarged_mm(drawing.switch_mm, build.switch_mm) + kInward_mm});
  Place("plate",
        {drawing.bed_at_mm[0], drawing.bed_at_mm[1], enlarged_mm(0, build.surface_mm)});
  const auto slope = [&](double built) {
    return std::clamp(exaggerate * built, -kSteepest, kSteepest);
  };
  const Vec3<double> normal(-slope(build.slope_x), -slope(build.slope_y), 1);
  SetQuat(Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal),
          model_->body_quat + 4 * BodyOf("plate"));
  SetPosition({drawing.bed_at_mm[0], drawing.bed_at_mm[1], kLifted_mm},
              data_->mocap_pos);
  mj_forward(model_.get(), data_.get());
}

int ZStationScene::BodyOf(const char* name) const {
  const int body = mj_name2id(model_.get(), mjOBJ_BODY, name);
  Require(body >= 0, "models/z_station/scene.xml has all its bodies");
  return body;
}

void ZStationScene::Place(const char* name, const Vec3<double>& at_mm) {
  SetPosition(at_mm, model_->body_pos + 3 * BodyOf(name));
}

}  // namespace caltwin
