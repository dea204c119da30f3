#include "sim/link/reply.h"

#include <algorithm>
#include <cctype>

namespace caltwin {
namespace {

char Small(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

std::string InSmallLetters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), Small);
  return small;
}

bool BeginsWith(std::string_view line, std::string_view words) {
  return line.size() >= words.size() &&
         std::ranges::equal(line.substr(0, words.size()), words, {}, Small);
}

bool IsFault(std::string_view line) {
  return BeginsWith(line, "error:") || BeginsWith(line, "emergency stop") ||
         line.starts_with("!!");
}

MachineFault::Kind KindOf(std::string_view reply) {
  const std::string small = InSmallLetters(reply);
  const auto says = [&](std::string_view words) {
    return small.find(words) != std::string::npos;
  };
  if (says("emergency stop")) return MachineFault::Kind::kAlarm;
  if (says("not triggered during") || says("not lose contact during") ||
      says("no trigger on ")) {
    return MachineFault::Kind::kNoTrigger;
  }
  return MachineFault::Kind::kRefused;
}

}  // namespace

Expected<std::vector<std::string>> JudgeReply(std::vector<std::string> lines) {
  const auto first = std::ranges::find_if(lines, IsFault);
  if (first == lines.end()) return lines;
  std::string reply = *first;
  for (auto line = first + 1; line != lines.end(); ++line) reply += "\n" + *line;
  const MachineFault::Kind kind = KindOf(reply);
  return tl::make_unexpected(MachineFault{.kind = kind, .reply = std::move(reply)});
}

}  // namespace caltwin
