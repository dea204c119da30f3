// What an edit of model.xml does in MuJoCo, against the closed form by which it is
// sized: if they differ, the sealed truth is not the truth.

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/blind/physics_case.h"
#include "tests/blind/separation.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

struct Edit {
  const char* cause;
  const char* axis;
};

class EveryEdit : public ::testing::TestWithParam<Edit> {};

TEST_P(EveryEdit, DoesWhatItsClosedFormSays) {
  const auto& [cause, axis] = GetParam();
  const fs::path folder =
      fs::temp_directory_path() / ("blind_edit_" + std::to_string(getpid()));
  const Simulator simulator{.binary = CALTWIN_BINARY, .folder = folder.string()};
  CaseRequest request{.kind = "single", .seed = 11, .clean = true, .physics = true};
  request.hidden = {{cause, axis, 8}};
  Case made;
  PreparePhysicsCase(simulator, request, &made);
  const Defect& defect = made.hidden[0].defect;
  const Column expected = LinearEffect(made, defect, made.readings);

  const PhysicsReadings readings = HideInModel(simulator, made);
  fs::remove_all(folder);

  double off_squares = 0;
  double squares = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double sigma_mm = Sigma_mm(made, made.readings[i]);
    const double effect = (readings.with_mm[i] - readings.without_mm[i]) / sigma_mm;
    off_squares += std::pow(effect - defect.size * expected[i], 2);
    squares += std::pow(defect.size * expected[i], 2);
  }
  // Of a touch that ends elsewhere by a few um: waves there have another phase.
  constexpr double kNeglected = 0.1;
  EXPECT_GT(squares, 500);
  EXPECT_LT(std::sqrt(off_squares / squares), kNeglected);
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryEdit,
                         ::testing::Values(Edit{"cyclic_lead", "x"},
                                           Edit{"microstep", "y"},
                                           Edit{"pulley_eccentric", "y"},
                                           Edit{"pitch_progressive", "x"},
                                           Edit{"pitch_map", "y"},
                                           Edit{"backlash_worn", "x"},
                                           Edit{"windup_load", "y"},
                                           Edit{"squareness", "C0Y"},
                                           Edit{"squareness", "B0Z"},
                                           Edit{"squareness", "A0Z"},
                                           Edit{"straightness", "EYX"},
                                           Edit{"straightness", "EXY"},
                                           Edit{"angular", "EBX"},
                                           Edit{"angular", "EAY"},
                                           Edit{"angular", "ECY"},
                                           Edit{"gantry_sag", "EZX"},
                                           Edit{"axis_twist", "EAX"},
                                           Edit{"bed_bowl", ""},
                                           Edit{"bed_cylinder", "y"},
                                           Edit{"bed_twist", ""},
                                           Edit{"tip_size", ""}),
                         [](const auto& test) {
                           return std::string(test.param.cause) + "_" + test.param.axis;
                         });

}  // namespace
}  // namespace blind
