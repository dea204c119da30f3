#include "scenarios/linuxcnc/linuxcnc_trial.h"

#include <utility>

#include <fmt/format.h>

namespace caltwin {
namespace {

using Kind = MachineFault::Kind;

MachineFault FaultOf(const LinuxCncAnswer& answer) {
  const std::string text =
      answer.errors.empty() ? "LinuxCNC did not do it" : answer.errors.front();
  const auto says = [&](std::string_view words) {
    return text.find(words) != std::string::npos;
  };
  const Kind kind = says("without making contact") ? Kind::kNoTrigger
                    : says("non-probe move") || says("following error")
                        ? Kind::kAlarm
                        : Kind::kRefused;
  return {kind, text};
}

}  // namespace

Expected<std::vector<std::string>> LinuxCncLink::Lines(const LinuxCncAnswer& answer) {
  if (!answer.done) {
    has_failed_ = true;
    return tl::unexpected(FaultOf(answer));
  }
  std::vector<std::string> lines = answer.messages;
  if (answer.probed_mm) {
    ++touches_;
    const auto& at_mm = *answer.probed_mm;
    lines.push_back(
        fmt::format("probed at X{:.4f} Y{:.4f} Z{:.4f}", at_mm[0], at_mm[1], at_mm[2]));
  }
  return lines;
}

Expected<std::vector<std::string>> LinuxCncLink::Begin() {
  host_ = std::make_unique<LinuxCncHost>(board_, asked_.options);
  ready_s_ = host_->machine_s();
  if (!asked_.is_homed_first) return std::vector<std::string>{};
  return Lines(host_->Home());
}

Expected<std::vector<std::string>> LinuxCncLink::Send(
    std::string_view line, std::chrono::milliseconds /*patience*/) {
  try {
    if (!host_) {
      const auto begun = Begin();
      if (!begun) return begun;
    }
    return Lines(line == kRunProgram ? host_->Program(asked_.program)
                                     : host_->Mdi(line));
  } catch (const HostLost& lost) {
    has_failed_ = true;
    return tl::unexpected(MachineFault{Kind::kLinkLost, lost.what()});
  }
}

LinuxCncTrial::LinuxCncTrial(const Machine& machine,
                             std::unique_ptr<Board> board,
                             UnderLinuxCnc asked)
    : board_(std::move(board)), link_(board_.get(), std::move(asked)) {
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = machine;
}

void LinuxCncTrial::Finish(RunResult* result) {
  result->touches = link_.touches();
  result->machine_time_s = link_.machine_time_s();
}

}  // namespace caltwin
