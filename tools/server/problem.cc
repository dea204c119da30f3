#include "tools/server/problem.h"

#include <charconv>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

constexpr int kDeepest = 64;  // Of nested lists and objects.

// The number behind the last ':' of `text`, which is cut there.
std::optional<int> CutNumber(std::string_view* text) {
  const std::size_t colon = text->rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  int number = 0;
  const char* const end = text->data() + text->size();
  const auto read = std::from_chars(text->data() + colon + 1, end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  *text = text->substr(0, colon);
  return number;
}

ProblemFault FaultOf(const std::string& message) {
  ProblemFault fault;
  std::string_view text = message;
  if (const std::size_t line = text.find('\n'); line != std::string_view::npos) {
    std::string_view hint = text.substr(line + 1);
    hint.remove_prefix(std::min(hint.find_first_not_of(" \n"), hint.size()));
    fault.hint = Printable(hint);
    text = text.substr(0, line);
  }
  const std::size_t colon = text.find(": ");
  std::string_view place = text.substr(0, colon == std::string_view::npos ? 0 : colon);
  if (const auto last = CutNumber(&place)) {
    if (const auto first = CutNumber(&place)) {
      fault.line = *first;
      fault.column = *last;
    } else {
      fault.line = *last;
    }
    fault.file = std::string(place);
    text.remove_prefix(colon + 2);
  } else if (!place.empty() && place.find(' ') == std::string_view::npos) {
    fault.file = std::string(place);
    text.remove_prefix(colon + 2);
  }
  fault.detail = Printable(text);
  return fault;
}

nlohmann::ordered_json TreeOf(const ProblemFault& fault) {
  nlohmann::ordered_json tree{{"detail", fault.detail}};
  if (!fault.hint.empty()) tree["hint"] = fault.hint;
  if (fault.pointer) tree["pointer"] = *fault.pointer;
  if (!fault.file.empty()) tree["file"] = fault.file;
  if (fault.line > 0) tree["line"] = fault.line;
  if (fault.column > 0) tree["column"] = fault.column;
  return tree;
}

}  // namespace

HttpResponse Problem::Response() const {
  nlohmann::ordered_json tree{{"type", "about:blank"},
                              {"title", std::string(ReasonOf(status_))},
                              {"status", status_},
                              {"detail", detail_}};
  for (const ProblemFault& fault : faults_) tree["errors"].push_back(TreeOf(fault));
  tree.update(more_);
  HttpResponse response = JsonResponse(tree, status_);
  response.content_type = "application/problem+json";
  return response;
}

std::vector<ProblemFault> FaultsOf(const std::vector<std::string>& messages) {
  std::vector<ProblemFault> faults;
  for (const std::string& message : messages) faults.push_back(FaultOf(message));
  return faults;
}

Problem ProblemOf(const InputError& error) {
  std::vector<ProblemFault> faults = FaultsOf(error.faults());
  std::string detail = faults.empty() ? "bad input" : faults.front().detail;
  return Problem(422, std::move(detail), std::move(faults));
}

std::string JsonLine(const nlohmann::ordered_json& tree) {
  return tree.dump(-1,
                   ' ',
                   /*ensure_ascii=*/false,
                   nlohmann::ordered_json::error_handler_t::replace);
}

HttpResponse JsonResponse(const nlohmann::ordered_json& tree, int status) {
  return {.status = status, .body = JsonLine(tree) + "\n"};
}

nlohmann::ordered_json JsonBody(const HttpRequest& request) {
  const std::string type = SmallLetters(request.Header("content-type"));
  if (!type.starts_with("application/json")) {
    throw Problem(415,
                  type.empty() ? "the request says no Content-Type"
                               : fmt::format("Content-Type is '{}'", Printable(type)),
                  {{.detail = "a JSON body is expected",
                    .hint = "send the header Content-Type: application/json"}});
  }
  const auto keep_shallow =
      [](int depth, nlohmann::ordered_json::parse_event_t, auto&) {
        if (depth > kDeepest) throw Problem(400, "the JSON is nested too deep");
        return true;
      };
  try {
    return nlohmann::ordered_json::parse(request.body, keep_shallow);
  } catch (const nlohmann::json::exception& error) {
    const std::string_view what = error.what();
    const std::size_t at = what.find("] ");
    throw Problem(
        400,
        "the body is no JSON: " +
            Printable(at == std::string_view::npos ? what : what.substr(at + 2)));
  }
}

}  // namespace caltwin
