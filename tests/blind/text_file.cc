#include "tests/blind/text_file.h"

#include <fstream>
#include <stdexcept>

namespace blind {

void WriteText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace blind
