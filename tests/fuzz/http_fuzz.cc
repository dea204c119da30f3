#include "tests/fuzz/fuzz.h"
#include "tools/server/http.h"
#include "tools/server/json_keys.h"
#include "tools/server/multipart.h"
#include "tools/server/problem.h"

namespace {

// What a client sends: a target, a form, a body of JSON. The first line is the target.
void ReadAll(const std::string& text) {
  using namespace caltwin;
  const std::size_t line = text.find('\n');
  HttpRequest request{.headers = {{"content-type", "application/json"}}};
  ReadTarget(std::string_view(text).substr(0, line), &request);
  request.body = line == std::string::npos ? "" : text.substr(line + 1);
  try {
    for (const FormPart& part :
         ReadForm("multipart/form-data; boundary=XX", request.body)) {
      SafeFileName(part.file_name);
    }
  } catch (const Problem& problem) {
    problem.Response();
  }
  try {
    const nlohmann::ordered_json body = JsonBody(request);
    JsonKeys keys(body);
    keys.Number("fx", {1, 100, "mm"});
    keys.Tuples("probe_points", 3, 1, 9);
    keys.Object("entries", 1000);
    keys.Integer("id", 0, 9, 1);
    keys.Done();
  } catch (const Problem& problem) {
    problem.Response();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return caltwin::Try(data, size, ReadAll);
}
