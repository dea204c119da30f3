#include "tools/server/multipart.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "tools/server/http.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostParts = 64;
constexpr std::size_t kLongestName = 100;
constexpr std::size_t kLongestBoundary = 70;  // RFC 2046, 5.1.1.

Problem Broken() {
  return Problem(400, "the form is broken: a part has no end or no name");
}

// The value of `key` in "form-data; name=\"file\"; filename=\"a.csv\"".
std::optional<std::string> ParameterOf(std::string_view header, std::string_view key) {
  const std::string small = SmallLetters(header);
  const std::string sought = std::string(key) + "=";
  std::size_t at = 0;
  while ((at = small.find(sought, at)) != std::string::npos) {
    const bool is_whole = at > 0 && (small[at - 1] == ' ' || small[at - 1] == ';');
    at += sought.size();
    if (is_whole) break;
  }
  if (at == std::string::npos) return std::nullopt;
  std::string value;
  if (at < header.size() && header[at] == '"') {
    for (++at; at < header.size() && header[at] != '"'; ++at) {
      const bool is_escaped =
          header[at] == '\\' && at + 1 < header.size() && header[at + 1] == '"';
      if (is_escaped) ++at;
      value += header[at];
    }
    return value;
  }
  return std::string(header.substr(at, header.find_first_of("; \t", at) - at));
}

FormPart PartOf(std::string_view text) {
  const std::size_t end = text.find("\r\n\r\n");
  if (end == std::string_view::npos) throw Broken();
  std::string_view headers = text.substr(0, end);
  FormPart part{.body = std::string(text.substr(end + 4))};
  while (!headers.empty()) {
    const std::size_t line_end = std::min(headers.find("\r\n"), headers.size());
    const std::string_view line = headers.substr(0, line_end);
    headers.remove_prefix(std::min(line_end + 2, headers.size()));
    if (!SmallLetters(line).starts_with("content-disposition:")) continue;
    part.name = ParameterOf(line, "name").value_or("");
    part.file_name = ParameterOf(line, "filename").value_or("");
  }
  if (part.name.empty()) throw Broken();
  return part;
}

}  // namespace

std::vector<FormPart> ReadForm(std::string_view content_type, std::string_view body) {
  const auto boundary = ParameterOf(content_type, "boundary");
  const bool is_form = SmallLetters(content_type).starts_with("multipart/form-data");
  if (!is_form || !boundary || boundary->empty() ||
      boundary->size() > kLongestBoundary) {
    throw Problem(415,
                  "a form with files is expected",
                  {{.detail = "Content-Type is no multipart/form-data with a boundary",
                    .hint = "curl -F file=@data.csv .../api/diagnose"}});
  }
  const std::string mark = "--" + *boundary;
  std::vector<FormPart> parts;
  std::size_t at = body.find(mark);
  while (at != std::string_view::npos) {
    at += mark.size();
    if (body.substr(at, 2) == "--") return parts;
    if (body.substr(at, 2) != "\r\n") throw Broken();
    const std::size_t end = body.find("\r\n" + mark, at);
    if (end == std::string_view::npos) throw Broken();
    if (parts.size() >= kMostParts) {
      throw Problem(400, "the form has more than 64 parts");
    }
    parts.push_back(PartOf(body.substr(at + 2, end - at - 2)));
    at = end + 2;
  }
  throw Broken();
}

std::string SafeFileName(std::string_view name) {
  const std::size_t folder = name.find_last_of("/\\");
  if (folder != std::string_view::npos) name.remove_prefix(folder + 1);
  std::string safe;
  for (const char letter : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(letter)) != 0;
    const bool is_mark = letter == '.' || letter == '_' || letter == '-';
    if (is_plain || (is_mark && !safe.empty())) safe += letter;
    if (letter == ' ' && !safe.empty()) safe += '_';
  }
  if (safe.size() > kLongestName) safe.erase(0, safe.size() - kLongestName);
  while (!safe.empty() && std::isalnum(static_cast<unsigned char>(safe.front())) == 0) {
    safe.erase(0, 1);
  }
  return safe.empty() ? "file" : safe;
}

}  // namespace caltwin
