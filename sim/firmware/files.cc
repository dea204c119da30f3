#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/firmware/parts.h"
#include "sim/firmware/storage_path.h"

namespace caltwin {
namespace {

constexpr int kDeepestMacro = 10;
constexpr std::size_t kMostStored = 10'000'000;
constexpr std::string_view kStartFile = "sys/nxt-user-vars.g";
constexpr std::string_view kOverrideFile = "sys/config-override.g";

std::vector<std::string> SplitLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// "Error: ..." told with the line of the macro it happened in, unless that has been.
void AddPlace(std::size_t index, Reply* reply) {
  constexpr std::string_view kError = "Error: ";
  for (std::string& line : reply->lines) {
    if (line.starts_with(kError) && !line.starts_with("Error: in file")) {
      line = fmt::format(
          "Error: in file macro line {}: {}", index + 1, line.substr(kError.size()));
    }
  }
}

}  // namespace

std::string StoragePath(const std::string& path) {
  std::string_view plain = path;
  if (plain.starts_with("0:")) plain.remove_prefix(2);
  while (plain.starts_with('/')) plain.remove_prefix(1);
  const bool has_folder = plain.find('/') != std::string_view::npos;
  return (has_folder ? "" : "sys/") + std::string(plain);
}

void Firmware::Parts::Store(const std::string& path,
                            const std::string& text,
                            bool appends) {
  std::string& file = options.files[StoragePath(path)];
  if (!appends) file.clear();
  if (file.size() + text.size() > kMostStored) {
    throw InputError({}, fmt::format("no room for file '{}'", path));
  }
  file += text;
}

Reply Firmware::Parts::RunFile(const std::string& path,
                               const std::map<std::string, Value>& params) {
  const auto file = options.files.find(StoragePath(path));
  if (file == options.files.end()) {
    return Refuse(fmt::format("M98: File \"{}\" not found", path));
  }
  if (macro_depth >= kDeepestMacro) return Refuse("Stack overflow: too many macros");
  const std::vector<std::string> lines = SplitLines(file->second);
  Frame frame;
  frame.is_file = true;
  frame.params = params;
  Reply reply;
  ++macro_depth;
  for (std::size_t index = 0; index <= lines.size() && !reply.error;) {
    const std::size_t now = index;
    // Behind the last line stands a blank one without indentation: it ends all blocks.
    Append(RunMacroLine(index < lines.size() ? lines[index] : "M99", &index, &frame),
           &reply);
    AddPlace(now, &reply);
  }
  --macro_depth;
  return reply;
}

Reply Firmware::Parts::RunMacroLine(std::string_view text,
                                    std::size_t* index,
                                    Frame* frame) {
  const std::size_t now = (*index)++;
  try {
    if (--lines_left < 0) throw InputError({}, "the macro does not end");
    const GcodeLine line = ParseGcode(text);
    if (!line.is_meta && line.commands.empty()) return {};
    const bool repeats = frame->RepeatsWhile(now);
    if (!repeats) {
      const bool continues_if = line.is_meta && line.text.starts_with("el");
      if (const auto back = frame->CloseBlocks(line.indent, continues_if)) {
        *index = *back;
        return {};
      }
    }
    if (line.is_meta && line.text.starts_with("while")) {
      if (!repeats) frame->OpenWhile(line.indent, now);
      const bool goes_on = !frame->is_active() ||
                           rrf::Evaluate(line.text.substr(5), LookupIn(frame)).Flag();
      if (!goes_on) frame->Break();
      return {};
    }
    const bool is_active = frame->is_active();
    if (line.text == "break" || line.text == "continue") {
      if (!is_active) return {};
      const bool is_in_loop = frame->Iterations().has_value();
      if (!is_in_loop) throw InputError({}, line.text + " was not in a loop");
      if (line.text == "break") {
        frame->Break();
      } else {
        *index = *frame->Continue();
      }
      return {};
    }
    if (is_active && line.text == "M99") {
      *index = std::string::npos;
      return {};
    }
    return ExecuteLine(line, frame);
  } catch (const InputError& error) {
    return Refuse(error.faults().front());
  }
}

Reply Firmware::Parts::RunMacro(const Words& words) {
  const auto path = words.Text('P');
  if (!path) return Refuse("M98: missing parameter 'P'");
  std::map<std::string, Value> params;
  for (const auto& [letter, value] : words.values()) {
    if (letter != 'P') params[std::string(1, letter)] = value;
  }
  return RunFile(*path, params);
}

Reply Firmware::Parts::SaveSettings(const Words&) {
  std::string text = "; config-override.g file generated in response to M500\n";
  for (int i = 0; i < kWorkplaces; ++i) {
    const Vec3<double>& offset_mm_of = workplaces_mm[i];
    text += fmt::format("G10 L2 P{} X{:.3f} Y{:.3f} Z{:.3f}\n",
                        i + 1,
                        offset_mm_of[0],
                        offset_mm_of[1],
                        offset_mm_of[2]);
  }
  Store(std::string(kOverrideFile), text, /*appends=*/false);
  return {.lines = {"Warning: M500: No M501 command was executed in config.g"}};
}

Reply Firmware::Parts::RestoreSettings(const Words&) {
  if (!options.files.contains(std::string(kOverrideFile))) {
    return Refuse("M501: file config-override.g not found");
  }
  return RunFile(std::string(kOverrideFile), {});
}

Reply Firmware::Parts::Restart(const Words&) {
  return Start();
}

Reply Firmware::Parts::Start() {
  motion.Restart();
  bed.is_split = false;
  bed.points.clear();
  bed.leadscrews = options.leadscrews;
  settings = initial_settings;
  globals.clear();
  wire = Frame();
  workplaces_mm.fill(Vec3<double>::Zero());
  workplace = 0;
  is_relative = false;
  is_rapid = true;
  feed_mm_s = kDefaultFeed_mm_s;
  tool = -1;
  halted = false;
  has_told_alarm = false;
  Reply reply;
  if (options.files.contains(std::string(kStartFile))) {
    reply = RunFile(std::string(kStartFile), {});
  }
  // What the file did not set is as the machine's configuration has it.
  Value::Array deflection;
  for (const double mm : initial_settings.probe_deflection_mm) {
    deflection.push_back(Value{mm});
  }
  globals.try_emplace("nxtProbeDeflection", Value{std::move(deflection)});
  globals.try_emplace("nxtProbeTipRadius", Value{initial_settings.tip_radius_mm});
  AdoptGlobals();
  return reply;
}

}  // namespace caltwin
