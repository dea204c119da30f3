#include "scenarios/klipper/klipper_trial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

using Kind = MachineFault::Kind;

// The host adds what a person may do next.
std::string FirstLine(const std::string& text) {
  std::string line = text.substr(0, text.find('\n'));
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

MachineFault FaultOf(const std::string& refusal) {
  const auto says = [&](std::string_view words) {
    return refusal.find(words) != std::string::npos;
  };
  const Kind kind = says("No trigger on")         ? Kind::kNoTrigger
                    : says("Printer is shutdown") ? Kind::kAlarm
                                                  : Kind::kRefused;
  return {kind, FirstLine(refusal)};
}

// Each line by itself, without the mark that the host sets before what is meant for a
// person.
void AddLines(const std::string& printed, std::vector<std::string>* lines) {
  constexpr std::string_view kMark = "// ";
  for (const TextLine& line : LinesOf(printed)) {
    const bool is_marked = line.text.starts_with(kMark);
    lines->emplace_back(line.text.substr(is_marked ? kMark.size() : 0));
  }
}

}  // namespace

TrueFigure Flattened(double before_mm, double after_mm) {
  constexpr double kRecovered = 0.1, kFlat_mm = 0.01;
  return {.before = before_mm,
          .after = after_mm,
          .noise = kFlat_mm,
          .is_met = after_mm <= std::max(kRecovered * before_mm, kFlat_mm)};
}

Expected<std::vector<std::string>> HostLink::Send(
    std::string_view line, std::chrono::milliseconds /*patience*/) {
  if (line.starts_with(kPersonDoes)) return person_(line.substr(kPersonDoes.size()));
  try {
    if (!host_) {
      host_ = std::make_unique<KlipperHost>(board_, options_);
      ready_s_ = host_->printer_s();
    }
    HostAnswer answer = host_->Say(line);
    if (answer.refusal) {
      return tl::unexpected(FaultOf(*answer.refusal));
    }
    if (answer.shut_down) {
      return tl::unexpected(MachineFault{Kind::kAlarm, *answer.shut_down});
    }
    std::vector<std::string> lines;
    for (const std::string& printed : answer.lines) AddLines(printed, &lines);
    touches_ += static_cast<int>(std::ranges::count_if(
        lines, [](const auto& one) { return one.starts_with("probe at "); }));
    return lines;
  } catch (const HostLost& lost) {
    return tl::unexpected(MachineFault{Kind::kLinkLost, lost.what()});
  }
}

std::optional<Motors> HostLink::MotorsNow() const {
  if (!host_) return std::nullopt;
  return host_->MotorsNow();
}

KlipperTrial::KlipperTrial(const Machine& machine,
                           std::unique_ptr<Board> board,
                           KlipperHostOptions options,
                           const Chance& chance)
    : board_(std::move(board)),
      config_before_(WithIncluded(options.config, options.beside)),
      host_(board_.get(), std::move(options)),
      felt_(chance.seed, chance.sample, "feeler_gauge") {
  bench_.gauge = &gauges_;
  bench_.person = &hands_;
  bench_.machine = machine;
  host_.Beside([this](std::string_view act) { return PersonDoes(act); });
}

Expected<std::vector<std::string>> KlipperTrial::PersonDoes(std::string_view act) {
  if (act == kFeelerGauge) return GaugeUnderNozzle(/*is_taken_off=*/true);
  if (act == kPaperTest) return GaugeUnderNozzle(/*is_taken_off=*/false);
  return tl::unexpected(MachineFault{
      Kind::kRefused, "nobody is there who does that: " + std::string(act)});
}

Expected<std::vector<std::string>> KlipperTrial::Typed(
    const std::vector<std::string>& lines) {
  constexpr std::chrono::minutes kPatience{10};
  std::vector<std::string> all;
  for (const std::string& line : lines) {
    auto said = host_.Send(line, kPatience);
    if (!said) return said;
    all.push_back("typed: " + line);
    all.insert(all.end(), said->begin(), said->end());
  }
  return all;
}

Expected<std::vector<std::string>> KlipperTrial::GaugeUnderNozzle(bool is_taken_off) {
  constexpr double kGauge_mm = 0.1, kFelt_mm = 0.01, kTypes_mm = 0.001;
  constexpr int kMostLooks = 5;
  const double stops_at_mm = kGauge_mm + kFelt_mm * felt_.Normal();
  std::vector<std::string> all;
  const auto type = [&](double by_mm) {
    const auto said = Typed({fmt::format("TESTZ Z={:.3f}", by_mm)});
    if (said) all.insert(all.end(), said->begin(), said->end());
    return said;
  };
  bool is_felt = false;
  for (int i = 0; i < kMostLooks && !is_felt; ++i) {
    const auto steps = MotorsAfter({"M400"});
    if (!steps) break;
    const auto over_mm = NozzleOverBed_mm(*steps);
    if (!over_mm) break;
    const double by_mm = stops_at_mm - *over_mm;
    is_felt = std::abs(by_mm) < kFelt_mm;
    if (std::abs(by_mm) < kTypes_mm) break;
    if (const auto said = type(by_mm); !said) return said;
  }
  if (!is_felt) {
    return tl::unexpected(
        MachineFault{MachineFault::Kind::kRefused,
                     "the gauge does not come to fit under the nozzle"});
  }
  if (is_taken_off) {
    if (const auto said = type(-kGauge_mm); !said) return said;
  }
  return all;
}

void KlipperTrial::Finish(RunResult* result) {
  // What it was told to do last it may not have done yet.
  if (host_.MotorsNow()) MotorsAfter({"M400"});
  result->touches = host_.touches();
  result->machine_time_s = host_.machine_time_s();
}

std::optional<Motors> KlipperTrial::MotorsAfter(const std::vector<std::string>& lines) {
  constexpr std::chrono::minutes kPatience{10};
  for (const std::string& line : lines) {
    if (!host_.Send(line, kPatience)) return std::nullopt;
  }
  return host_.MotorsNow();
}

}  // namespace caltwin
