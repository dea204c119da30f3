#include "scenarios/linuxcnc/linuxcnc_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "scenarios/position_error.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Kind = MachineFault::Kind;

MachineFault FaultOf(const LinuxCncAnswer& answer) {
  const std::string text =
      answer.errors.empty() ? "LinuxCNC did not do it" : answer.errors.front();
  const auto says = [&](std::string_view words) {
    return text.find(words) != std::string::npos;
  };
  const Kind kind =
      says("without making contact") ? Kind::kNoTrigger
      : says("non-probe move") || says("following error") || says("is jammed")
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
  for (const auto& at_mm : answer.probed_mm) {
    ++touches_;
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
    return Lines(line == kRunProgram
                     ? host_->Program(asked_.program_name, asked_.program)
                     : host_->Mdi(line));
  } catch (const HostLost& lost) {
    has_failed_ = true;
    return tl::unexpected(MachineFault{Kind::kLinkLost, lost.what()});
  }
}

UnderLinuxCnc Completed(UnderLinuxCnc asked, const linuxcnc::MachineText& machine) {
  LinuxCncFiles& files = asked.options.files;
  if (files.empty()) files = linuxcnc::ConfigFiles(machine, "dummy", "caltwin");
  files.insert(files.end(), asked.more_files.begin(), asked.more_files.end());
  return asked;
}

PlacesReached ReachedBy(const std::vector<Vec3<double>>& errors_mm) {
  Vec3<double> mean_mm = Vec3<double>::Zero();
  for (const Vec3<double>& error_mm : errors_mm) mean_mm += error_mm;
  mean_mm /= static_cast<double>(errors_mm.size());
  double squares = 0, most_mm = 0;
  for (const Vec3<double>& error_mm : errors_mm) {
    const double off_mm = (error_mm - mean_mm).norm();
    squares += off_mm * off_mm;
    most_mm = std::max(most_mm, off_mm);
  }
  return {.zero_shift_mm = mean_mm.norm(),
          .rms_mm = std::sqrt(squares / static_cast<double>(errors_mm.size())),
          .p95_mm = P95AboutMean_mm(errors_mm),
          .most_mm = most_mm};
}

LinuxCncTrial::LinuxCncTrial(const Machine& machine,
                             std::unique_ptr<Board> board,
                             UnderLinuxCnc asked)
    : board_(std::move(board)), link_(board_.get(), std::move(asked)) {
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = machine;
}

std::optional<PlacesReached> LinuxCncTrial::Reached() {
  constexpr std::chrono::minutes kPatience{10};
  const auto is_done = [&](const std::string& line) {
    const auto said = link_.Send(line, kPatience);
    if (!said) refusal_ = line + ": " + said.error().reply;
    return said.has_value();
  };
  // Whatever the lines before have left in force.
  if (!is_done("G21 G90 G40 G49 G80 G94")) return std::nullopt;
  std::vector<Vec3<double>> errors_mm;
  for (const Stop& stop : Stops()) {
    const std::string line = fmt::format(
        "G53 G0 X{:.6f} Y{:.6f} Z{:.6f}", stop.at_mm[0], stop.at_mm[1], stop.at_mm[2]);
    if (!is_done(line)) return std::nullopt;
    if (stop.is_looked_at) errors_mm.push_back(Tip_mm(link_.MotorsNow()) - stop.at_mm);
  }
  return ReachedBy(errors_mm);
}

void LinuxCncTrial::Finish(RunResult* result) {
  result->touches = link_.touches();
  result->machine_time_s = link_.machine_time_s();
  before_ = ReachedBy(Uncorrected_mm(Stops()));
  if (!link_.has_failed()) after_ = Reached();
}

TrueEnd LinuxCncTrial::End(const std::vector<ProcedureResult>& /*results*/,
                           RunResult* result) {
  if (!after_) {
    result->messages.push_back(
        "LinuxCNC could not be sent to all places at the end: how true they are is not "
        "known" +
        (refusal_.empty() ? "" : " (" + refusal_ + ")"));
    return {.told_wrong = true};
  }
  result->messages.push_back(fmt::format(
      "the tip is {:.1f} um (p95) from where LinuxCNC sends it, {:.1f} at most, but "
      "for a "
      "shift of the zero by {:.1f} um; without corrections it would be {:.1f} um",
      UmFromMm(after_->p95_mm),
      UmFromMm(after_->most_mm),
      UmFromMm(after_->zero_shift_mm),
      UmFromMm(before_->p95_mm)));
  constexpr double kRecovered = 0.1, kSeen_mm = 0.002;
  const double fine_mm = std::max(kSeen_mm, Step_mm());
  return {.figure =
              TrueFigure{.before = before_->p95_mm,
                         .after = after_->p95_mm,
                         .noise = fine_mm,
                         .is_met = after_->p95_mm <=
                                   std::max(kRecovered * before_->p95_mm, fine_mm)}};
}

double LinuxCncTrial::Figure(const std::string& name, const RunResult& /*result*/) {
  if (!after_) return std::numeric_limits<double>::quiet_NaN();
  if (name == "position_error_mm.p95") return after_->p95_mm;
  if (name == "position_error_mm.rms") return after_->rms_mm;
  if (name == "position_error_mm.most") return after_->most_mm;
  if (name == "zero_shift_mm") return after_->zero_shift_mm;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace caltwin
