#include "tests/blind/physics_case.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "tests/blind/model_text.h"
#include "tests/blind/physics_rows.h"
#include "tests/blind/program.h"
#include "tests/blind/separation.h"
#include "tests/blind/text_file.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

// So fine that counting in steps rounds nothing: the truth code counts them itself.
constexpr double kFineMicrosteps = 4096;
constexpr const char* kLimit_s = "120";

std::string ReadText(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The model with the faults that every machine has.
ModelText OrdinaryModel(const Simulator& simulator, const Case& made) {
  ModelText model(ReadText(simulator.model));
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    model.SetScale(axis, made.truth.scale[i]);
    model.SetGap(axis, made.truth.gap_mm[i]);
  }
  model.TiltTable(made.truth.bed_slope_x, made.truth.bed_slope_y);
  model.SetTableSize(made.drawing.axis(0).max_mm, made.drawing.axis(1).max_mm);
  return model;
}

/// The machine as it truly is, as files.
void WriteBuilt(const Simulator& simulator,
                const Case& made,
                const ModelText& model,
                double microsteps) {
  const fs::path folder(simulator.folder);
  WriteText(folder / "built.xml", model.Text());
  WriteText(folder / "built.yaml",
            MachineYaml(made.drawing,
                        {.model = "built.xml",
                         .pretravel_mm = made.truth.pretravel_mm[0],
                         .tip_growth_mm = model.tip_growth_mm(),
                         .microsteps = microsteps}));
}

/// The rows that `caltwin simulate` writes of this model; throws what it said if none.
RunFiles Perform(const Simulator& simulator, const Case& made, const ModelText& model) {
  const fs::path folder(simulator.folder);
  WriteBuilt(simulator, made, model, kFineMicrosteps);
  const std::string log = (folder / "simulate.log").string();
  const int code = RunProgram({"timeout",
                               kLimit_s,
                               simulator.binary,
                               "simulate",
                               (folder / "PLAN.yaml").string(),
                               "--machine",
                               (folder / "built.yaml").string(),
                               "--out",
                               (folder / "RUN.csv").string()},
                              log);
  if (code != 0) throw std::runtime_error("caltwin simulate: " + ReadText(log));
  RunFiles files{ReadText(folder / "RUN.csv"), ReadText(folder / "RUN.yaml")};
  for (const char* name :
       {"built.xml", "built.yaml", "RUN.csv", "RUN.yaml", "simulate.log"}) {
    fs::remove(folder / name);
  }
  return files;
}

WeatherPlan QuietWeather(const Case& made) {
  WeatherPlan weather;
  weather.duration_s = made.times_s.back() + 60;
  weather.heating_until_s = weather.duration_s;
  return weather;
}

/// A form of the cause, made as large as wanted by its closed form; none if this plan
/// shows nothing of it.
std::optional<HiddenTruth> Shaped(const Case& made,
                                  const Hidden& hidden,
                                  const Weather& weather,
                                  const std::vector<Reading>& without,
                                  const Projector& baseline) {
  constexpr int kForms = 4;
  const Cause& cause = *FindCause(hidden.cause, /*physics=*/true);
  for (int form = 0; form < kForms; ++form) {
    Random random(made.request.seed,
                  fmt::format("physics of {} {} {}", hidden.cause, hidden.axis, form));
    const Circumstances at{made.drawing, weather, made.plan, made.times_s, &random};
    HiddenTruth truth{.defect = cause.make(hidden.axis, at)};
    Column effect = LinearEffect(made, truth.defect, without);
    const Visible visible = VisibleEffect(effect, baseline);
    const bool is_sized = cause.fixed_size <= 0;
    if (is_sized && visible.peak <= kLeastVisible * visible.whole_peak) continue;
    truth.defect.size = is_sized ? hidden.sigma / visible.peak : cause.fixed_size;
    for (double& value : effect) value *= truth.defect.size;
    truth.peak_sigma = visible.peak * truth.defect.size;
    truth.sum_squares = visible.sum_squares * truth.defect.size * truth.defect.size;
    truth.separation = Separation(made, at, hidden, effect, without, baseline);
    return truth;
  }
  return std::nullopt;
}

bool ShapeAll(const Weather& weather, Case* made) {
  const Projector baseline = BaselineOf(*made, made->readings);
  made->hidden.clear();
  for (const Hidden& hidden : made->request.hidden) {
    auto truth = Shaped(*made, hidden, weather, made->readings, baseline);
    if (!truth) return false;
    made->hidden.push_back(std::move(*truth));
  }
  return true;
}

/// What one hidden cause truly adds is told by MuJoCo, not by the closed form.
void MeasureHidden(const PhysicsReadings& readings, Case* made) {
  if (made->hidden.size() != 1) return;
  Column effect;
  for (std::size_t i = 0; i < readings.with_mm.size(); ++i) {
    effect.push_back((readings.with_mm[i] - readings.without_mm[i]) /
                     Sigma_mm(*made, made->readings[i]));
  }
  const Visible visible = VisibleEffect(effect, BaselineOf(*made, made->readings));
  made->hidden[0].peak_sigma = visible.peak;
  made->hidden[0].sum_squares = visible.sum_squares;
}

/// A plan that shows what is hidden, performed by the ordinary machine, and each hidden
/// cause's form and size.
Weather Prepare(const Simulator& simulator, Case* made) {
  constexpr int kPlans = 6;
  const CaseRequest& request = made->request;
  for (int attempt = 0; attempt < kPlans; ++attempt) {
    Random random(request.seed, fmt::format("physics plan {}", attempt));
    made->plan = {};
    auto campaigns = ChooseCampaigns(request, made->drawing, &random);
    std::erase_if(campaigns,
                  [](const CampaignRequest& c) { return c.kind == "drift"; });
    WriteText(fs::path(simulator.folder) / "PLAN.yaml",
              PlanYaml(campaigns, made->drawing, &random, &made->plan));
    // How artefacts stand is drawn last: the machine itself needs no plan.
    made->truth = DrawTruth(request, made->drawing, made->plan);
    made->truth.pretravel_mm.fill(made->truth.pretravel_mm[0]);
    ReadRun(Perform(simulator, *made, OrdinaryModel(simulator, *made)), made);
    Weather weather(QuietWeather(*made), Random(request.seed, "weather"));
    if (ShapeAll(weather, made)) return weather;
  }
  throw std::runtime_error("no plan shows what is hidden");
}

/// How artefacts and gauges stand, wander and clutter, added to what MuJoCo gave.
void AddWhatNoModelHas(const Weather& weather, Case* made) {
  const auto standing = DrawTruth(made->request, made->drawing, made->plan).standing;
  made->truth.standing = standing;
  AddDistractions(weather, made);
  for (const Defect& defect : made->truth.defects) {
    const Column effect = LinearEffect(*made, defect, made->readings);
    const double size = defect.size;
    for (std::size_t i = 0; i < effect.size(); ++i) {
      made->readings[i].value_mm +=
          size * effect[i] * Sigma_mm(*made, made->readings[i]);
    }
  }
  for (Reading& reading : made->readings) {
    const Stop& stop = *reading.stop;
    const Standing& stands = standing.at(stop.setup);
    const Vector3 arm = stop.at_mm - made->plan.placements.at(stop.setup).center_mm;
    const Vector3 moved = stands.offset_mm + stands.turn_rad * Cross(Along(2), arm);
    // A ball-bar reads its length from where its pivot truly stands.
    reading.value_mm += (stop.kind == Kind::kRadial ? -1 : 1) * Dot(moved, stop.n);
  }
}

/// The ordinary model with what is hidden.
ModelText EditedModel(const Simulator& simulator, const Case& made) {
  ModelText model = OrdinaryModel(simulator, made);
  for (const HiddenTruth& hidden : made.hidden) {
    hidden.defect.build(hidden.defect.size, &model);
  }
  return model;
}

}  // namespace

Weather PreparePhysicsCase(const Simulator& simulator,
                           const CaseRequest& request,
                           Case* made) {
  fs::create_directories(simulator.folder);
  fs::copy_file(simulator.model,
                fs::path(simulator.folder) / "model.xml",
                fs::copy_options::overwrite_existing);
  made->request = Filled(request);
  made->drawing = DrawMachine(made->request);
  made->instruments = DrawInstruments(made->request, made->drawing);
  made->blemishes = DrawBlemishes(made->request);
  return Prepare(simulator, made);
}

PhysicsReadings HideInModel(const Simulator& simulator, const Case& made) {
  PhysicsReadings readings;
  for (const Reading& reading : made.readings) {
    readings.without_mm.push_back(reading.value_mm);
  }
  readings.with_mm = readings.without_mm;
  if (made.hidden.empty()) return readings;
  const ModelText model = EditedModel(simulator, made);
  readings.with_mm = ValuesOf(Perform(simulator, made, model));
  if (readings.with_mm.size() != readings.without_mm.size()) {
    throw std::runtime_error("the same plan gave another number of rows");
  }
  return readings;
}

void MakePhysicsCase(const Simulator& simulator,
                     const CaseRequest& request,
                     Case* made) {
  const Weather weather = PreparePhysicsCase(simulator, request, made);
  const PhysicsReadings readings = HideInModel(simulator, *made);
  MeasureHidden(readings, made);
  if (simulator.keep_built) {
    WriteBuilt(simulator, *made, EditedModel(simulator, *made), /*microsteps=*/0);
  }
  for (std::size_t i = 0; i < readings.with_mm.size(); ++i) {
    SetValue(readings.with_mm[i], made->drawing, &made->readings[i]);
  }
  AddWhatNoModelHas(weather, made);
  AddNoise(made);
}

}  // namespace blind
