#include "tools/commands/api/bench_json.h"

#include <array>
#include <utility>

#include "sim/machine/surface.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kPerAxis = {
    std::pair{"steps_per_mm", &Settings::steps_per_mm},
    std::pair{"backlash_mm", &Settings::backlash_mm},
    std::pair{"probe_deflection_mm", &Settings::probe_deflection_mm}};

// The box around it as it stands unturned: x and y about its middle, z from its base.
Vec3<double> SizeOf_mm(Artefact artefact) {
  artefact.at_mm = Vec3<double>::Zero();
  artefact.turn_deg = 0;
  Vec3<double> size_mm = Vec3<double>::Zero();
  for (const Solid& solid : SolidsOf(artefact)) {
    Vec3<double> half_mm = solid.half_mm;
    if (solid.bore_radius_mm > 0) half_mm.y() = half_mm.x();
    Vec3<double> reach_mm = solid.center_mm.cwiseAbs() + half_mm;
    reach_mm.head<2>() *= 2;
    size_mm = size_mm.cwiseMax(reach_mm);
  }
  return size_mm;
}

Json TripleOf(const Vec3<double>& values) {
  return Json::array({values[0], values[1], values[2]});
}

}  // namespace

std::string ToString(Ending ending) {
  switch (ending) {
    case Ending::kDone:
      return "done";
    case Ending::kUnconverged:
      return "unconverged";
    case Ending::kNoTrigger:
      return "no_trigger";
    case Ending::kCollision:
      return "collision";
    case Ending::kAlarm:
      return "alarm";
    case Ending::kReadsZero:
      return "reads_zero";
    case Ending::kConfounded:
      return "confounded";
    case Ending::kRefused:
      return "refused";
    case Ending::kLinkLost:
      break;
  }
  return "link_lost";
}

Json ToJson(const ProcedureResult& result) {
  Json tree{{"ending", ToString(result.ending)},
            {"estimates", Json::array()},
            {"steps", Json::array()},
            {"messages", result.messages},
            {"touches", result.touches}};
  if (!result.fault.empty()) tree["machine_said"] = result.fault;
  for (const Estimate& estimate : result.estimates) {
    Json one{{"name", estimate.name},
             {"unit", estimate.unit},
             {"is_known", estimate.identifiable},
             {"value", nullptr},
             {"sd", nullptr}};
    if (estimate.identifiable)
      one.update({{"value", estimate.value}, {"sd", estimate.sd}});
    tree["estimates"].push_back(one);
  }
  for (const Step& step : result.steps) {
    tree["steps"].push_back({{"name", step.name},
                             {"unit", step.unit},
                             {"iteration", step.iteration},
                             {"before", step.has_before ? Json(step.before) : Json()},
                             {"after", step.after},
                             {"verdict", ToString(step.verdict)},
                             {"message", step.message}});
  }
  for (const Observability& blind : result.observability) {
    tree["cannot_tell"].push_back(blind.statement);
  }
  return tree;
}

Json ToJson(const Row& row) {
  const auto number = [](double value) {
    return Known(value) ? Json(value) : Json();
  };
  Json tree{{"campaign", row.campaign}, {"feature", row.feature}, {"setup", row.setup}};
  for (std::size_t i = 0; i < row.n.size(); ++i) {
    const std::string axis(1, "xyz"[i]);
    tree["n"][axis] = number(row.n[i]);
    tree["dir"][axis] = number(row.dir[i]);
    tree["at_mm"][axis] = number(row.cmd_mm[i]);
  }
  tree["value_mm"] = row.value_mm;
  return tree;
}

Json ToJson(const Artefact& artefact, bool is_twin) {
  return {{"id", artefact.id},
          {"type", ToString(artefact.type)},
          {"at_mm", is_twin ? TripleOf(artefact.at_mm) : Json()},
          {"size_mm", is_twin ? TripleOf(SizeOf_mm(artefact)) : Json()},
          {"turn_deg", is_twin ? Json(artefact.turn_deg) : Json()}};
}

Json ToJson(const Settings& settings) {
  Json tree;
  for (const auto& [key, member] : kPerAxis) {
    for (const Axis axis : kAxes)
      tree[key][Name(axis)] = (settings.*member)[Index(axis)];
  }
  tree["tip_radius_mm"] = settings.tip_radius_mm;
  return tree;
}

Settings SettingsOf(const Json& tree) {
  Settings settings;
  for (const auto& [key, member] : kPerAxis) {
    for (const Axis axis : kAxes) {
      (settings.*member)[Index(axis)] = tree.at(key).at(Name(axis)).get<double>();
    }
  }
  settings.tip_radius_mm = tree.at("tip_radius_mm").get<double>();
  return settings;
}

}  // namespace caltwin
