#include "renders/assets.h"

#include <cstdint>

// The assembler copies each file into the read-only data between two symbols. (C++23
// has #embed for this; a string literal would be too long for some compilers.)
#define CALTWIN_ASSET(symbol, file)                                         \
  asm(".pushsection .rodata\n"                                              \
      ".global " #symbol "_begin\n" #symbol                                 \
      "_begin:\n"                                                           \
      ".incbin \"" CALTWIN_SOURCE_DIR "/renders/assets/" file               \
      "\"\n"                                                                \
      ".global " #symbol "_end\n" #symbol "_end:\n.byte 0\n.popsection\n"); \
  extern "C" const char symbol##_begin[];                                   \
  extern "C" const char symbol##_end[]

CALTWIN_ASSET(caltwin_palette_css, "palette.css");
CALTWIN_ASSET(caltwin_report_css, "report.css");

namespace caltwin {
namespace {

std::string_view PartBetween(const char* begin, const char* end) {
  // Two symbols are two objects to the language: their addresses are subtracted, not
  // they.
  return {
      begin,
      reinterpret_cast<std::uintptr_t>(end) - reinterpret_cast<std::uintptr_t>(begin)};
}

}  // namespace

std::string_view PaletteCss() {
  return PartBetween(caltwin_palette_css_begin, caltwin_palette_css_end);
}
std::string_view ReportCss() {
  return PartBetween(caltwin_report_css_begin, caltwin_report_css_end);
}

}  // namespace caltwin
