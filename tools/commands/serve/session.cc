#include "tools/commands/serve/session.h"

#include <charconv>
#include <chrono>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/link/gcode_frame.h"
#include "sim/link/reply.h"

namespace caltwin {
namespace {

/// How long a simulated move may take to compute.
constexpr std::chrono::hours kPatience{1};

bool SetsLineNumber(std::string_view text) {
  const std::string_view command = text.substr(0, text.find(' '));
  return command == "M110" || command == "m110";
}

// The 5 of `M110 N5`, which need not be numbered itself.
std::optional<int> NumberSet(std::string_view text) {
  if (!SetsLineNumber(text)) return std::nullopt;
  const std::size_t at = text.find_first_of("Nn");
  int number = 0;
  if (at == std::string_view::npos ||
      std::from_chars(text.data() + at + 1, text.data() + text.size(), number).ec !=
          std::errc()) {
    return std::nullopt;
  }
  return number;
}

void AppendLines(const std::string& text, std::vector<std::string>* lines) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines->push_back(line);
}

}  // namespace

std::vector<std::string> ServeSession::AskToResend(const std::string& why) const {
  return {fmt::format("Error:{}, Last Line: {}", why, last_number_),
          fmt::format("Resend: {}", last_number_ + 1),
          "ok"};
}

std::vector<std::string> ServeSession::Answer(std::string_view line) {
  std::string to_send(line);
  try {
    const GcodeFrame frame = ReadGcodeFrame(line);
    if (frame.number && SetsLineNumber(frame.text)) {
      last_number_ = *frame.number;
      return {"ok"};
    }
    if (const auto number = NumberSet(frame.text); !frame.number && number) {
      last_number_ = *number;
      return {"ok"};
    }
    if (frame.number && *frame.number != last_number_ + 1) {
      return AskToResend("Line Number is not Last Line Number+1");
    }
    if (frame.number) {
      last_number_ = *frame.number;
      to_send = frame.text;
    }
  } catch (const InputError& error) {
    const bool is_numbered = !line.empty() && (line[0] == 'N' || line[0] == 'n');
    if (is_numbered) return AskToResend("checksum mismatch");
    return {"Error: " + error.faults().front(), "ok"};
  }
  std::vector<std::string> answer;
  const auto reply = link_->Send(to_send, kPatience);
  if (reply) {
    for (const std::string& text : *reply) AppendLines(text, &answer);
  } else {
    // Whatever went wrong, the client must see that it did.
    const bool says_so = !JudgeReply({reply.error().reply}).has_value();
    AppendLines((says_so ? "" : "Error: ") + reply.error().reply, &answer);
  }
  answer.emplace_back("ok");
  return answer;
}

}  // namespace caltwin
