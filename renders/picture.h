#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace caltwin {

/// Pixels, 8 bits each of red, green, blue; rows from the top, without padding.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb{};
};

/// The picture as the bytes of a PNG file; the same pixels give the same bytes.
std::string PngBytes(const Picture& picture);

/// Writes a PNG beside its final name and renames. Throws InputError where that cannot
/// be done.
void WritePng(const std::filesystem::path& file, const Picture& picture);

/// The mean of each square of `factor` x `factor` pixels: what is drawn `factor` times
/// too large comes out with smooth edges. Width and height must be multiples of it.
Picture Shrunk(const Picture& picture, int factor);

}  // namespace caltwin
