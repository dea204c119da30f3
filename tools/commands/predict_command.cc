#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/diagnosis/predict.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/effects/catalog.h"
#include "tools/commands/believed_machine.h"
#include "tools/commands/command.h"
#include "tools/commands/measured_data.h"
#include "tools/commands/spare_files.h"

namespace caltwin {
namespace {

struct PredictAsked {
  std::string model{};
  std::string file{};
  std::string json{};
  std::uint64_t seed = 1;
};

std::string TextOf(const Prediction& prediction, const PredictAsked& options) {
  const double before_um = UmFromMm(prediction.before_mm);
  const double after_um = UmFromMm(prediction.after_mm);
  std::string text = fmt::format(
      "{}: the model of {}, frozen, takes {} rows of {} from {} to {} um rms; nothing "
      "was "
      "refitted but where things lie",
      prediction.transfers ? "Transfers" : "Does not transfer",
      options.model,
      prediction.rows,
      options.file,
      TwoDigits(before_um),
      TwoDigits(after_um));
  if (Known(prediction.floor_mm)) {
    text += fmt::format(" (readings repeat to {} um)",
                        TwoDigits(UmFromMm(prediction.floor_mm)));
  }
  if (prediction.left_out > 0) {
    text += fmt::format("; {} row{} bad by {} left out",
                        prediction.left_out,
                        prediction.left_out == 1 ? " that is" : "s that are",
                        prediction.left_out == 1 ? "itself" : "themselves");
  }
  text += ".\n";
  if (!prediction.transfers) {
    text +=
        "Suspect the gauge or the setup of one of the two runs, or what has changed "
        "between "
        "them: what is the machine's comes back.\n";
  }
  return text;
}

int RunPredict(const PredictAsked& options) {
  Data data = ReadData(options.file);
  if (data.table.rows.empty()) {
    throw InputError({.file = options.file}, "no rows to predict");
  }
  const Believed model = BelievedMachine(options.file, options.model, &data, "MODEL");
  if (model.effects.empty()) {
    throw InputError(
        {.file = options.model},
        "a machine as drawn: it predicts nothing beyond the drawing",
        "caltwin diagnose RUN1.csv --machine M.yaml --extend M.ext.yaml writes a "
        "model of a run");
  }
  RefuseOverwriting(Together({RowsAndHeader("the data", options.file),
                              {{"the model", options.model}}}),
                    {{"--json", options.json}});
  JudgeData(options.file, &model.machine, &data);
  const Observed without(data.table, data.header, model.machine, {});
  const Observed with(data.table,
                      data.header,
                      model.machine,
                      DrawEffects(model.effects, options.seed, 0));
  const Prediction prediction = Predict(without, with, model.baseline);
  if (options.json != "-") std::cout << TextOf(prediction, options);
  if (options.json.empty()) return kPassed;
  const nlohmann::ordered_json tree = {
      {"format", 1},
      {"rmse_before_um", UmFromMm(prediction.before_mm)},
      {"rmse_after_um", UmFromMm(prediction.after_mm)},
      {"repeats_um",
       Known(prediction.floor_mm)
           ? nlohmann::ordered_json(UmFromMm(prediction.floor_mm))
           : nlohmann::ordered_json(nullptr)},
      {"rows", prediction.rows},
      {"left_out", prediction.left_out},
      {"transfers", prediction.transfers},
      {"command", fmt::format("caltwin predict {} {}", options.model, options.file)},
      {"version", CALTWIN_VERSION}};
  const std::string json = tree.dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << json;
  } else {
    WriteTextFile(options.json, json);
  }
  return kPassed;
}

}  // namespace

Action DeclarePredict(CLI::App* app) {
  const auto options = std::make_shared<PredictAsked>();
  app->add_option(
         "MODEL", options->model, "an extension that diagnose wrote, M.ext.yaml")
      ->required();
  app->add_option("DATA", options->file, "rows of another run of the same machine")
      ->required();
  app->add_option(
      "--json", options->json, "write the figures as JSON; - for stdout alone");
  app->add_option("--seed", options->seed, "of effects that are drawn");
  return [options] {
    return RunPredict(*options);
  };
}

}  // namespace caltwin
