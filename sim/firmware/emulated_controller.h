#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/text_file.h"
#include "sim/link/link.h"
#include "sim/link/reply.h"

namespace caltwin {

/// The answer to one line: what the controller prints, and whether it refused.
struct Reply {
  std::vector<std::string> lines{};  ///< Without the final `ok`.
  bool error = false;  ///< A line begins with "Error:" or the machine is in alarm.
};

/// A controller in the twin: what a line of G-code meets. One class a dialect
/// (RepRapFirmware for all that move along axes, in firmware.h; others in
/// sim/firmware/kinds).
class EmulatedController {
 public:
  virtual ~EmulatedController() = default;
  /// Obeys one line, without its newline. Never throws for what the line says.
  virtual Reply Execute(std::string_view line) = 0;
  /// Duration of all that was performed so far.
  virtual double machine_time_s() const = 0;
};

/// The wire to one, whatever its dialect: its answers as JudgeReply takes them.
class EmulatedLink final : public Link {
 public:
  /// `controller` is borrowed.
  explicit EmulatedLink(EmulatedController* controller) : controller_(controller) {}
  /// To another controller: the same one, after its power was cut.
  void Connect(EmulatedController* controller) { controller_ = controller; }
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    std::vector<std::string> lines = controller_->Execute(line).lines;
    // A controller repeats what it does not understand.
    for (std::string& said : lines) said = Printable(said);
    return JudgeReply(std::move(lines));
  }

 private:
  EmulatedController* controller_;
};

}  // namespace caltwin
