#include <array>
#include <functional>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/firmware/parts.h"
#include "sim/firmware/storage_path.h"

namespace caltwin {
namespace {

using rrf::Value;

constexpr std::string_view kEmergencyWords =
    "Emergency Stop! Reset the controller to continue.";

using Handler = Reply (Firmware::Parts::*)(const rrf::Words& words);
struct Entry {
  char letter;
  int code;
  Handler run;
  bool when_halted = false;
};

/// Commands that need nothing but their words.
constexpr std::array kCommands = {
    Entry{'G', 4, &Firmware::Parts::Dwell},
    Entry{'G', 10, &Firmware::Parts::SetWorkOffset},
    Entry{'G', 28, &Firmware::Parts::Home},
    Entry{'G', 30, &Firmware::Parts::ProbeBed},
    Entry{'G', 92, &Firmware::Parts::SetPosition},
    Entry{'M', 18, &Firmware::Parts::MotorsOff},
    Entry{'M', 84, &Firmware::Parts::MotorsOff},
    Entry{'M', 92, &Firmware::Parts::StepsPerMm},
    Entry{'M', 98, &Firmware::Parts::RunMacro},
    Entry{'M', 105, &Firmware::Parts::ReportTemperatures, true},
    Entry{'M', 112, &Firmware::Parts::EmergencyStop, true},
    Entry{'M', 114, &Firmware::Parts::ReportPosition, true},
    Entry{'M', 115, &Firmware::Parts::ReportFirmware, true},
    Entry{'M', 119, &Firmware::Parts::ReportEndstops, true},
    Entry{'M', 400, &Firmware::Parts::WaitForMoves},
    Entry{'M', 409, &Firmware::Parts::ReportObjectModel, true},
    Entry{'M', 425, &Firmware::Parts::BacklashSettings},
    Entry{'M', 500, &Firmware::Parts::SaveSettings},
    Entry{'M', 501, &Firmware::Parts::RestoreSettings},
    Entry{'M', 584, &Firmware::Parts::SetDrivers},
    Entry{'M', 671, &Firmware::Parts::SetLeadscrews},
    Entry{'M', 999, &Firmware::Parts::Restart, true}};

/// Commands that change nothing in this machine: units are mm, there is no spindle.
constexpr std::array<std::pair<char, int>, 18> kAccepted = {{{'G', 17},
                                                             {'G', 21},
                                                             {'G', 40},
                                                             {'G', 49},
                                                             {'G', 80},
                                                             {'G', 94},
                                                             {'M', 3},
                                                             {'M', 5},
                                                             {'M', 9},
                                                             {'M', 17},
                                                             {'M', 82},
                                                             {'M', 83},
                                                             {'M', 99},
                                                             {'M', 110},
                                                             {'M', 111},
                                                             {'M', 117},
                                                             {'M', 453},
                                                             {'M', 555}}};

/// The real controller has them, this machine has not. What follows would go
/// elsewhere, so a warning is not enough: arcs, inches, rotation.
constexpr std::array kMissing = {2, 3, 20, 68};

/// The keyword of a meta command and what stands behind it.
std::pair<std::string, std::string_view> SplitKeyword(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size() && text[end] >= 'a' && text[end] <= 'z') ++end;
  std::string_view rest = text.substr(end);
  while (!rest.empty() && (rest.front() == ' ' || rest.front() == '\t')) {
    rest.remove_prefix(1);
  }
  return {std::string(text.substr(0, end)), rest};
}

Reply EmergencyReply(const std::optional<std::string>& news) {
  Reply reply{.error = true};
  if (news) reply.lines.push_back("Error: " + *news);
  reply.lines.emplace_back(kEmergencyWords);
  return reply;
}

}  // namespace

Reply Firmware::Parts::Execute(std::string_view line) {
  Reply reply;
  lines_left = kMostLines;
  try {
    const GcodeLine parsed = ParseGcode(line);
    if (parsed.is_meta || !parsed.commands.empty()) {
      wire.CloseBlocks(parsed.indent, parsed.is_meta && parsed.text.starts_with("el"));
      reply = ExecuteLine(parsed, &wire);
    }
  } catch (const InputError& error) {
    reply = Refuse(error.faults().front());
  }
  AdoptGlobals();
  if (motion.alarm() && !has_told_alarm) {
    has_told_alarm = true;
    halted = true;
    return EmergencyReply(motion.alarm());
  }
  return reply;
}

Reply Firmware::Parts::ExecuteLine(const GcodeLine& line, Frame* frame) {
  if (line.is_meta) return ExecuteMeta(line, frame);
  if (!frame->is_active()) return {};
  Reply reply;
  for (const GcodeCommand& command : line.commands) {
    Append(ExecuteCommand(command, frame), &reply);
    if (reply.error) break;
  }
  uses_machine_coordinates = false;
  return reply;
}

Reply Firmware::Parts::ExecuteCommand(const GcodeCommand& command, Frame* frame) {
  const Words words(command, LookupIn(frame));
  const auto* const entry = std::ranges::find_if(
      kCommands, [&](const Entry& e) { return command.Is(e.letter, e.code); });
  const bool has_entry = entry != kCommands.end();
  if (command.Is('M', 118)) return Say(command, words);
  if (is_halted() && !(has_entry && entry->when_halted)) {
    return EmergencyReply(std::nullopt);
  }
  if (has_entry) return (this->*entry->run)(words);
  const bool is_modal_move = command.letter == 0;
  if (is_modal_move || command.Is('G', 0) || command.Is('G', 1)) {
    return MoveLinear(command, words);
  }
  if (command.letter == 'G' && command.code == 38) return Probe(command, words);
  if (command.letter == 'G' && command.code >= 54 && command.code <= 59) {
    return SelectWorkplace(command);
  }
  if (command.letter == 'T') return SelectTool(command);
  if (command.Is('G', 53)) uses_machine_coordinates = true;
  if (command.Is('G', 90)) is_relative = false;
  if (command.Is('G', 91)) is_relative = true;
  if (command.Is('G', 53) || command.Is('G', 90) || command.Is('G', 91)) return {};
  const bool is_accepted = std::ranges::any_of(kAccepted, [&](const auto& known) {
    return command.Is(known.first, known.second);
  });
  if (is_accepted) return {};
  // NeXT's own commands are files in the system folder: G6512 is sys/G6512.g.
  const std::string macro = StoragePath(command.Name() + ".g");
  if (options.files.contains(macro)) {
    std::map<std::string, Value> params;
    for (const auto& [letter, value] : words.values()) {
      params[std::string(1, letter)] = value;
    }
    return RunFile(macro, params);
  }
  const bool is_missing =
      command.letter == 'G' &&
      std::ranges::any_of(kMissing, [&](int code) { return command.code == code; });
  if (is_missing) {
    return Refuse(command.Name() + ": not part of this machine");
  }
  return {
      .lines = {fmt::format("Warning: {}: Command is not supported", command.Name())}};
}

Reply Firmware::Parts::ExecuteMeta(const GcodeLine& line, Frame* frame) {
  const auto [keyword, rest] = SplitKeyword(line.text);
  const rrf::Lookup lookup = LookupIn(frame);
  try {
    if (keyword == "if") {
      frame->OpenIf(line.indent,
                    frame->is_active() && rrf::Evaluate(rest, lookup).Flag());
      return {};
    }
    if (keyword == "elif" || keyword == "else") {
      const bool wants_it = frame->WantsElse(line.indent) &&
                            (keyword == "else" || rrf::Evaluate(rest, lookup).Flag());
      if (frame->SwitchIf(line.indent, wants_it)) return {};
      throw InputError({}, fmt::format("'{}' did not follow 'if'", keyword));
    }
    if (!frame->is_active()) return {};
    if (keyword == "echo") return Echo(rest, frame);
    if (keyword == "var" || keyword == "global") {
      return Declare(rest, keyword == "global", frame);
    }
    if (keyword == "set") return Set(rest, frame);
    if (keyword == "skip") return {};
    if (keyword == "abort") {
      return Refuse(rest.empty() ? "abort" : ToText(rrf::Evaluate(rest, lookup)));
    }
    throw InputError({}, fmt::format("'{}' is only for macro files", keyword));
  } catch (const InputError& error) {
    throw InputError({}, "meta command: " + error.faults().front());
  }
}

rrf::Lookup Firmware::Parts::LookupIn(Frame* frame) {
  return [this, frame](const rrf::Path& path) {
    return LookUp(path, frame);
  };
}

Reply Firmware::Parts::Echo(std::string_view rest, Frame* frame) {
  std::size_t arrows = 0;
  while (arrows < rest.size() && rest[arrows] == '>') ++arrows;
  std::string file;
  if (arrows > 0) {
    rest.remove_prefix(arrows);
    const std::size_t open = rest.find('"');
    const std::size_t close = rest.find('"', open + 1);
    if (open == std::string_view::npos || close == std::string_view::npos) {
      throw InputError({}, "expected a file name in quotes behind '>'");
    }
    file = std::string(rest.substr(open + 1, close - open - 1));
    rest.remove_prefix(close + 1);
  }
  std::string text;
  for (const Value& value : rrf::EvaluateList(rest, LookupIn(frame))) {
    if (!text.empty()) text += ' ';
    text += ToText(value);
  }
  if (file.empty()) return {.lines = {text}};
  if (arrows < 3) text += '\n';
  Store(file, text, /*appends=*/arrows > 1);
  return {};
}

Reply Firmware::Parts::Declare(std::string_view rest, bool is_global, Frame* frame) {
  const rrf::Lookup lookup = LookupIn(frame);
  std::string_view behind;
  const rrf::Path path = rrf::ParsePath(rest, lookup, &behind);
  const std::size_t sign = behind.find_first_not_of(" \t");
  if (path.size() != 1 || sign == std::string_view::npos || behind[sign] != '=') {
    throw InputError({}, "expected a name and '='");
  }
  const std::string name = rrf::ToText(path);
  Value value = rrf::Evaluate(behind.substr(sign + 1), lookup);
  const bool is_new = is_global ? globals.emplace(name, std::move(value)).second
                                : frame->AddVariable(name, std::move(value));
  if (!is_new) throw InputError({}, fmt::format("variable '{}' already exists", name));
  return {};
}

Reply Firmware::Parts::Set(std::string_view rest, Frame* frame) {
  const rrf::Lookup lookup = LookupIn(frame);
  std::string_view behind;
  const rrf::Path path = rrf::ParsePath(rest, lookup, &behind);
  const std::size_t sign = behind.find_first_not_of(" \t");
  const bool is_named =
      path.size() >= 2 && std::holds_alternative<std::string>(path[1]);
  if (!is_named || sign == std::string_view::npos || behind[sign] != '=') {
    throw InputError({}, "expected global.NAME or var.NAME and '='");
  }
  const auto& scope = std::get<std::string>(path[0]);
  const auto& name = std::get<std::string>(path[1]);
  Value* variable = nullptr;
  if (scope == "var") variable = frame->FindVariable(name);
  if (scope == "global" && globals.contains(name)) variable = &globals.at(name);
  if (variable == nullptr) {
    throw InputError({}, fmt::format("unknown variable '{}'", name));
  }
  Value value = rrf::Evaluate(behind.substr(sign + 1), lookup);
  for (std::size_t i = 2; i < path.size(); ++i) {
    auto* const array = std::get_if<Value::Array>(&variable->of);
    const auto* const index = std::get_if<std::int64_t>(&path[i]);
    if (array == nullptr || index == nullptr || *index < 0 ||
        *index >= static_cast<std::int64_t>(array->size())) {
      throw InputError({}, "array index out of bounds");
    }
    variable = &(*array)[static_cast<std::size_t>(*index)];
  }
  *variable = std::move(value);
  return {};
}

void Firmware::Parts::AdoptGlobals() {
  // Asked after every line: the names are made once.
  static const std::string kDeflection = "nxtProbeDeflection";
  static const std::string kTipRadius = "nxtProbeTipRadius";
  if (const auto found = globals.find(kDeflection); found != globals.end()) {
    const Value& value = found->second;
    const Value::Array* const array = value.array();
    for (std::size_t i = 0; i < 3; ++i) {
      const Value* one = array == nullptr ? &value : nullptr;
      if (array != nullptr && array->size() == 3) one = &(*array)[i];
      if (one != nullptr && one->is_number()) {
        settings.probe_deflection_mm[i] = one->Number();
      }
    }
  }
  if (const auto found = globals.find(kTipRadius);
      found != globals.end() && found->second.is_number()) {
    settings.tip_radius_mm = found->second.Number();
  }
}

}  // namespace caltwin
