#include "renders/picture.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

namespace caltwin {
namespace {

Picture Small() {
  return {.width = 2, .height = 1, .rgb = {10, 20, 30, 200, 100, 0}};
}

TEST(Picture, ComesBackFromItsPng) {
  const std::string bytes = PngBytes(Small());

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr), 0);

  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 1);
  EXPECT_EQ(rgb, Small().rgb);
}

TEST(Picture, ShrinksToTheMeanOfItsPixels) {
  const Picture large{
      .width = 2, .height = 2, .rgb = {0, 0, 0, 100, 0, 8, 100, 0, 0, 200, 4, 0}};

  const Picture small = Shrunk(large, 2);

  EXPECT_EQ(small.rgb, (std::vector<std::uint8_t>{100, 1, 2}));
}

}  // namespace
}  // namespace caltwin
