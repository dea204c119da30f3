#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"

namespace caltwin {
namespace {

/// `text` as one word of a shell command.
std::string ShellWord(const std::string& text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=:,";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace

std::string ProvenanceSection(const RunResult& result,
                              const ReportPictures& /*pictures*/) {
  const std::string command =
      fmt::format("caltwin run {} --fidelity {} --seed {} --report out/report",
                  ShellWord(result.scenario),
                  result.fidelity,
                  result.seed);
  return fmt::format(
      "<p>caltwin {} with the scenario below, seed {}, {} fidelity, machine {}. The "
      "same "
      "version gives the same numbers:</p>\n<pre tabindex=\"0\"><code>{}</code></pre>\n"
      "<details open><summary>The scenario, verbatim</summary>\n"
      "<pre tabindex=\"0\"><code>{}</code></pre></details>\n",
      CALTWIN_VERSION,
      result.seed,
      Escaped(result.fidelity),
      Escaped(result.machine),
      Escaped(command),
      Escaped(result.verbatim));
}

}  // namespace caltwin
