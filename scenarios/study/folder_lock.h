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

/// A folder that something will be written to at the end of long work: made, locked and
/// found to be writable before it begins. One that was made and stayed empty goes
/// again.
class ResultFolder {
 public:
  /// Throws InputError where it cannot be made or written to, or another program holds
  /// it.
  explicit ResultFolder(std::filesystem::path folder);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::filesystem::path folder_;
  bool has_made_ = false;
  FolderLock lock_{};
};

}  // namespace caltwin
