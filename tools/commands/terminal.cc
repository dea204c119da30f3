#include "tools/commands/terminal.h"

#include <charconv>
#include <cmath>
#include <iostream>
#include <optional>

#include <fmt/format.h>
#include <unistd.h>

namespace caltwin {
namespace {

tl::unexpected<MachineFault> Refused(const std::string& text) {
  return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, text});
}

std::optional<std::string> AskLine(const std::string& prompt) {
  std::cerr << prompt << std::flush;
  std::string answer;
  if (!std::getline(std::cin, answer)) return std::nullopt;
  return answer;
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
  if (!answer) return Refused("the terminal was closed");
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
  return Refused("the terminal was closed");
}

Expected<void> TerminalGauge::Zero(std::string_view id) {
  return TerminalOperator({.apply = true})
      .Do({.kind = Act::Kind::kOther, .text = fmt::format("Zero {} here.", id)});
}

}  // namespace caltwin
