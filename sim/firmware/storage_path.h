#pragma once

#include <string>

namespace caltwin {

/// A path in the controller's storage in its one spelling: without the drive "0:" or a
/// leading slash; a bare file name lies in the system folder, "sys/homeall.g".
std::string StoragePath(const std::string& path);

}  // namespace caltwin
