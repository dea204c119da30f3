// The solids of artefacts as built against the closed forms that predict touches.
#include "sim/effects/acts/artefacts.h"

#include <vector>

#include <gtest/gtest.h>

#include "sim/effects/predict.h"
#include "sim/machine/surface.h"

namespace caltwin {
namespace {

constexpr double kRounding_mm = 1e-12;
const Vec3<double> kMiddle_mm(150, 140, 0);

Artefact Drawn(ArtefactType type, const Vec3<double>& size_mm) {
  Artefact artefact{.id = "piece", .type = type};
  artefact.at_mm = kMiddle_mm;
  artefact.size_mm = size_mm;
  return artefact;
}

// How much further out the surface that `tip_mm` is nearest to stands than as drawn.
double Moved_mm(const Artefact& drawn,
                const std::vector<Injected>& effects,
                const Vec3<double>& tip_mm) {
  const std::vector<Artefact> built = BuiltArtefacts({drawn}, effects);
  return NearestOf(SolidsOf(drawn), tip_mm).distance_mm -
         NearestOf(SolidsOf(built[0]), tip_mm).distance_mm;
}

double Predicted_mm(const std::vector<Injected>& effects,
                    const Vec3<double>& tip_mm,
                    const Vec3<double>& n,
                    bool inside = false) {
  const At at{.q_mm = tip_mm,
              .n = n,
              .on_table = true,
              .artefact = "piece",
              .inside = inside,
              .artefact_mid_mm = kMiddle_mm};
  return ErrorsAt<double>(Machine{}, at, effects).artefact_mm;
}

std::vector<Injected> With(const char* effect, const char* axis, double value) {
  return {{.effect = *FindEffect(effect), .axis = axis, .values = {value}}};
}

TEST(BuiltArtefacts, ALargerBlockStandsOutAsTheClosedFormSays) {
  const Artefact block = Drawn(ArtefactType::kBlock123, {76.2, 50.8, 25.4});
  const auto larger = With("block_size", "piece", 40);

  for (const Vec3<double>& n :
       {Vec3<double>(1, 0, 0), {0, -1, 0}, Vec3<double>(0, 0, 1)}) {
    const Vec3<double> tip_mm = kMiddle_mm + Vec3<double>(0, 0, 12) + 60 * n;
    EXPECT_NEAR(
        Moved_mm(block, larger, tip_mm), Predicted_mm(larger, tip_mm, n), kRounding_mm);
  }
}

TEST(BuiltArtefacts, ALargerRingAndPocketRecedeInside) {
  const auto larger = With("block_size", "piece", 40);
  for (const ArtefactType type : {ArtefactType::kRing, ArtefactType::kPocket}) {
    const Artefact bore = Drawn(type, {50, 0, 20});
    const Vec3<double> tip_mm = kMiddle_mm + Vec3<double>(20, 0, 10);

    EXPECT_NEAR(Moved_mm(bore, larger, tip_mm),
                Predicted_mm(larger, tip_mm, {-1, 0, 0}, /*inside=*/true),
                kRounding_mm);
  }
}

TEST(BuiltArtefacts, AThickerLipGrowsUpwards) {
  const Artefact ledge = Drawn(ArtefactType::kLedge, {40, 40, 10});
  const auto thicker = With("block_size", "piece", 40);
  const Vec3<double> above_mm = kMiddle_mm + Vec3<double>(0, 0, 50);
  const Vec3<double> below_mm = kMiddle_mm + Vec3<double>(0, 15, 25);

  EXPECT_NEAR(Moved_mm(ledge, thicker, above_mm), 0.040, kRounding_mm);
  EXPECT_NEAR(Moved_mm(ledge, thicker, below_mm), 0, kRounding_mm);
  EXPECT_EQ(Predicted_mm(thicker, below_mm, {0, 0, -1}), 0);
}

TEST(BuiltArtefacts, ATurnedBlockIsFeltWhereTheClosedFormSays) {
  const Artefact block = Drawn(ArtefactType::kBlock123, {76.2, 50.8, 25.4});
  for (const char* axis : {"", "piece"}) {
    const auto turned = With("block_rotated", axis, 5);
    const std::vector<Artefact> built = BuiltArtefacts({block}, turned);
    const Vec3<double> n(1, 0, 0);

    // Sought: the tip's place, at 15 mm along the face, 1 mm from the turned face.
    Vec3<double> tip_mm = kMiddle_mm + Vec3<double>(39.1, 15, 12);
    for (int i = 0; i < 20; ++i) {
      tip_mm[0] -= NearestOf(SolidsOf(built[0]), tip_mm).distance_mm - 1;
    }

    EXPECT_NEAR(tip_mm[0] - (kMiddle_mm[0] + 38.1 + 1),
                Predicted_mm(turned, tip_mm, n),
                kRounding_mm)
        << axis;
  }
}

// Whichever side it lies on, each size has its own error.
TEST(BuiltArtefacts, SizesAreOffEachByItsOwn) {
  Artefact block = Drawn(ArtefactType::kBlock123, {76.2, 25.4, 50.8});
  block.off_mm = {0.001, -0.002, 0.003};

  const auto built = BuiltArtefacts({block}, {});

  const Vec3<double> off_mm = built[0].size_mm - block.size_mm;
  EXPECT_TRUE(off_mm.isApprox(Vec3<double>(0.003, 0.001, -0.002), 1e-9));
}

TEST(BuiltArtefacts, AnotherArtefactStaysAsDrawn) {
  const Artefact block = Drawn(ArtefactType::kBlock123, {76.2, 50.8, 25.4});

  const auto built = BuiltArtefacts({block}, With("block_size", "other", 40));

  EXPECT_EQ(built[0].size_mm, block.size_mm);
}

}  // namespace
}  // namespace caltwin
