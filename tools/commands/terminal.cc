#include "tools/commands/terminal.h"

#include <charconv>
#include <cmath>
#include <iostream>
#include <optional>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "scenarios/interrupt.h"

namespace caltwin {
namespace {

tl::unexpected<MachineFault> Refused(const std::string& text) {
  return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, text});
}

// Until there is a line to read, or Ctrl-C was pressed.
bool WaitForLine() {
  constexpr int kLook_ms = 100;
  while (!InterruptRequested()) {
    if (std::cin.rdbuf()->in_avail() > 0) return true;
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (poll(&input, 1, kLook_ms) > 0) return true;
  }
  return false;
}

std::optional<std::string> AskLine(const std::string& prompt) {
  std::cerr << prompt << std::flush;
  std::string answer;
  if (!WaitForLine() || !std::getline(std::cin, answer)) return std::nullopt;
  return answer;
}

// Why nobody answered.
tl::unexpected<MachineFault> NoAnswer() {
  return Refused(InterruptRequested() ? "interrupted" : "the terminal was closed");
}

std::optional<double> NumberIn(const std::string& text) {
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number =
      error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  return is_number ? std::optional(value) : std::nullopt;
}

}  // namespace

bool CanAsk() {
  return isatty(STDIN_FILENO) == 1;
}

Expected<void> TerminalOperator::Do(const Act& act) {
  const bool confirm = act.kind == Act::Kind::kConfirm;
  if (confirm && !options_.apply) {
    return Refused("not applied: this run only measures (--apply applies)");
  }
  // --yes agrees to settings; a block turns only by a hand that says so.
  if (options_.yes && confirm) return {};
  if (!CanAsk()) {
    return Refused(fmt::format("nobody can be asked ('{}'): stdin is no terminal{}",
                               act.text,
                               confirm ? "; --yes answers" : ""));
  }
  const auto answer = AskLine(
      act.text + (confirm ? " [y/n] " : " Press Enter when done, n to refuse. "));
  if (!answer) return NoAnswer();
  const bool agreed =
      confirm ? *answer == "y" || *answer == "yes" : *answer != "n" && *answer != "no";
  if (agreed) return {};
  return Refused("the operator refused");
}

Expected<double> TerminalGauge::Read_mm(std::string_view id) {
  const auto given = given_.find(std::string(id));
  if (given != given_.end()) return given->second;
  if (!CanAsk()) {
    return Refused(fmt::format(
        "nobody can read {}: stdin is no terminal; --reading {}=VALUE gives it",
        id,
        id));
  }
  while (const auto answer = AskLine(fmt::format("Reading of {} [mm]: ", id))) {
    if (const auto value_mm = NumberIn(*answer)) return *value_mm;
    std::cerr << fmt::format("'{}' is not a number of millimetres\n", *answer);
  }
  return NoAnswer();
}

Expected<void> TerminalGauge::Zero(std::string_view id) {
  return TerminalOperator({.apply = true})
      .Do({.kind = Act::Kind::kOther, .text = fmt::format("Zero {} here.", id)});
}

}  // namespace caltwin
