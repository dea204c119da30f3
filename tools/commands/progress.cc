#include "tools/commands/progress.h"

#include <cstdlib>
#include <iostream>

#include <unistd.h>

namespace caltwin {
namespace {

constexpr std::size_t kProgressWidth = 78;
constexpr const char* kBeginAgain = "\r\033[K";

}  // namespace

ProgressLine::ProgressLine() : is_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  Clear();
}

void ProgressLine::Show(const std::string& text) {
  if (!is_terminal_) return;
  std::cerr << kBeginAgain << text.substr(0, std::min(kProgressWidth, text.find('\n')))
            << std::flush;
  is_shown_ = true;
}

void ProgressLine::Clear() {
  if (is_shown_) std::cerr << kBeginAgain << std::flush;
  is_shown_ = false;
}

bool IsTerminal() {
  return isatty(STDOUT_FILENO) == 1;
}

bool MayPaint() {
  return IsTerminal() && std::getenv("NO_COLOR") == nullptr;
}

}  // namespace caltwin
