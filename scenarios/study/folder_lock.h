#pragma once

#include <filesystem>

namespace caltwin {

/// The right to write to a folder, held by one program at a time and given back when it
/// ends, however it ends. Leaves no file.
class FolderLock {
 public:
  FolderLock() = default;
  /// Throws InputError where another holds it. File systems that know no such locks
  /// grant it to everybody.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace caltwin
