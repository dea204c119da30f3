#include "scenarios/gcode_step.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "calibration/loop/controller.h"
#include "calibration/loop/outcome.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

constexpr std::chrono::minutes kPatience{10};

ProcedureResult SendLines(const std::vector<std::string>& lines, Bench* bench) {
  ProcedureResult result;
  for (const std::string& line : lines) {
    const auto reply = bench->link->Send(line, kPatience);
    if (!reply) {
      result.ending = EndingOfFault(reply.error());
      result.fault = reply.error().reply;
      result.messages.push_back(
          fmt::format("{}: {}", Printable(line), reply.error().reply));
      return result;
    }
    for (const std::string& answer : *reply) {
      result.messages.push_back(fmt::format("{}: {}", Printable(line), answer));
    }
  }
  return result;
}

}  // namespace

PreparedProcedure GcodeStep(std::vector<std::string> lines) {
  return [lines = std::move(lines)](Bench* bench) {
    return SendLines(lines, bench);
  };
}

PreparedProcedure ReadGcodeStep(YamlMap options) {
  std::vector<std::string> lines;
  if (const auto list = options.Required("lines")) {
    for (const YamlValue& line : list->List()) lines.push_back(line.Text());
  }
  options.NoMoreKeys();
  return GcodeStep(std::move(lines));
}

}  // namespace caltwin
