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

/// Makes a folder that something will be written to, and whether it had to be made.
/// Throws InputError where it cannot be made, or not be written to and nothing to read
/// is there.
bool MakeWritable(const std::filesystem::path& folder, bool is_to_be_read);

/// Before hours of work end at a full disk. Throws InputError where what so many runs
/// need is not there; a folder that was made for them goes again.
void RequireRoom(const std::filesystem::path& folder,
                 double runs,
                 double needed_bytes,
                 bool has_made_folder);

}  // namespace caltwin
