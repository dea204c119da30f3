#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"

namespace caltwin {

std::string MessagesSection(const RunResult& result,
                            const ReportPictures& /*pictures*/) {
  if (result.messages.empty()) return "";
  std::string html = "<ul>\n";
  for (const std::string& message : result.messages) {
    html += fmt::format("<li>{}</li>\n", Escaped(message));
  }
  return html + "</ul>\n";
}

}  // namespace caltwin
