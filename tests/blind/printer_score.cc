#include "tests/blind/printer_score.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tests/blind/diagnosis.h"
#include "tests/blind/figures.h"

namespace blind {
namespace {

struct Options {
  std::string binary = "caltwin", folder{}, markdown{}, out{};
  PrinterRequest one{};
  int nulls = 20, drifts = 0, singles = 44, pairs = 0, outside = 12, jobs = 2;
  std::uint64_t seed = 1;
  bool keep = false, failures_only = false;
};

std::vector<PrinterRequest> RequestsOf(const PrinterKind& printer,
                                       const Options& options) {
  std::vector<PrinterRequest> requests;
  const auto add = [&](const std::string& kind, int count, bool wanders = false) {
    const std::vector<std::string> causes = printer.causes(kind == "outside");
    for (int i = 0; i < count; ++i) {
      Random random(options.seed,
                    fmt::format("{}{} {}", kind, wanders ? " drift" : "", i));
      PrinterRequest request{.kind = kind};
      request.seed = static_cast<std::uint64_t>(random.Uniform(1, 2e9));
      request.sigma = random.LogUniform(kind == "outside" ? 3 : 1, 20);
      if (kind == "pair") request.sigma = random.LogUniform(2, 15);
      if (wanders) request.wander_um_per_sqrt_h = random.LogUniform(0.4, 5);
      if (kind != "null") {
        request.cause = causes[static_cast<std::size_t>(i) % causes.size()];
      }
      const std::string& only = options.one.cause;
      if (only.empty() || only == request.cause) requests.push_back(request);
    }
  };
  add("null", options.nulls);
  add("null", options.drifts, /*wanders=*/true);
  add("single", options.singles);
  add("pair", options.pairs);
  add("outside", options.outside);
  return requests;
}

Judgement ExamineOne(const PrinterKind& printer,
                     const Diagnoser& diagnoser,
                     const PrinterRequest& request) {
  const std::string folder =
      (std::filesystem::path(diagnoser.folder) /
       fmt::format("{}_{}_{}", request.kind, request.cause, request.seed))
          .string();
  const nlohmann::json truth = printer.write(request, folder);
  const auto begin = std::chrono::steady_clock::now();
  const auto answer = Diagnose(diagnoser, folder, {.extend = "machine.ext.yaml"});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  nlohmann::json again = nullptr;
  if (answer.is_object() &&
      std::filesystem::exists(std::filesystem::path(folder) / "machine.ext.yaml")) {
    again = Diagnose(
        diagnoser, folder, {.machine = "machine.ext.yaml", .answer = "again.json"});
  }
  Judgement judgement = Judge(truth, answer, again);
  judgement.seconds = took.count();
  if (!diagnoser.keep) std::filesystem::remove_all(folder);
  return judgement;
}

std::vector<Judgement> ExamineAll(const PrinterKind& printer, const Options& options) {
  const std::vector<PrinterRequest> requests = RequestsOf(printer, options);
  const Diagnoser diagnoser{
      .binary = options.binary, .folder = options.folder, .keep = options.keep};
  std::vector<Judgement> judgements(requests.size());
  std::atomic<std::size_t> next = 0;
  std::mutex printing;
  const auto work = [&] {
    for (std::size_t i = next++; i < requests.size(); i = next++) {
      judgements[i] = ExamineOne(printer, diagnoser, requests[i]);
      const std::lock_guard lock(printing);
      const std::string line = Line(judgements[i]);
      const bool is_wrong = line.find("WRONG") != std::string::npos ||
                            line.find("not none") != std::string::npos ||
                            !judgements[i].ran;
      if (!options.failures_only || is_wrong) std::cout << line << '\n' << std::flush;
    }
  };
  std::vector<std::thread> threads;
  for (int j = 0; j < options.jobs; ++j) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return judgements;
}

int Run(const PrinterKind& printer, const Options& options) {
  if (!options.out.empty()) {
    printer.write(options.one, options.out);
    return 0;
  }
  const auto judgements = ExamineAll(printer, options);
  const std::string text = FiguresText(judgements) + "\n" + ConfusionText(judgements);
  std::cout << "\n" << text;
  if (!options.markdown.empty()) std::ofstream(options.markdown) << text;
  for (const Figure& figure : Figures(judgements)) {
    if (figure.cases > 0 && figure.IsBeyondChance()) return 1;
  }
  return 0;
}

}  // namespace

int PrinterMain(int argc, char** argv, const PrinterKind& printer) {
  Options options;
  options.folder = "blind_" + printer.name;
  CLI::App app{"Hides causes in a " + printer.name +
               "'s data and asks caltwin for them."};
  app.add_option("--binary", options.binary, "the caltwin to be judged");
  app.add_option("--folder", options.folder, "for the cases");
  app.add_option("--nulls", options.nulls);
  app.add_option("--singles", options.singles);
  if (printer.has_pairs) {
    app.add_option("--drifts", options.drifts, "nulls on machines that wander");
    app.add_option("--pairs", options.pairs, "two causes at once");
  }
  app.add_option("--outside", options.outside);
  app.add_option("--seed", options.seed, "of the set");
  app.add_option("--jobs", options.jobs);
  app.add_option("--markdown", options.markdown, "writes the tables there too");
  app.add_flag("--keep", options.keep, "keeps the cases' folders");
  app.add_flag("--failures-only", options.failures_only);
  app.add_option("--cause", options.one.cause, "only this cause");
  app.add_option("--axis", options.one.axis, "with --out: where it acts");
  app.add_option("--kind", options.one.kind, "with --out: null, single, outside; pair");
  app.add_option("--sigma", options.one.sigma, "with --out: how large");
  app.add_option("--case-seed", options.one.seed, "with --out: of the case");
  app.add_option("--out", options.out, "writes one case into this folder");
  CLI11_PARSE(app, argc, argv);
  try {
    return Run(printer, options);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}

}  // namespace blind
