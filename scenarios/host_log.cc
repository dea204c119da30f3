#include "scenarios/host_log.h"

#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace caltwin {

namespace fs = std::filesystem;

std::string WrittenIn(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string EndOfWritten(const fs::path& file) {
  constexpr std::size_t kMost = 2000;
  const std::string text = WrittenIn(file);
  return text.size() > kMost ? text.substr(text.size() - kMost) : text;
}

KeptLog::KeptLog(fs::path from, fs::path to)
    : from_(std::move(from)), to_(std::move(to)) {}

KeptLog::~KeptLog() {
  std::error_code ignored;
  constexpr auto kOver = fs::copy_options::overwrite_existing;
  if (!to_.empty()) fs::copy_file(from_, to_, kOver, ignored);
}

}  // namespace caltwin
