#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"

namespace caltwin {

std::string PicturesSection(const RunResult& /*result*/,
                            const ReportPictures& pictures) {
  if (pictures.pictures.empty()) return "";
  std::string html = "<div class=\"pictures\">\n";
  for (const ReportPicture& picture : pictures.pictures) {
    html += fmt::format(
        "<figure><img src=\"data:image/png;base64,{}\" alt=\"{}: {}\">\n"
        "<figcaption><strong>{}</strong> {}</figcaption></figure>\n",
        Base64(picture.png),
        Escaped(picture.title),
        Escaped(picture.caption),
        Escaped(picture.title),
        Escaped(picture.caption));
  }
  return html + "</div>\n";
}

}  // namespace caltwin
