#pragma once

#include <filesystem>
#include <string_view>

namespace caltwin {

/// A folder that is gone with its owner, `BEGIN_PID_XXXXXX`. Folders of that beginning
/// whose owners were killed are removed when the next one is made.
class TemporaryFolder {
 public:
  /// @param begin  "caltwin_server"
  /// @param where  the system's place for temporary files
  explicit TemporaryFolder(
      std::string_view begin,
      const std::filesystem::path& where = std::filesystem::temp_directory_path());
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_{};
};

}  // namespace caltwin
