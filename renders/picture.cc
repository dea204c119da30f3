#include "renders/picture.h"

#include <cstddef>

#include <png.h>

#include "sim/base/require.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

constexpr int kChannels = 3;

void Append(png_structp png, png_bytep bytes, std::size_t count) {
  auto* out = static_cast<std::string*>(png_get_io_ptr(png));
  out->append(reinterpret_cast<const char*>(bytes), count);
}

void Flush(png_structp /*png*/) {}

}  // namespace

std::string PngBytes(const Picture& picture) {
  Require(picture.rgb.size() ==
              static_cast<std::size_t>(picture.width) * picture.height * kChannels,
          "a picture has as many pixels as its width and height say");
  std::string out;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &out, Append, Flush);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height),
               8,
               PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int row = 0; row < picture.height; ++row) {
    const std::size_t start = static_cast<std::size_t>(row) * picture.width * kChannels;
    png_write_row(png, picture.rgb.data() + start);
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

void WritePng(const std::filesystem::path& file, const Picture& picture) {
  WriteTextFile(file, PngBytes(picture));
}

Picture Shrunk(const Picture& picture, int factor) {
  Require(factor > 0 && picture.width % factor == 0 && picture.height % factor == 0,
          "a picture is shrunk by a divisor of its width and height");
  Picture small{.width = picture.width / factor, .height = picture.height / factor};
  small.rgb.resize(static_cast<std::size_t>(small.width) * small.height * kChannels);
  for (int row = 0; row < small.height; ++row) {
    for (int column = 0; column < small.width * kChannels; ++column) {
      const int pixel = column / kChannels;
      const int channel = column % kChannels;
      int sum = 0;
      for (int i = 0; i < factor * factor; ++i) {
        const std::size_t y = row * factor + i / factor;
        const std::size_t x = pixel * factor + i % factor;
        sum += picture.rgb[(y * picture.width + x) * kChannels + channel];
      }
      small.rgb[static_cast<std::size_t>(row) * small.width * kChannels + column] =
          static_cast<std::uint8_t>(sum / (factor * factor));
    }
  }
  return small;
}

}  // namespace caltwin
