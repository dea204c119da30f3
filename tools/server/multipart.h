#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// One field of a form (RFC 7578).
struct FormPart {
  std::string name{};
  std::string file_name{};  ///< As the client says it: any text. Empty: no file.
  std::string body{};
};

/// Takes a `multipart/form-data` body apart. Throws Problem: 415 where `content_type`
/// is another, 400 where the body is broken or has more than 64 parts.
std::vector<FormPart> ReadForm(std::string_view content_type, std::string_view body);

/// A file's name without folders, of letters, digits and `._-` alone, at most 100 of
/// them, beginning with a letter or digit; "file" where nothing is left.
std::string SafeFileName(std::string_view name);

}  // namespace caltwin
