#include <algorithm>
#include <set>
#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"

namespace caltwin {

std::string MessagesSection(const RunResult& result,
                            const ReportPictures& /*pictures*/) {
  if (result.messages.empty()) return "";
  std::string html = "<ul>\n";
  std::set<std::string> said;
  for (const std::string& message : result.messages) {
    if (!said.insert(message).second) continue;
    const auto times = std::ranges::count(result.messages, message);
    html += fmt::format("<li>{}{}</li>\n",
                        Escaped(message),
                        times > 1 ? fmt::format(" ({} times)", times) : "");
  }
  return html + "</ul>\n";
}

}  // namespace caltwin
