#include "scenarios/kinds/delta_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "calibration/kinds/delta/settings.h"
#include "scenarios/study/summary.h"
#include "sim/base/input_error.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostTouches = 10'000;  // Of one machine.
constexpr double kLongest_mm = 1e5;

DeltaModel<double> Drawn() {
  return SymmetricDelta(300, 130, 250);
}

Json GeometryJson(const DeltaModel<double>& model) {
  std::array<double, 3> angle_deg{};
  std::ranges::transform(model.angle_rad, angle_deg.begin(), [](double rad) {
    return std::round(DegFromRad(rad) * 1e9) / 1e9;
  });
  return {{"endstop_mm", model.endstop_mm},
          {"radius_mm", model.radius_mm},
          {"angle_deg", angle_deg},
          {"arm_mm", model.arm_mm}};
}

double NumberAt(const nlohmann::json& value, const std::string& name) {
  const double number = value.is_number() ? value.get<double>()
                                          : std::numeric_limits<double>::quiet_NaN();
  if (std::abs(number) <= kLongest_mm) return number;
  throw InputError({}, fmt::format("{} is a number within {:.0f}", name, kLongest_mm));
}

/// One number for all three towers, or three.
std::array<double, 3> ThreeAt(const nlohmann::json& value, const std::string& name) {
  std::array<double, 3> three{};
  if (!value.is_array()) {
    three.fill(NumberAt(value, name));
    return three;
  }
  if (value.size() != three.size())
    throw InputError({}, name + " is a number or a list of three");
  for (std::size_t i = 0; i < three.size(); ++i) three[i] = NumberAt(value[i], name);
  return three;
}

/// What is left away stays as `before` has it.
DeltaModel<double> GeometryOf(const nlohmann::json& asked,
                              const DeltaModel<double>& before) {
  const auto geometry = asked.find("geometry");
  if (geometry == asked.end() || !geometry->is_object()) {
    throw InputError(
        {},
        "a geometry is missing",
        R"("geometry": {"endstop_mm": [300, 300, 300], "radius_mm": 130})");
  }
  DeltaModel<double> model = before;
  for (const auto& [key, value] : geometry->items()) {
    if (key == "endstop_mm") {
      model.endstop_mm = ThreeAt(value, key);
    } else if (key == "radius_mm") {
      model.radius_mm = ThreeAt(value, key);
    } else if (key == "arm_mm") {
      model.arm_mm = ThreeAt(value, key);
    } else if (key == "angle_deg") {
      std::ranges::transform(ThreeAt(value, key),
                             model.angle_rad.begin(),
                             [](double deg) { return RadFromDeg(deg); });
    } else {
      throw InputError({},
                       fmt::format("'{}' is nothing of a geometry", key),
                       "endstop_mm, radius_mm, angle_deg, arm_mm");
    }
  }
  return model;
}

}  // namespace

DeltaOracle::DeltaOracle(int machines, std::uint64_t seed)
    : machines_(machines), seed_(seed) {
  Begin();
}

void DeltaOracle::Begin() {
  const int index = static_cast<int>(scores_.size());
  machine_ = RandomDelta(seed_, index);
  const std::uint64_t touch_seed =
      Rng(seed_, static_cast<std::uint64_t>(index), "compare.delta.touch").Next();
  touched_.emplace(machine_.build, machine_.bed, kCompareTouchSigma_mm, touch_seed);
  settings_ = Drawn();
  touches_ = 0;
}

std::string DeltaOracle::Answer(std::string_view line) {
  try {
    const nlohmann::json asked = nlohmann::json::parse(line);
    if (!asked.is_object()) throw InputError({}, "a line is one JSON object");
    return Obey(asked).dump() + "\n";
  } catch (const nlohmann::json::exception&) {
    ++errors_;
    return Json{{"error", "a line is one JSON object: {\"ask\": \"machine\"}"}}.dump() +
           "\n";
  } catch (const InputError& error) {
    ++errors_;
    return Json{{"error", error.faults().front()}}.dump(
               -1, ' ', true, Json::error_handler_t::replace) +
           "\n";
  }
}

Json DeltaOracle::Obey(const nlohmann::json& asked) {
  const auto word = asked.find("ask");
  const std::string ask =
      word != asked.end() && word->is_string() ? word->get<std::string>() : "";
  const bool is_over = static_cast<int>(scores_.size()) >= machines_;
  if (ask == "machine") return is_over ? Json{{"over", true}} : Describe();
  if (is_over) throw InputError({}, "there is no machine left");
  if (ask == "probe") return Probe(asked);
  if (ask == "set") {
    settings_ = GeometryOf(asked, settings_);
    return {{"geometry", GeometryJson(settings_)}};
  }
  if (ask == "done") return Done(asked);
  throw InputError(
      {}, "`ask` is none that this answers", "machine, probe, set or done");
}

Json DeltaOracle::Describe() const {
  return {{"machine", scores_.size() + 1},
          {"of", machines_},
          {"kind", "delta"},
          {"geometry", GeometryJson(settings_)},
          {"radius_mm", kCompareRadius_mm},
          {"touch_sd_mm", kCompareTouchSigma_mm}};
}

Json DeltaOracle::Probe(const nlohmann::json& asked) {
  if (!asked.contains("x") || !asked.contains("y"))
    throw InputError(
        {}, "a probe needs x and y", R"({"ask": "probe", "x": 0, "y": 50})");
  const double x_mm = NumberAt(asked["x"], "x"), y_mm = NumberAt(asked["y"], "y");
  if (touches_ >= kMostTouches)
    throw InputError({}, fmt::format("{} touches are enough", kMostTouches));
  constexpr double kSlack_mm = 1e-6;
  if (std::hypot(x_mm, y_mm) > kCompareRadius_mm + kSlack_mm) {
    throw InputError(
        {},
        fmt::format("the probe reaches {:g} mm from the middle", kCompareRadius_mm));
  }
  const auto motors_mm = touched_->Touch(settings_, x_mm, y_mm);
  if (!motors_mm) throw InputError({}, "out of reach with this geometry");
  ++touches_;
  return {{"z", DeltaNozzle_mm(settings_, *motors_mm)[2]}};
}

Json DeltaOracle::Done(const nlohmann::json& asked) {
  const DeltaModel<double> geometry = GeometryOf(asked, settings_);
  const auto rms_um = [&](const DeltaModel<double>& model) {
    const double z_mm =
        DeltaAccuracyOf(machine_.build, machine_.bed, model, kCompareRadius_mm)
            .z_rms_mm;
    return std::isfinite(z_mm) ? UmFromMm(z_mm)
                               : std::numeric_limits<double>::infinity();
  };
  OracleScore score{.machine = static_cast<int>(scores_.size()) + 1,
                    .touches = touches_,
                    .before_um = rms_um(Drawn()),
                    .after_um = rms_um(geometry)};
  constexpr double kSame = 1 - 1e-6;
  score.is_worse = !(score.after_um < kSame * score.before_um);
  const double scale =
      DeltaAccuracyOf(machine_.build, machine_.bed, geometry, kCompareRadius_mm)
          .xy_scale;
  score.scale_um_per_mm = UmFromMm(scale);
  scores_.push_back(score);
  if (static_cast<int>(scores_.size()) < machines_) Begin();
  return {{"score",
           {{"machine", score.machine},
            {"touches", score.touches},
            {"z_rms_before_um", score.before_um},
            {"z_rms_um", score.after_um},
            {"scale_um_per_mm", score.scale_um_per_mm},
            {"is_worse", score.is_worse}}}};
}

namespace {

/// Nonsense counts as infinitely far, which JSON writes as null.
Spread HeightsOf(const DeltaOracle& oracle, double OracleScore::*figure) {
  std::vector<double> um;
  for (const OracleScore& score : oracle.scores()) {
    um.push_back(score.*figure);
  }
  return SpreadOf(um);
}

int WorseOf(const DeltaOracle& oracle) {
  return static_cast<int>(
      std::ranges::count_if(oracle.scores(), &OracleScore::is_worse));
}

double TouchesOf(const DeltaOracle& oracle) {
  double touches = 0;
  for (const OracleScore& score : oracle.scores()) touches += score.touches;
  return touches / std::max(1.0, static_cast<double>(oracle.scores().size()));
}

}  // namespace

std::string OracleText(const DeltaOracle& oracle, std::uint64_t seed) {
  const Spread before = HeightsOf(oracle, &OracleScore::before_um);
  const Spread after = HeightsOf(oracle, &OracleScore::after_um);
  return fmt::format(
      "{} of {} machines calibrated, seed {}: nozzle over bed {:.1f} um rms (median; "
      "95 % "
      "of machines below {:.1f}), {:.0f} before; {:.1f} touches a machine\n{}{}",
      oracle.scores().size(),
      oracle.machines(),
      seed,
      after.median,
      after.p95,
      before.median,
      TouchesOf(oracle),
      WorseOf(oracle) > 0
          ? fmt::format("left worse than as drawn: {}\n", WorseOf(oracle))
          : "",
      fmt::format(
          "held against others: caltwin compare delta --machines {} --seed {}\n",
          oracle.machines(),
          seed));
}

Json OracleJson(const DeltaOracle& oracle, std::uint64_t seed) {
  Json machines = Json::array();
  for (const OracleScore& score : oracle.scores()) {
    machines.push_back({{"touches", score.touches},
                        {"z_rms_before_um", score.before_um},
                        {"z_rms_um", score.after_um},
                        {"scale_um_per_mm", score.scale_um_per_mm},
                        {"is_worse", score.is_worse}});
  }
  const Spread after = HeightsOf(oracle, &OracleScore::after_um);
  return {{"format", 1},
          {"kind", "delta"},
          {"seed", seed},
          {"of", oracle.machines()},
          {"scored", oracle.scores().size()},
          {"left_worse", WorseOf(oracle)},
          {"touches", TouchesOf(oracle)},
          {"z_rms_um",
           {{"median", after.median},
            {"p95", after.p95},
            {"ci95", {after.low, after.high}}}},
          {"machines", machines}};
}

}  // namespace caltwin
