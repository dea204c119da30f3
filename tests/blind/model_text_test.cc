// Edits of a model as text, without MuJoCo.

#include "tests/blind/model_text.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace blind {
namespace {

constexpr const char* kModel = R"(<worldbody><body name="table"></body>
<body name="y_carriage"><joint name="y" class="rail" axis="0 1 0"/>
<body name="x_nut"></body><body name="x_carriage"><joint name="x" class="rail" axis="1 0 0"/>
<body name="z_nut"></body><body name="z_carriage">
<joint name="z" class="rail" axis="0 0 1"/></body></body></body></worldbody>
<fixed name="x_play"></fixed><fixed name="y_play"></fixed><fixed name="z_play"></fixed>
<equality><tendon name="x_rigid"/><tendon name="y_rigid"/><tendon name="z_rigid"/>
</equality>)";

int CountOf(const std::string& word, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos;
       at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

TEST(OverTravel, IsTheSamePolynomialOfMillimetres) {
  const AxisDrawing axis{.min_mm = 20, .max_mm = 260};
  const Polynomial over_u = {0.3, -1, 2, 0.5, -0.7};
  const Polynomial in_mm = OverTravel(over_u, axis);

  for (const double q_mm : {20.0, 95.5, 140.0, 260.0}) {
    EXPECT_NEAR(Value(in_mm, q_mm), Value(over_u, axis.Scaled(q_mm)), 1e-12) << q_mm;
  }
}

TEST(ModelText, WrapsAllThatACarriageCarries) {
  ModelText model(kModel);
  model.AddSlide(0, "x", Along(1), {0, 1});
  const std::string text = model.Text();

  const std::size_t error = text.find("<body name=\"error_1\"");
  EXPECT_LT(text.find("<body name=\"x_carriage\">"), error);
  EXPECT_LT(error, text.find("<body name=\"z_nut\">"));
  EXPECT_EQ(CountOf("<body ", text), CountOf("</body>", text));
  EXPECT_NE(text.find("</body></body></body></body></worldbody>"), std::string::npos);
}

TEST(ModelText, CouplesInMetres) {
  ModelText model(kModel);
  model.AddSlide(1, "y", Along(0), {1, 2, 3});  // mm of mm.

  EXPECT_NE(model.Text().find("polycoef=\"0.001 2 3000 0 0 \""), std::string::npos);
}

TEST(ModelText, LoosensANutByHalfItsGapToEachSide) {
  ModelText model(kModel);
  model.SetGap(0, 0.05);
  const std::string text = model.Text();

  EXPECT_NE(text.find("<tendon name=\"x_rigid\" active=\"false\""), std::string::npos);
  EXPECT_NE(text.find("range=\"-2.5"), std::string::npos);
  EXPECT_NE(text.find("<tendon name=\"y_rigid\"/>"), std::string::npos);
}

TEST(ModelText, RefusesAModelThatItDoesNotKnow) {
  EXPECT_THROW(ModelText("<mujoco/>").Text(), std::runtime_error);
}

}  // namespace
}  // namespace blind
