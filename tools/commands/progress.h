#pragma once

#include <string>

namespace caltwin {

/// One line on the terminal that says what is being done; nothing at all where stderr
/// is no terminal. Cleared when it goes.
class ProgressLine {
 public:
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();

  void Show(const std::string& text);
  void Clear();

 private:
  bool is_terminal_;
  bool is_shown_ = false;
};

/// Whether stdout is a terminal, read by a person.
bool IsTerminal();
/// Whether stdout may be painted: a terminal, and NO_COLOR is not set.
bool MayPaint();

}  // namespace caltwin
