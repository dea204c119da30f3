#include "tools/server/pages.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/sha256.h"
#include "sim/base/text_file.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

struct Type {
  std::string_view ending, type;
};
constexpr std::array kTypes = {Type{".html", "text/html; charset=utf-8"},
                               Type{".js", "text/javascript; charset=utf-8"},
                               Type{".css", "text/css; charset=utf-8"},
                               Type{".json", "application/json"},
                               Type{".svg", "image/svg+xml"},
                               Type{".png", "image/png"},
                               Type{".ico", "image/x-icon"},
                               Type{".woff2", "font/woff2"},
                               Type{".txt", "text/plain; charset=utf-8"}};

// A page loads nothing from elsewhere, and nobody puts it into a frame of theirs.
constexpr std::string_view kPolicy =
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'self'";

std::string TypeOf(const std::string& name) {
  const auto* const found = std::ranges::find_if(
      kTypes, [&](const Type& one) { return name.ends_with(one.ending); });
  return std::string(found == kTypes.end() ? "application/octet-stream" : found->type);
}

std::string BytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

Pages::Pages(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (!entry.is_regular_file(error)) continue;
    std::string name = "/" + entry.path().lexically_relative(folder).generic_string();
    std::string bytes = BytesOf(entry.path());
    if (name.ends_with(".gz")) {
      files_[name.substr(0, name.size() - 3)].packed = std::move(bytes);
      continue;
    }
    File& file = files_[name];
    file.tag = "\"" + Sha256(bytes).substr(0, 16) + "\"";
    file.type = TypeOf(name);
    file.bytes = std::move(bytes);
  }
}

HttpResponse Pages::Serve(const HttpRequest& request) const {
  const bool is_file = request.path.find('.') != std::string::npos;
  const auto found = files_.find(is_file ? request.path : "/index.html");
  if (found == files_.end()) {
    throw Problem(404, fmt::format("no page is at {}", Printable(request.path)));
  }
  const File& file = found->second;
  // What Vite names by its contents never changes.
  const bool is_for_ever = found->first.starts_with("/assets/");
  HttpResponse response{
      .content_type = file.type,
      .headers = {{"ETag", file.tag},
                  {"Vary", "Accept-Encoding"},
                  {"Content-Security-Policy", std::string(kPolicy)},
                  {"Cache-Control",
                   is_for_ever ? "public, max-age=31536000, immutable" : "no-cache"}}};
  if (request.Header("if-none-match") == file.tag) {
    response.status = 304;
    return response;
  }
  const bool is_packed =
      !file.packed.empty() &&
      request.Header("accept-encoding").find("gzip") != std::string::npos;
  if (is_packed) response.headers.emplace_back("Content-Encoding", "gzip");
  response.body = is_packed ? file.packed : file.bytes;
  return response;
}

}  // namespace caltwin
