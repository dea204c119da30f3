// Where tied joints are put, against their polynomials by hand.
#include "sim/physics/coupled_joints.h"

#include <array>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "sim/mjcf/mjcf.h"

namespace caltwin {
namespace {

struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

// Four sliding masses, the first of which is put somewhere, with these equalities.
class Sliders {
 public:
  explicit Sliders(const std::string& equalities) {
    std::string text = "<mujoco><worldbody>";
    for (const char* name : {"a", "b", "c", "d"}) {
      text += std::string("<body><joint name='") + name +
              "' type='slide'/><geom size='.1'/></body>";
    }
    text += "</worldbody><equality>" + equalities + "</equality></mujoco>";
    std::array<char, 500> error{};
    mjSpec* spec = mj_parseXMLString(text.c_str(), nullptr, error.data(), error.size());
    EXPECT_NE(spec, nullptr) << error.data();
    model_.reset(mj_compile(spec, nullptr));
    mj_deleteSpec(spec);
    data_.reset(mj_makeData(model_.get()));
  }

  mjData* data() { return data_.get(); }
  double position(int joint) const { return data_->qpos[joint]; }
  double speed(int joint) const { return data_->qvel[joint]; }
  void PutFirst(double position, double speed) {
    data_->qpos[0] = position;
    data_->qvel[0] = speed;
    constexpr std::array kPlaced = {0};
    CoupledJoints(model_.get(), kPlaced).Follow(model_.get(), data_.get());
  }

 private:
  ModelPtr model_{};
  std::unique_ptr<mjData, DeleteData> data_{};
};

constexpr double kExact = 1e-14;

TEST(CoupledJoints, AFollowerStandsAndMovesByItsPolynomial) {
  Sliders sliders("<joint joint1='b' joint2='a' polycoef='.1 .2 .3 .4 .5'/>");

  sliders.PutFirst(0.5, 2);

  EXPECT_NEAR(sliders.position(1),
              0.1 + 0.2 * 0.5 + 0.3 * 0.25 + 0.4 * 0.125 + 0.5 * 0.0625,
              kExact);
  EXPECT_NEAR(sliders.speed(1),
              2 * (0.2 + 2 * 0.3 * 0.5 + 3 * 0.4 * 0.25 + 4 * 0.5 * 0.125),
              kExact);
}

TEST(CoupledJoints, AChainIsFollowedWhateverTheOrderItIsWrittenIn) {
  Sliders sliders(
      "<joint joint1='c' joint2='b' polycoef='0 3 0 0 0'/>"
      "<joint joint1='b' joint2='a' polycoef='0 2 0 0 0'/>"
      "<joint joint1='d' polycoef='.7 0 0 0 0'/>");

  sliders.PutFirst(0.1, 1);

  EXPECT_NEAR(sliders.position(2), 0.6, kExact);
  EXPECT_NEAR(sliders.speed(2), 6, kExact);
  EXPECT_NEAR(sliders.position(3), 0.7, kExact);
}

TEST(CoupledJoints, AnEqualityWrittenTheOtherWayRoundIsInverted) {
  Sliders sliders("<joint joint1='a' joint2='b' polycoef='.1 .5 .2 0 0'/>");

  sliders.PutFirst(0.4, 1);

  const double b = sliders.position(1);
  EXPECT_NEAR(0.1 + 0.5 * b + 0.2 * b * b, 0.4, kExact);
  EXPECT_NEAR(sliders.speed(1), 1 / (0.5 + 0.4 * b), kExact);
}

TEST(CoupledJoints, AnEqualitySwitchedOffIsNotFollowed) {
  Sliders sliders("<joint joint1='b' joint2='a' polycoef='.1 1 0 0 0'/>");
  sliders.data()->eq_active[0] = 0;

  sliders.PutFirst(0.5, 1);

  EXPECT_EQ(sliders.position(1), 0);
}

}  // namespace
}  // namespace caltwin
