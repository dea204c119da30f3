#include "sim/base/text_file.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

std::string ReadTextFile(const fs::path& file, std::size_t most_bytes) {
  const Place place{.file = file.string()};
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) throw InputError(place, "there is no such file");
  if (fs::is_directory(status)) {
    throw InputError(place, "this is a folder, where a file is wanted");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(place, "this file cannot be read");
  std::string text;
  text.resize(most_bytes + 1);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > most_bytes) {
    throw InputError(place,
                     fmt::format("larger than any file of this kind (at most {} bytes)",
                                 most_bytes));
  }
  return text;
}

void WriteTextFile(const fs::path& file, const std::string& text) {
  const Place place{.file = file.string()};
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  const fs::path beside = file.string() + fmt::format(".{}.part", ::getpid());
  std::ofstream out(beside, std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    fs::remove(beside, error);
    throw InputError(place, "this file cannot be written");
  }
  fs::rename(beside, file, error);
  if (error) {
    fs::remove(beside, error);
    throw InputError(place, "this file cannot be written");
  }
}

}  // namespace caltwin
