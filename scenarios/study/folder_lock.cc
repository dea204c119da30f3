#include "scenarios/study/folder_lock.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  if (errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError({.file = folder.string()},
                   "another caltwin is writing there",
                   "wait until it has ended, or choose another folder with --out");
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

bool MakeWritable(const std::filesystem::path& folder, bool is_to_be_read) {
  std::error_code error;
  const bool has_made = std::filesystem::create_directories(folder, error);
  if (!error && !is_to_be_read && access(folder.c_str(), W_OK) != 0) {
    error = std::error_code(errno, std::generic_category());
  }
  if (!error) return has_made;
  throw InputError({.file = folder.string()},
                   "cannot be written to: " + error.message(),
                   "choose another folder with --out");
}

void RequireRoom(const std::filesystem::path& folder,
                 double runs,
                 double needed_bytes,
                 bool has_made_folder) {
  std::error_code error;
  const auto room = std::filesystem::space(folder, error);
  if (error) return;  // Nobody knows: then the disk itself will tell.
  const auto available_bytes = static_cast<double>(room.available);
  if (needed_bytes <= available_bytes) return;
  if (has_made_folder) std::filesystem::remove(folder, error);
  constexpr double kMega = 1e6;
  throw InputError(
      {.file = folder.string()},
      fmt::format("has {:.1f} MB of room, {:.0f} runs need about {:.1f} MB",
                  available_bytes / kMega,
                  runs,
                  needed_bytes / kMega),
      "make room, choose another folder with --out, or fewer trials");
}

}  // namespace caltwin
