#pragma once

#include <filesystem>
#include <string>

namespace caltwin {

/// What a real controller has written to a file so far; empty: it has none.
std::string WrittenIn(const std::filesystem::path& file);
/// The same, at most its last 2000 bytes.
std::string EndOfWritten(const std::filesystem::path& file);

/// Copies a controller's log at the end, also where it never became ready.
class KeptLog {
 public:
  /// @param to  empty: nowhere
  KeptLog(std::filesystem::path from, std::filesystem::path to);
  ~KeptLog();
  KeptLog(const KeptLog&) = delete;
  KeptLog& operator=(const KeptLog&) = delete;

 private:
  std::filesystem::path from_, to_;
};

}  // namespace caltwin
