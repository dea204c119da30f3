#include "tools/commands/api/bench_settings.h"

#include <cstdlib>
#include <string>
#include <utility>

#include "calibration/loop/controller.h"
#include "sim/machine/machine_kind.h"
#include "tools/server/json_keys.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostAxes_bytes = 64'000;

}  // namespace

bool HasAxisSettings(const Bench& bench) {
  return bench.record != nullptr && bench.machine.kind->axes_are_drives();
}

Expected<void> WriteSettings(Link* link,
                             const Machine& machine,
                             const Settings& wanted) {
  Controller controller(link, machine);
  if (const auto read = controller.ReadSettings(); !read) return read;
  const Settings now = controller.settings();
  for (const Axis axis : kAxes) {
    const std::size_t i = Index(axis);
    Expected<void> done;
    if (now.steps_per_mm[i] != wanted.steps_per_mm[i]) {
      done = controller.WriteStepsPerMm(axis, wanted.steps_per_mm[i]);
    }
    if (done && now.backlash_mm[i] != wanted.backlash_mm[i]) {
      done = controller.WriteBacklash(axis, wanted.backlash_mm[i]);
    }
    if (done && now.probe_deflection_mm[i] != wanted.probe_deflection_mm[i]) {
      done = controller.WriteDeflection(axis, wanted.probe_deflection_mm[i]);
    }
    if (!done) return done;
  }
  return {};
}

ProcedureResult ResultOf(const Expected<void>& done) {
  ProcedureResult result;
  if (done) return result;
  result.ending = EndingOfFault(done.error());
  result.fault = done.error().reply;
  result.messages.push_back(MachineSaid(done.error().reply));
  return result;
}

Settings SettingsAsked(const HttpRequest& request, const Settings& now) {
  Settings wanted = now;
  const Json body = JsonBody(request);
  JsonKeys keys(body);
  constexpr double kMost_mm = 5;
  for (const auto& [key, member] :
       {std::pair{"steps_per_mm", &Settings::steps_per_mm},
        std::pair{"backlash_mm", &Settings::backlash_mm},
        std::pair{"probe_deflection_mm", &Settings::probe_deflection_mm}}) {
    const Json by_axis = keys.Object(key, kMostAxes_bytes);
    JsonKeys axes(by_axis, std::string("/") + key);
    for (const Axis axis : kAxes) {
      double& value = (wanted.*member)[Index(axis)];
      const bool is_steps = member == &Settings::steps_per_mm;
      const NumberRange range = is_steps ? NumberRange{value / 2, value * 2, "steps/mm"}
                                         : NumberRange{0, kMost_mm, "mm"};
      value = axes.Number(Name(axis), range, value);
    }
    axes.Done();
  }
  keys.Done();
  return wanted;
}

void SettingsWatch::Begin(bool measures) {
  measures_ = measures;
  is_off_ = {};
}

bool SettingsWatch::Sees(std::string_view line) {
  constexpr std::string_view kGap = "M425 ";
  if (!line.starts_with(kGap)) {
    return line.starts_with("M92 ") ||
           line.starts_with("set global.nxtProbeDeflection") ||
           line.starts_with("global nxtProbeDeflection");
  }
  for (const Axis axis : kAxes) {
    const std::size_t at = line.find(CapitalLetter(axis), kGap.size());
    if (at == std::string_view::npos) continue;
    const double gap_mm =
        std::strtod(std::string(line.substr(at + 1)).c_str(), nullptr);
    is_off_[Index(axis)] = measures_ && gap_mm == 0;
  }
  return true;
}

Settings SettingsWatch::Lasting(Settings now, const Settings& kept) const {
  for (const Axis axis : kAxes) {
    const std::size_t i = Index(axis);
    if (is_off_[i]) now.backlash_mm[i] = kept.backlash_mm[i];
  }
  return now;
}

}  // namespace caltwin
