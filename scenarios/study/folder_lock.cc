#include "scenarios/study/folder_lock.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
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

ResultFolder::ResultFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  has_made_ = std::filesystem::create_directories(folder_, error);
  if (!error && access(folder_.c_str(), W_OK) != 0) {
    error = std::error_code(errno, std::generic_category());
  }
  if (error) {
    throw InputError({.file = folder_.string()},
                     "cannot be written to: " + error.message(),
                     "choose another folder with --out");
  }
  lock_ = FolderLock(folder_);
}

ResultFolder::~ResultFolder() {
  std::error_code error;
  if (has_made_) std::filesystem::remove(folder_, error);  // Not where it holds files.
}

}  // namespace caltwin
