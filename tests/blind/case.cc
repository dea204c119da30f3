#include "tests/blind/case.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/blind/separation.h"
#include "tests/blind/visible.h"

namespace blind {
namespace {

Hidden DrawHidden(const std::vector<Cause>& causes, double sigma, Random* random) {
  const Cause& cause = random->Pick(causes);
  return {cause.name, random->Pick(cause.axes), sigma};
}

/// Two causes that one campaign of at most `max_rows` can show together.
std::vector<Hidden> DrawPair(const CaseRequest& request, Random* random) {
  while (true) {
    CaseRequest tried = request;
    tried.hidden = {DrawHidden(LibraryCauses(), random->Uniform(2, 15), random),
                    DrawHidden(LibraryCauses(), random->Uniform(2, 15), random)};
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

/// Draws what the request leaves open.
CaseRequest Filled(CaseRequest request) {
  Random random(request.seed, "causes");
  if (request.kind == "single" && request.hidden.empty()) {
    request.hidden = {DrawHidden(LibraryCauses(), request.sigma, &random)};
  } else if (request.kind == "outside" && request.hidden.empty()) {
    request.hidden = {DrawHidden(OutsideCauses(), request.sigma, &random)};
  } else if (request.kind == "pair" && request.hidden.empty()) {
    request.hidden = DrawPair(request, &random);
  }
  for (Hidden& hidden : request.hidden) {
    const Cause* cause = FindCause(hidden.cause);
    if (cause == nullptr) {
      throw std::invalid_argument("there is no cause '" + hidden.cause + "'");
    }
    if (hidden.axis == "any") hidden.axis = random.Pick(cause->axes);
    if (std::ranges::find(cause->axes, hidden.axis) == cause->axes.end()) {
      throw std::invalid_argument(hidden.cause + " has no axis '" + hidden.axis + "'");
    }
  }
  return request;
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

Projector BaselineOf(const Case& made, const std::vector<Reading>& readings) {
  std::vector<Column> columns = BaselineColumns(made.plan, readings);
  for (Column& column : columns) {
    for (std::size_t i = 0; i < column.size(); ++i) {
      column[i] /= Sigma_mm(made, readings[i]);
    }
  }
  return Projector(columns);
}

/// Makes the defect show as large as wanted; what no baseline can hide of it counts.
HiddenTruth Sized(const Case& made,
                  const Hidden& hidden,
                  Defect defect,
                  const std::vector<Reading>& without,
                  const Projector& baseline) {
  const Cause& cause = *FindCause(hidden.cause);
  HiddenTruth truth;
  defect.size = cause.fixed_size > 0 ? cause.fixed_size : cause.typical;
  for (int i = 0; i < 4; ++i) {
    const Visible visible =
        VisibleEffect(WhitenedEffect(made, defect, without), baseline);
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

}  // namespace

void MakeCase(const CaseRequest& request, Case* made) {
  made->request = Filled(request);
  made->drawing = DrawMachine(made->request);
  made->plan = MakePlan(made->request, made->drawing);
  made->times_s = TimesOf_s(made->plan);
  made->instruments = DrawInstruments(made->request, made->drawing);
  made->blemishes = DrawBlemishes(made->request);
  made->truth = DrawTruth(made->request, made->drawing, made->plan);
  const Weather weather(WeatherFor(*made), Random(request.seed, "weather"));
  LogTemperatures(weather, made);

  const auto without =
      Machine(made->drawing, made->truth).Perform(made->plan, made->times_s);
  const Projector baseline = BaselineOf(*made, without);
  std::vector<Defect> defects;
  for (const Hidden& hidden : made->request.hidden) {
    Random random(request.seed, "shape of " + hidden.cause + hidden.axis);
    const Circumstances at{made->drawing, weather, made->plan, made->times_s, &random};
    made->hidden.push_back(Sized(*made,
                                 hidden,
                                 FindCause(hidden.cause)->make(hidden.axis, at),
                                 without,
                                 baseline));
    HiddenTruth& truth = made->hidden.back();
    defects.push_back(truth.defect);
    truth.separation = Separation(*made,
                                  at,
                                  hidden,
                                  WhitenedEffect(*made, truth.defect, without),
                                  without,
                                  baseline);
  }
  Random random(request.seed, "wander");
  const Circumstances at{made->drawing, weather, made->plan, made->times_s, &random};
  if (made->blemishes.wander_um_per_sqrt_h > 0) {
    defects.push_back(Wander(at, made->blemishes.wander_um_per_sqrt_h));
  }
  if (made->blemishes.clutter_sigma > 0) {
    const double sigma_mm = Sigma_mm(*made, without.front());
    defects.push_back(Clutter(at, made->blemishes.clutter_sigma * sigma_mm));
  }
  made->truth.defects = std::move(defects);
  made->readings =
      Machine(made->drawing, made->truth).Perform(made->plan, made->times_s);
  AddNoise(made);
}

}  // namespace blind
