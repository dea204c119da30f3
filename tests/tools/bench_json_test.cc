#include "tools/commands/api/bench_json.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

TEST(BenchJson, AnArtefactOfATwinHasItsPlaceAndTheBoxAroundIt) {
  const Artefact block{.id = "block",
                       .at_mm = {150, 140, 0},
                       .size_mm = BlockLying(Axis::kX, kBlockSizes_mm[2]),
                       .turn_deg = 30};
  const Artefact ring{
      .id = "ring", .type = ArtefactType::kRing, .size_mm = {40, 0, 20}};

  const Json lying = ToJson(block, /*is_twin=*/true);
  const Json round = ToJson(ring, /*is_twin=*/true);

  EXPECT_EQ(lying["type"], "block123");
  EXPECT_EQ(lying["at_mm"], Json({150.0, 140.0, 0.0}));
  EXPECT_EQ(lying["size_mm"], Json({76.2, 50.8, 25.4}));
  EXPECT_EQ(lying["turn_deg"], 30);
  EXPECT_GT(round["size_mm"][0], 40);
  EXPECT_EQ(round["size_mm"][0], round["size_mm"][1]);
  EXPECT_EQ(round["size_mm"][2], 20);
}

TEST(BenchJson, NobodyKnowsWhereTheArtefactOfARealMachineLies) {
  const Json tree = ToJson(Artefact{.id = "block"}, /*is_twin=*/false);

  EXPECT_EQ(tree["id"], "block");
  EXPECT_TRUE(tree["at_mm"].is_null());
  EXPECT_TRUE(tree["size_mm"].is_null());
  EXPECT_TRUE(tree["turn_deg"].is_null());
}

}  // namespace
}  // namespace caltwin
