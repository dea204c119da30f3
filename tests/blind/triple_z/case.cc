#include "tests/blind/triple_z/case.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "tests/blind/text_file.h"
#include "tests/blind/visible.h"

namespace blind {
namespace {

constexpr double kMost = 8;  // Times what is typical.

TzPaper DrawPaper(Random* random) {
  TzPaper paper;
  paper.wide_mm = random->Uniform(200, 320);
  paper.deep_mm = random->Uniform(200, 320);
  paper.high_mm = random->Uniform(160, 280);
  paper.lead_mm = random->Chance(0.5) ? 4 : 8;
  const double near_mm = random->Uniform(5, 30);
  paper.screw_x_mm = {near_mm, paper.wide_mm - near_mm, near_mm};
  paper.screw_y_mm = {near_mm, near_mm, paper.deep_mm - near_mm};
  // The third may stand in the middle of the back, as on many machines.
  if (random->Chance(0.4)) paper.screw_x_mm[2] = paper.wide_mm / 2;
  return paper;
}

// Campaigns that show the cause, and others by chance.
std::vector<TzStop> DrawStops(const TzPaper& paper, Random* random) {
  std::vector<TzStop> stops;
  AddTzGrid(paper, random, &stops);
  if (random->Chance(0.75)) AddTzHeights(paper, random, &stops);
  if (random->Chance(0.6)) AddFixedPost(paper, random, &stops);
  if (random->Chance(0.75)) AddOneByOne(paper, random, &stops);
  random->Shuffle(&stops);
  std::ranges::stable_sort(stops, {}, &TzStop::campaign);
  double t_s = 0;
  for (TzStop& stop : stops) {
    t_s += random->Uniform(6, 14);
    stop.t_s = t_s;
    stop.frame_k = 6 * (1 - std::exp(-t_s / 900)) + 0.02 * random->Normal();
    stop.bed_k = 9 * (1 - std::exp(-t_s / 400)) + 0.02 * random->Normal();
  }
  return stops;
}

// What every machine has, and every diagnosis fits first.
TzTruth DrawBaseline(const TzPaper& paper, std::uint64_t seed) {
  Random random(seed, "triple z baseline");
  TzTruth truth;
  truth.wave_length_mm.fill(paper.lead_mm);
  truth.dent_x_mm = paper.wide_mm / 2;
  truth.dent_y_mm = paper.deep_mm / 2;
  truth.scale = 3e-4 * random.Normal();
  truth.all_gap_mm = 0.01 * std::abs(random.Normal());
  truth.plane = [seed](const std::string& home) {
    Random own(seed, "plane of " + home);
    return std::array{own.Normal() / 5, 2e-3 * own.Normal(), 2e-3 * own.Normal()};
  };
  truth.zero_mm = [seed](const std::string& setup) {
    return Random(seed, "zero of " + setup).Normal() / 5;
  };
  return truth;
}

Column Readings(const TzCase& made, const TzTruth& truth) {
  Column values;
  for (const TzStop& stop : made.stops) {
    values.push_back(ReadTz(made.paper, truth, stop));
  }
  return values;
}

// What a change of the truth adds to each row, by differences.
Column Slope(const TzCase& made,
             const TzTruth& truth,
             const std::function<void(TzTruth*)>& change) {
  TzTruth changed = truth;
  change(&changed);
  const Column with = Readings(made, changed), without = Readings(made, truth);
  Column slope;
  for (std::size_t i = 0; i < with.size(); ++i) {
    slope.push_back((with[i] - without[i]) / made.sigma_mm);
  }
  return slope;
}

std::vector<Column> BaselineColumns(const TzCase& made, const TzTruth& truth) {
  std::vector<Column> columns;
  columns.push_back(Slope(made, truth, [](TzTruth* t) { t->scale += 1e-5; }));
  columns.push_back(Slope(made, truth, [](TzTruth* t) { t->all_gap_mm += 0.01; }));
  std::set<std::string> setups;
  for (const TzStop& stop : made.stops) setups.insert(stop.setup);
  for (int k = 0; k < 2; ++k) {
    Column column;
    for (const TzStop& stop : made.stops) {
      const double sign = stop.is_touch ? 1 : -1;
      column.push_back(sign * (k == 0 ? stop.x_mm : stop.y_mm) / 100);
    }
    columns.push_back(column);
  }
  for (const std::string& setup : setups) {
    Column column;
    for (const TzStop& stop : made.stops) {
      column.push_back(stop.setup == setup ? 1.0 : 0.0);
    }
    columns.push_back(column);
  }
  return columns;
}

std::vector<Column> CauseColumns(const TzCase& made,
                                 const TzTruth& truth,
                                 const TzCause& cause,
                                 const std::string& axis,
                                 double second) {
  std::vector<Column> columns;
  const double size = cause.typical;
  const auto add = [&](double one, double two) {
    columns.push_back(
        Slope(made, truth, [&](TzTruth* t) { cause.put(axis, one, two, t); }));
  };
  if (!cause.second.empty()) {
    add(size, 0);
    add(0, size);
  } else if (cause.name == "screw_cyclic") {
    // Any phase.
    add(size, 0.05);
    add(size, 0.35);
  } else {
    add(size, second);
  }
  return columns;
}

double SumSquares(const Column& column) {
  double sum = 0;
  for (const double value : column) sum += value * value;
  return sum;
}

// How much of the effect is left when another cause imitates it.
nlohmann::json TwinsOf(const TzCase& made,
                       const TzTruth& truth,
                       const std::string& own,
                       const Column& effect,
                       const std::vector<Column>& baseline) {
  constexpr double kNear = 25;
  nlohmann::json twins = nlohmann::json::object();
  for (const TzCause& cause : TzCauses()) {
    if (cause.is_outside) continue;
    for (const std::string& axis : cause.axes) {
      const std::string name = cause.name + " " + axis;
      if (name == own) continue;
      std::vector<Column> columns = baseline;
      for (Column& column : CauseColumns(made, truth, cause, axis, 0.3)) {
        columns.push_back(std::move(column));
      }
      const double left = SumSquares(Projector(columns).Rest(effect));
      if (left < kNear) twins[name] = left;
    }
  }
  return twins;
}

struct HiddenCause {
  TzCause cause{};
  std::string axis{};
  Column effect{};
  nlohmann::json told{};
};

// `number`: which of those that are hidden, from 1.
HiddenCause Hide(
    const TzCause& cause, int number, double sigma, TzCase* made, TzTruth* truth) {
  Random random(made->request.seed,
                number == 1 ? "triple z hidden" : "triple z hidden too");
  const std::string asked = number == 1 ? made->request.axis : "";
  const std::string axis =
      asked.empty() || asked == "any" ? random.Pick(cause.axes) : asked;
  const double sign = cause.is_positive ? 1 : random.Sign();
  const double ratio = random.Normal();
  const bool has_two = !cause.second.empty();
  double size = sign * cause.typical;
  const auto put = [&](TzTruth* into) {
    cause.put(axis, size, has_two ? ratio * size : ratio, into);
  };
  const std::vector<Column> baseline = BaselineColumns(*made, *truth);
  Visible visible;
  Column effect;
  for (int round = 0; round < 4; ++round) {
    effect = Slope(*made, *truth, put);
    visible = VisibleEffect(effect, Projector(baseline));
    if (cause.is_whole || visible.peak < 1e-3 * visible.whole_peak) break;
    // No machine is this bad, whatever its plan shows of it.
    const double most = kMost * cause.typical;
    if (round < 3) size *= sigma / visible.peak;
    size = std::clamp(size, -most, most);
  }
  const nlohmann::json twins =
      TwinsOf(*made, *truth, cause.name + " " + axis, effect, baseline);
  put(truth);
  nlohmann::json parameters = nlohmann::json::array();
  if (!cause.parameter.empty()) {
    parameters.push_back({{"name", cause.parameter}, {"value", size}});
  }
  if (has_two) parameters.push_back({{"name", cause.second}, {"value", ratio * size}});
  return {.cause = cause,
          .axis = axis,
          .effect = effect,
          .told = {{"cause", cause.name},
                   {"axis", axis},
                   {"parameters", parameters},
                   {"peak_sigma", visible.peak},
                   {"sum_squares", visible.sum_squares},
                   {"separation", twins},
                   {"acceptable", nlohmann::json::array()},
                   {"covariates", cause.covariates}}};
}

// Nobody knows how large the other one of two is: what imitates a cause together with
// the other's free size is its twin too. A bowl and a sag along x are a cylinder along
// y and more sag.
void TwinsBeside(const TzCase& made,
                 const TzTruth& truth,
                 const HiddenCause& other,
                 HiddenCause* own) {
  std::vector<Column> known = BaselineColumns(made, truth);
  for (Column& column : CauseColumns(made, truth, other.cause, other.axis, 0.3)) {
    known.push_back(std::move(column));
  }
  own->told["separation"] =
      TwinsOf(made, truth, own->cause.name + " " + own->axis, own->effect, known);
}

// One cause, or two of different names, each of a size of its own.
nlohmann::json HideAll(Random* random, TzCase* made, TzTruth* truth) {
  const PrinterRequest& request = made->request;
  if (request.kind == "null") return nlohmann::json::array();
  std::vector<TzCause> fit;
  for (const TzCause& cause : TzCauses()) {
    const bool is_named = request.cause.empty() || cause.name == request.cause;
    if (is_named && cause.is_outside == (request.kind == "outside")) {
      fit.push_back(cause);
    }
  }
  if (fit.empty()) throw std::invalid_argument("no such cause: " + request.cause);
  const TzCause first = random->Pick(fit);
  HiddenCause one = Hide(first, 1, request.sigma, made, truth);
  if (request.kind != "pair") return nlohmann::json::array({one.told});
  std::vector<TzCause> others;
  for (const TzCause& cause : TzCauses()) {
    if (cause.name != first.name && !cause.is_outside) others.push_back(cause);
  }
  const TzCause second = random->Pick(others);
  HiddenCause two = Hide(second, 2, random->LogUniform(2, 15), made, truth);
  TwinsBeside(*made, *truth, two, &one);
  TwinsBeside(*made, *truth, one, &two);
  return nlohmann::json::array({one.told, two.told});
}

// The nozzle's height walks at random in time: touches and gauges see it.
void AddWander(TzCase* made) {
  if (made->request.wander_um_per_sqrt_h <= 0) return;
  constexpr double kSecondsPerHour = 3600;
  Random random(made->request.seed, "triple z wander");
  double at_mm = 0, before_s = 0;
  for (std::size_t i = 0; i < made->stops.size(); ++i) {
    const TzStop& stop = made->stops[i];
    at_mm += 1e-3 * made->request.wander_um_per_sqrt_h * random.Normal() *
             std::sqrt((stop.t_s - before_s) / kSecondsPerHour);
    before_s = stop.t_s;
    made->values_mm[i] += (stop.is_touch ? -1 : 1) * at_mm;
  }
}

std::string DataCsv(const TzCase& made) {
  std::string text =
      "row,campaign,kind,setup,home,t_s,temp_frame_c,temp_bed_c,cmd_x_mm,cmd_y_mm,"
      "cmd_z_mm,motor_a_mm,motor_b_mm,motor_c_mm,dir_x,dir_y,dir_z,dir_a,dir_b,dir_c,"
      "feed_mm_s,nx,ny,nz,probe_off_y_mm,feature,value_mm,sigma_mm\n";
  for (std::size_t i = 0; i < made.stops.size(); ++i) {
    const TzStop& stop = made.stops[i];
    const ByScrew told_mm = ToldFor(made.paper, stop);
    const int sense = stop.bed_sense;
    text += fmt::format(
        "{},{},{},{},{},{:.1f},{:.2f},{:.2f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},"
        "0,0,{},{},{},{},{:.2f},0,0,1,{:.3f},{},{:.6f},{:.6f}\n",
        i + 1,
        stop.campaign,
        stop.is_touch ? "touch" : "position",
        stop.setup,
        stop.home,
        stop.t_s,
        22 + stop.frame_k,
        22 + stop.bed_k,
        stop.x_mm,
        stop.y_mm,
        stop.z_mm,
        told_mm[0],
        told_mm[1],
        told_mm[2],
        -sense,
        sense,
        sense,
        sense,
        stop.feed_mm_s,
        stop.off_y_mm,
        stop.feature,
        made.values_mm[i],
        made.stated * made.sigma_mm);
  }
  return text;
}

std::string MachineYaml(const TzPaper& paper) {
  std::string text = "format: 1\nname: blind_triple_z\nkinematics: triple_z\nscrews:\n";
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("  z{}: {{at_mm: [{}, {}], lead_mm: {}}}\n",
                        i + 1,
                        paper.screw_x_mm[i],
                        paper.screw_y_mm[i],
                        paper.lead_mm);
  }
  return text + fmt::format(
                    "axes:\n  x: {{max_mm: {}}}\n  y: {{max_mm: {}}}\n  z: "
                    "{{max_mm: {}, lead_mm: {}}}\n",
                    paper.wide_mm,
                    paper.deep_mm,
                    paper.high_mm,
                    paper.lead_mm);
}

}  // namespace

TzCase MakeTzCase(const PrinterRequest& request) {
  TzCase made{.request = request};
  Random random(request.seed, "triple z");
  made.paper = DrawPaper(&random);
  made.stops = DrawStops(made.paper, &random);
  made.sigma_mm = random.LogUniform(0.002, 0.01);
  made.stated = random.Chance(0.3) ? random.LogUniform(0.5, 2) : 1;
  TzTruth truth = DrawBaseline(made.paper, request.seed);
  const nlohmann::json causes = HideAll(&random, &made, &truth);
  made.values_mm = Readings(made, truth);
  AddWander(&made);
  Random noise(request.seed, "triple z noise");
  const double outliers = noise.Chance(0.3) ? 0.01 : 0;
  for (double& value : made.values_mm) {
    value += made.sigma_mm * noise.Normal();
    if (noise.Chance(outliers)) value += made.sigma_mm * noise.Sign() * 30;
  }
  made.truth = {{"kind", request.kind},
                {"seed", request.seed},
                {"rows", made.stops.size()},
                {"causes", causes},
                {"baseline", {{"scale", truth.scale}, {"gap_mm", truth.all_gap_mm}}}};
  return made;
}

void WriteTzCase(const TzCase& made, const std::string& folder) {
  const std::filesystem::path path(folder);
  std::filesystem::create_directories(path);
  WriteText(path / "DATA.csv", DataCsv(made));
  WriteText(path / "machine.yaml", MachineYaml(made.paper));
  WriteText(path / "TRUTH.json", made.truth.dump(1) + "\n");
}

}  // namespace blind
