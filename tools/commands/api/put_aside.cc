#include "tools/commands/api/put_aside.h"

#include <system_error>

#include <fmt/format.h>

namespace caltwin {

std::string PutAside(const std::filesystem::path& file) {
  const std::filesystem::path aside = file.string() + ".unread";
  std::error_code ignored;
  std::filesystem::rename(file, aside, ignored);
  return fmt::format("{} holds nothing this version wrote: put aside as {}",
                     file.string(),
                     aside.filename().string());
}

}  // namespace caltwin
