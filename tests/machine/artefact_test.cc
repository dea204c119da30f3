#include "sim/machine/artefact.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::StrEq;

std::vector<Artefact> Read(const std::string& text) {
  Faults faults;
  YamlMap map = ReadYamlText(text, "s.yaml", &faults);
  auto artefacts = ReadArtefacts(map);
  faults.ThrowIfAny();
  return artefacts;
}

std::string MessagesOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(BlockLying, HasTheLengthAlongTheAxisAndIsStillTheBlock) {
  for (const Axis axis : kAxes) {
    for (const double length_mm : kBlockSizes_mm) {
      const Vec3<double> size_mm = BlockLying(axis, length_mm);
      EXPECT_EQ(size_mm[Index(axis)], length_mm);

      std::array<double, 3> sorted = {size_mm[0], size_mm[1], size_mm[2]};
      std::ranges::sort(sorted);
      EXPECT_EQ(sorted, kBlockSizes_mm);
    }
  }
}

TEST(BlockLying, TheOthersDescendAlongTheRemainingAxes) {
  EXPECT_EQ(BlockLying(Axis::kX, 76.2), Vec3<double>(76.2, 50.8, 25.4));
  EXPECT_EQ(BlockLying(Axis::kX, 25.4), Vec3<double>(25.4, 76.2, 50.8));
  EXPECT_EQ(BlockLying(Axis::kY, 50.8), Vec3<double>(76.2, 50.8, 25.4));
  EXPECT_EQ(BlockLying(Axis::kZ, 76.2), Vec3<double>(50.8, 25.4, 76.2));
}

TEST(BlockLying, AnotherLengthIsOurMistake) {
  EXPECT_THROW(BlockLying(Axis::kX, 30), std::logic_error);
}

TEST(Artefacts, EveryTypeIsReadWithItsSize) {
  const auto artefacts = Read(
      "block: {type: block123, at_mm: [150, 140, 0], side: y, u_um: 0.5}\n"
      "thin: {type: web, at_mm: [0, 0, 0], side: y, thickness_mm: 2}\n"
      "bore: {type: ring, at_mm: [0, 0, 0], diameter_mm: 40, turn_deg: 90}\n"
      "hole: {type: pocket, at_mm: [0, 0, 0], width_mm: 30}\n"
      "lip: {type: ledge, at_mm: [0, 0, 0], thickness_mm: 8}\n"
      "bed: {type: plate, at_mm: [0, 0, 0], size_mm: [200, 100, 12]}\n");

  ASSERT_EQ(artefacts.size(), 6u);
  EXPECT_EQ(artefacts[0].id, "block");
  EXPECT_EQ(artefacts[0].at_mm, Vec3<double>(150, 140, 0));
  EXPECT_EQ(artefacts[0].size_mm, BlockLying(Axis::kY, 76.2));
  EXPECT_EQ(artefacts[0].u_um, 0.5);
  EXPECT_EQ(artefacts[1].size_mm, Vec3<double>(60, 2, 30));
  EXPECT_EQ(artefacts[2].size_mm[0], 40);
  EXPECT_EQ(artefacts[2].turn_deg, 90);
  EXPECT_EQ(artefacts[3].size_mm, Vec3<double>(30, 30, 20));
  EXPECT_EQ(artefacts[4].size_mm, Vec3<double>(40, 40, 8));
  EXPECT_EQ(artefacts[5].size_mm, Vec3<double>(200, 100, 12));
}

TEST(Artefacts, NamesOfTypesGoThereAndBack) {
  for (const char* name : {"block123", "web", "ring", "pocket", "ledge", "plate"}) {
    const auto artefacts =
        Read(std::string("a: {at_mm: [0, 0, 0], type: ") + name + "}\n");
    EXPECT_EQ(ToString(artefacts.at(0).type), name);
  }
}

TEST(Artefacts, AKeyOfAnotherTypeIsAFault) {
  EXPECT_THAT(MessagesOf("bore: {type: ring, at_mm: [0, 0, 0], width_mm: 30}\n"),
              StrEq("s.yaml:1:38: bore has no key 'width_mm'\n"
                    "  It knows: at_mm, diameter_mm, side, turn_deg, type, u_um"));
}

TEST(Artefacts, WhatIsMissingOrUnknownIsSaid) {
  EXPECT_THAT(MessagesOf("b: {type: blok123}\n"),
              StrEq("s.yaml:1:11: b.type = 'blok123' is not known\n"
                    "  did you mean 'block123'? It may be: block123, web, ring, "
                    "pocket, ledge, plate\n"
                    "s.yaml:1:4: b lacks the key 'at_mm'"));
}

}  // namespace
}  // namespace caltwin
