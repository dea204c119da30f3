#include "sim/base/yaml_check.h"

#include <algorithm>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

namespace caltwin {
namespace {

constexpr int kDeepest = 32;
constexpr int kMostOpenBrackets = 64;
constexpr std::size_t kLongestLine_bytes = 10'000;

class Checker : public YAML::EventHandler {
 public:
  explicit Checker(std::string name) : name_(std::move(name)) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) Refuse(mark, "a second document: one file holds one tree");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Check(mark, "", anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override {
    Refuse(mark, "an alias (*name) is not allowed: plain YAML only");
  }
  void OnScalar(const YAML::Mark& mark,
                const std::string& tag,
                YAML::anchor_t anchor,
                const std::string& /*value*/) override {
    Check(mark, tag, anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string& tag,
                       YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    Check(mark, tag, anchor);
    Deeper(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark,
                  const std::string& tag,
                  YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    Check(mark, tag, anchor);
    Deeper(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  [[noreturn]] void Refuse(const YAML::Mark& mark, const std::string& text) const {
    throw InputError(YamlPlace(name_, mark), text);
  }

  // yaml-cpp says "?" of a plain value and "!" of a quoted one: neither is a tag that
  // somebody wrote.
  void Check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) {
      Refuse(mark, "an anchor (&name) is not allowed: plain YAML only");
    }
    if (!tag.empty() && tag != "?" && tag != "!") {
      Refuse(mark, fmt::format("the tag '{}' is not allowed: plain YAML only", tag));
    }
  }

  void Deeper(const YAML::Mark& mark) {
    if (++depth_ > kDeepest) {
      Refuse(mark, fmt::format("nested deeper than {} levels", kDeepest));
    }
  }

  std::string name_;
  int documents_ = 0;
  int depth_ = 0;
};

}  // namespace

void CheckYamlShape(const std::string& text, const std::string& name) {
  int flow_depth = 0;
  int line = 1;
  std::size_t line_start = 0;
  bool in_comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      ++line;
      line_start = i + 1;
      in_comment = false;
      continue;
    }
    if (c == '#' && (i == line_start || text[i - 1] == ' ')) in_comment = true;
    if (in_comment) continue;
    if (c == '[' || c == '{') ++flow_depth;
    if (c == ']' || c == '}') flow_depth = std::max(0, flow_depth - 1);
    if (flow_depth > kMostOpenBrackets || i - line_start > kLongestLine_bytes) {
      throw InputError(
          {.file = name, .line = line, .column = static_cast<int>(i - line_start) + 1},
          flow_depth > kMostOpenBrackets
              ? fmt::format("more than {} brackets open at once", kMostOpenBrackets)
              : fmt::format("a line longer than {} characters", kLongestLine_bytes));
    }
  }
}

Place YamlPlace(const std::string& name, const YAML::Mark& mark) {
  if (mark.is_null()) return {.file = name};
  return {.file = name, .line = mark.line + 1, .column = mark.column + 1};
}

void CheckYamlEvents(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Checker checker(name);
  while (parser.HandleNextDocument(checker)) {
  }
}

void CheckYamlKeys(const YAML::Node& node, const std::string& name, Faults* faults) {
  if (node.IsSequence()) {
    for (const YAML::Node& item : node) CheckYamlKeys(item, name, faults);
  }
  if (!node.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const Place place = YamlPlace(name, entry.first.Mark());
    if (!entry.first.IsScalar()) {
      faults->Add(place, "a key must be a plain word");
    } else if (!seen.insert(entry.first.Scalar()).second) {
      faults->Add(place,
                  fmt::format("the key '{}' stands twice", entry.first.Scalar()));
    }
    CheckYamlKeys(entry.second, name, faults);
  }
}

}  // namespace caltwin
