#include "tests/blind/case.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "tests/blind/separation.h"
#include "tests/blind/visible.h"

namespace blind {
namespace {

Hidden DrawHidden(const std::vector<Cause>& causes, double sigma, Random* random) {
  const Cause& cause = random->Pick(causes);
  return {cause.name, random->Pick(cause.axes), sigma};
}

const std::vector<Cause>& CausesFor(const CaseRequest& request) {
  return request.physics ? PhysicsCauses() : LibraryCauses();
}

/// Two causes that one campaign of at most `max_rows` can show together.
std::vector<Hidden> DrawPair(const CaseRequest& request, Random* random) {
  const auto& causes = CausesFor(request);
  while (true) {
    CaseRequest tried = request;
    tried.hidden = {DrawHidden(causes, random->Uniform(2, 15), random),
                    DrawHidden(causes, random->Uniform(2, 15), random)};
    const auto& [first, second] = std::tie(tried.hidden[0], tried.hidden[1]);
    const bool both_waves =
        (first.cause == "cyclic_lead" && second.cause == "pulley_eccentric") ||
        (first.cause == "pulley_eccentric" && second.cause == "cyclic_lead");
    if (first.cause == second.cause || both_waves || first.cause == "tip_size" ||
        second.cause == "tip_size") {
      continue;
    }
    const Plan plan = MakePlan(tried, DrawMachine(tried));
    if (static_cast<int>(plan.stops.size()) <= request.max_rows + 20)
      return tried.hidden;
  }
}

/// What the defect alone adds to each row, in sigma.
Column WhitenedEffect(const Case& made,
                      const Defect& defect,
                      const std::vector<Reading>& without) {
  Truth truth = made.truth;
  truth.defects = {defect};
  const auto with = Machine(made.drawing, truth).Perform(made.plan, made.times_s);
  Column effect;
  for (std::size_t i = 0; i < with.size(); ++i) {
    effect.push_back((with[i].value_mm - without[i].value_mm) /
                     Sigma_mm(made, with[i]));
  }
  return effect;
}

/// Makes the defect show as large as wanted; what no baseline can hide of it counts.
/// None if this plan's baseline hides a defect of this form.
std::optional<HiddenTruth> Sized(const Case& made,
                                 const Hidden& hidden,
                                 Defect defect,
                                 const std::vector<Reading>& without,
                                 const Projector& baseline) {
  const Cause& cause = *FindCause(hidden.cause);
  HiddenTruth truth;
  defect.size = cause.fixed_size > 0 ? cause.fixed_size : cause.typical;
  for (int i = 0; i < 4; ++i) {
    const Column effect = WhitenedEffect(made, defect, without);
    const Visible visible = VisibleEffect(effect, baseline);
    if (cause.fixed_size <= 0 && visible.peak < kLeastVisible * visible.whole_peak) {
      return std::nullopt;
    }
    truth.peak_sigma = visible.peak;
    truth.sum_squares = visible.sum_squares;
    if (cause.fixed_size > 0 || visible.peak <= 0 || i == 3) break;
    defect.size *= hidden.sigma / visible.peak;
  }
  truth.defect = std::move(defect);
  return truth;
}

WeatherPlan WeatherFor(const Case& made) {
  WeatherPlan weather;
  weather.duration_s = made.times_s.empty() ? 3600 : made.times_s.back() + 60;
  weather.from_cold = made.plan.from_cold;
  double drift_s = weather.duration_s;
  for (std::size_t i = 0; i < made.plan.stops.size(); ++i) {
    if (made.plan.stops[i].campaign == "drift") drift_s = made.times_s[i];
  }
  weather.heating_until_s = made.plan.from_cold ? 0.6 * drift_s : weather.duration_s;
  return weather;
}

void LogTemperatures(const Weather& weather, Case* made) {
  Random random(made->request.seed, "thermometers");
  for (const double t_s : made->times_s) {
    std::array<double, kThermometers> row{};
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = weather.At(static_cast<Thermometer>(i), t_s) + 0.03 * random.Normal();
    }
    made->temps_c.push_back(row);
  }
}

/// A form of the hidden cause that this plan can show: drawn again where it cannot.
std::optional<HiddenTruth> Hide(const Case& made,
                                const Hidden& hidden,
                                const Weather& weather,
                                const std::vector<Reading>& without,
                                const Projector& baseline) {
  constexpr int kForms = 4;
  for (int form = 0; form < kForms; ++form) {
    std::string stream = "shape of " + hidden.cause + hidden.axis;
    if (form > 0) stream += fmt::format(" {}", form);
    Random random(made.request.seed, stream);
    const Circumstances at{made.drawing, weather, made.plan, made.times_s, &random};
    Defect defect = FindCause(hidden.cause)->make(hidden.axis, at);
    auto truth = Sized(made, hidden, std::move(defect), without, baseline);
    if (!truth) continue;
    const Column effect = WhitenedEffect(made, truth->defect, without);
    truth->separation = Separation(made, at, hidden, effect, without, baseline);
    return truth;
  }
  return std::nullopt;
}

/// All that is hidden; false if this plan hides some of it too well.
bool HideAll(const Weather& weather, Case* made) {
  const auto without =
      Machine(made->drawing, made->truth).Perform(made->plan, made->times_s);
  const Projector baseline = BaselineOf(*made, without);
  made->hidden.clear();
  for (const Hidden& hidden : made->request.hidden) {
    auto truth = Hide(*made, hidden, weather, without, baseline);
    if (!truth) return false;
    made->hidden.push_back(std::move(*truth));
  }
  return true;
}

}  // namespace

CaseRequest Filled(CaseRequest request) {
  Random random(request.seed, "causes");
  if (request.kind == "single" && request.hidden.empty()) {
    request.hidden = {DrawHidden(CausesFor(request), request.sigma, &random)};
  } else if (request.kind == "outside" && request.hidden.empty()) {
    request.hidden = {DrawHidden(OutsideCauses(), request.sigma, &random)};
  } else if (request.kind == "pair" && request.hidden.empty()) {
    request.hidden = DrawPair(request, &random);
  }
  for (Hidden& hidden : request.hidden) {
    const Cause* cause = FindCause(hidden.cause, request.physics);
    if (cause == nullptr) {
      throw std::invalid_argument("there is no such cause: " + hidden.cause);
    }
    if (hidden.axis == "any") hidden.axis = random.Pick(cause->axes);
    if (std::ranges::find(cause->axes, hidden.axis) == cause->axes.end()) {
      throw std::invalid_argument(hidden.cause + " has no axis '" + hidden.axis + "'");
    }
  }
  return request;
}

Projector BaselineOf(const Case& made, const std::vector<Reading>& readings) {
  std::vector<Column> columns = BaselineColumns(made.plan, readings);
  for (Column& column : columns) {
    for (std::size_t i = 0; i < column.size(); ++i) {
      column[i] /= Sigma_mm(made, readings[i]);
    }
  }
  return Projector(columns);
}

void AddDistractions(const Weather& weather, Case* made) {
  Random random(made->request.seed, "wander");
  const Circumstances at{made->drawing, weather, made->plan, made->times_s, &random};
  if (made->blemishes.wander_um_per_sqrt_h > 0) {
    made->truth.defects.push_back(Wander(at, made->blemishes.wander_um_per_sqrt_h));
  }
  if (made->blemishes.clutter_sigma <= 0) return;
  const double sigma_mm = Sigma_mm(*made, {.stop = &made->plan.stops.front()});
  made->truth.defects.push_back(Clutter(at, made->blemishes.clutter_sigma * sigma_mm));
}

void MakeCase(const CaseRequest& request, Case* made) {
  constexpr int kPlans = 6;
  made->request = Filled(request);
  made->drawing = DrawMachine(made->request);
  made->instruments = DrawInstruments(made->request, made->drawing);
  made->blemishes = DrawBlemishes(made->request);
  std::optional<Weather> weather;
  for (int attempt = 0; attempt < kPlans; ++attempt) {
    made->plan = MakePlan(made->request, made->drawing, attempt);
    made->times_s = TimesOf_s(made->plan);
    made->truth = DrawTruth(made->request, made->drawing, made->plan);
    weather.emplace(WeatherFor(*made), Random(request.seed, "weather"));
    if (HideAll(*weather, made)) break;
    if (attempt + 1 == kPlans) throw std::runtime_error("no plan shows what is hidden");
  }
  LogTemperatures(*weather, made);
  for (const HiddenTruth& truth : made->hidden)
    made->truth.defects.push_back(truth.defect);
  AddDistractions(*weather, made);
  made->readings =
      Machine(made->drawing, made->truth).Perform(made->plan, made->times_s);
  AddNoise(made);
}

}  // namespace blind
