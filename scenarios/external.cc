#include "scenarios/external.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/loop/controller.h"
#include "calibration/loop/outcome.h"
#include "scenarios/parameter_name.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

constexpr double kLongestTimeout_s = 86'400;
constexpr std::chrono::minutes kMovePatience{10};
constexpr const char* kOk = "ok\n";

std::vector<std::string> WordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string Lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return text;
}

std::optional<double> NumberIn(std::string_view word) {
  double value = 0;
  const auto [end, error] =
      std::from_chars(word.data(), word.data() + word.size(), value);
  const std::string_view rest(end, word.data() + word.size());
  const bool is_number = error == std::errc() && std::isfinite(value) &&
                         (rest.empty() || rest == "mm" || rest == "," || rest == ".");
  return is_number ? std::optional(value) : std::nullopt;
}

const Artefact* BlockNamed(const std::vector<Artefact>& artefacts,
                           const std::vector<std::string>& words) {
  const Artefact* only = nullptr;
  for (const Artefact& artefact : artefacts) {
    if (artefact.type != ArtefactType::kBlock123) continue;
    if (std::ranges::find(words, Lower(artefact.id)) != words.end()) return &artefact;
    only = &artefact;
  }
  return std::ranges::find(words, "block") != words.end() ? only : nullptr;
}

// What a sentence asks for, as far as simulated hands can do it.
Act ActIn(const std::string& text, const std::vector<Artefact>& artefacts) {
  Act act{.kind = Act::Kind::kOther, .text = text};
  const std::vector<std::string> words = WordsOf(Lower(text));
  const auto has = [&](const char* word) {
    return std::ranges::find(words, word) != words.end();
  };
  if (has("fit") && (has("disc") || has("ball"))) {
    act.kind = Act::Kind::kFitStylus;
    act.artefact = has("disc") ? "disc" : "ball";
    return act;
  }
  const Artefact* block = BlockNamed(artefacts, words);
  std::optional<double> length_mm;
  std::optional<Axis> axis;
  for (const std::string& word : words) {
    const auto number = NumberIn(word);
    for (const double size_mm : kBlockSizes_mm) {
      if (number && std::abs(*number - size_mm) < 1e-6) length_mm = size_mm;
    }
    if (const auto named = AxisNamed(word)) axis = named;
  }
  if (block == nullptr || !length_mm || !axis) return act;
  act.kind = Act::Kind::kTurnBlock;
  act.artefact = block->id;
  act.axis = Letter(*axis);
  act.length_mm = *length_mm;
  return act;
}

}  // namespace

ExternalCommand ReadExternal(YamlMap options) {
  ExternalCommand command;
  if (const auto words = options.Required("command")) {
    for (const YamlValue& word : words->List()) {
      command.child.words.push_back(word.Text());
    }
    if (words->is_list() && command.child.words.empty()) {
      words->Fail("is empty",
                  "write the program and its arguments: [python3, mine.py]");
    }
  }
  const double timeout_s =
      options.NumberOr("timeout_s", 600, {0.01, kLongestTimeout_s});
  command.child.patience = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::duration<double>(timeout_s));
  command.child.folder = std::filesystem::path(options.file()).parent_path();
  options.NoMoreKeys();
  return command;
}

std::string ExternalProtocol::Answer(std::string_view line) {
  const std::vector<std::string> words = WordsOf(std::string(line));
  if (words.empty()) return kOk;
  if (words[0] != "M118" || words.size() < 2) return SendToMachine(line);
  const std::string& what = words[1];
  if (what == "ESTIMATE") return TakeEstimate(words);
  if (what == "OPERATOR") {
    const std::size_t start = line.find(what) + what.size();
    const std::string_view text = line.substr(start);
    const std::size_t first = text.find_first_not_of(' ');
    return Ask(std::string(first == std::string_view::npos ? "" : text.substr(first)));
  }
  if (what != "GAUGE" && what != "ZERO") return SendToMachine(line);
  if (words.size() != 3) {
    return fmt::format("Error: M118 {} takes one id, such as laser.x\n{}", what, kOk);
  }
  if (what == "GAUGE") return ReadGauge(words[2]);
  const auto zeroed = bench_->gauge->Zero(words[2]);
  return zeroed ? kOk : Fault(zeroed.error());
}

std::string ExternalProtocol::Fault(const MachineFault& fault) {
  ending_ = EndingOfFault(fault);
  fault_ = fault.reply;
  const char* prefix = fault.reply.starts_with("Error") ? "" : "Error: ";
  return fmt::format("{}{}\n{}", prefix, fault.reply, kOk);
}

std::string ExternalProtocol::ReadGauge(const std::string& id) {
  const auto still = bench_->link->Send("M400", kMovePatience);
  if (!still) return Fault(still.error());
  const auto value_mm = bench_->gauge->Read_mm(id);
  if (!value_mm) return Fault(value_mm.error());
  return fmt::format("gauge {} {:.7f}\n{}", id, *value_mm, kOk);
}

std::string ExternalProtocol::Ask(const std::string& text) {
  const auto done = bench_->person->Do(ActIn(text, bench_->artefacts));
  return done ? kOk : Fault(done.error());
}

std::string ExternalProtocol::TakeEstimate(const std::vector<std::string>& words) {
  const auto value = words.size() == 5 ? NumberIn(words[3]) : std::nullopt;
  const auto sd = words.size() == 5 ? NumberIn(words[4]) : std::nullopt;
  if (!value || !sd || *sd < 0) {
    return fmt::format(
        "Error: M118 ESTIMATE takes a name, a value and its standard uncertainty, such "
        "as backlash.x 0.05 0.001\n{}",
        kOk);
  }
  const auto parameter = FindParameter(words[2], bench_->machine.kind);
  estimates_.push_back({.name = Printable(words[2]),
                        .unit = parameter ? std::string(parameter->unit) : "",
                        .value = *value,
                        .sd = *sd,
                        .identifiable = true});
  return kOk;
}

std::string ExternalProtocol::SendToMachine(std::string_view line) {
  const auto reply = bench_->link->Send(line, kMovePatience);
  if (!reply) return Fault(reply.error());
  std::string text;
  for (const std::string& answer : *reply) text += answer + "\n";
  return text + kOk;
}

ExternalRun RunExternal(const ExternalCommand& command, Bench* bench) {
  ExternalProtocol protocol(bench);
  ExternalRun run;
  run.end = ConverseWith(command.child,
                         [&](std::string_view line) { return protocol.Answer(line); });
  run.result.estimates = protocol.estimates();
  // A program may go on after a probe that found nothing; a collision or an alarm is
  // the machine's, whatever the program makes of it.
  const bool stopped_the_machine =
      protocol.ending() == Ending::kCollision || protocol.ending() == Ending::kAlarm;
  if (run.passed() && !stopped_the_machine) return run;
  // A program that gave up after a fault of the machine: the fault is the outcome.
  run.result.ending = run.lost() ? Ending::kLinkLost : protocol.ending();
  run.result.fault = protocol.fault();
  run.result.messages.push_back(fmt::format(
      "external {}: {}", fmt::join(command.child.words, " "), ToString(run.end)));
  if (!run.end.last_words.empty()) {
    run.result.messages.push_back("its last words: " + run.end.last_words);
  }
  return run;
}

}  // namespace caltwin
