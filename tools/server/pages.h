#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tools/server/http.h"

namespace caltwin {

/// The files of a folder, read once and held: what is not among them cannot be served,
/// whatever a path says.
class Pages {
 public:
  /// Of a missing folder none. `FILE.gz` beside FILE is sent to who takes it.
  explicit Pages(const std::filesystem::path& folder);

  bool empty() const { return files_.empty(); }
  /// The file at the path, with an ETag; "/" and paths without a dot are index.html.
  /// Throws Problem 404.
  HttpResponse Serve(const HttpRequest& request) const;

 private:
  struct File {
    std::string bytes{};
    std::string packed{};  ///< gzip; empty: none.
    std::string type{};
    std::string tag{};
  };
  std::map<std::string, File> files_{};  ///< By "/assets/x.js".
};

}  // namespace caltwin
