// blind_delta: hides causes in a delta's data, has them diagnosed, and only here opens
// the truth. With --out it writes one case and stops.

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tests/blind/delta/case.h"
#include "tests/blind/diagnosis.h"
#include "tests/blind/figures.h"

namespace blind {
namespace {

struct Options {
  std::string binary = "caltwin", folder = "blind_delta", markdown{}, out{};
  DeltaRequest one{};
  int nulls = 20, singles = 44, outside = 12, jobs = 2;
  std::uint64_t seed = 1;
  bool keep = false, failures_only = false;
};

std::vector<DeltaRequest> RequestsOf(const Options& options) {
  std::vector<DeltaRequest> requests;
  const auto add = [&](const std::string& kind, int count) {
    std::vector<DeltaCause> causes;
    for (const DeltaCause& cause : DeltaCauses()) {
      if (cause.is_outside == (kind == "outside")) causes.push_back(cause);
    }
    for (int i = 0; i < count; ++i) {
      Random random(options.seed, fmt::format("{} {}", kind, i));
      DeltaRequest request{.kind = kind};
      request.seed = static_cast<std::uint64_t>(random.Uniform(1, 2e9));
      request.sigma = random.LogUniform(kind == "outside" ? 3 : 1, 20);
      if (kind != "null") {
        request.cause = causes[static_cast<std::size_t>(i) % causes.size()].name;
      }
      const std::string& only = options.one.cause;
      if (only.empty() || only == request.cause) requests.push_back(request);
    }
  };
  add("null", options.nulls);
  add("single", options.singles);
  add("outside", options.outside);
  return requests;
}

Judgement ExamineDelta(const Diagnoser& diagnoser, const DeltaRequest& request) {
  const std::string folder =
      (std::filesystem::path(diagnoser.folder) /
       fmt::format("{}_{}_{}", request.kind, request.cause, request.seed))
          .string();
  const DeltaCase made = MakeDeltaCase(request);
  WriteDeltaCase(made, folder);
  const auto begin = std::chrono::steady_clock::now();
  const auto answer = Diagnose(diagnoser, folder, {.extend = "machine.ext.yaml"});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  nlohmann::json again = nullptr;
  if (answer.is_object() &&
      std::filesystem::exists(std::filesystem::path(folder) / "machine.ext.yaml")) {
    again = Diagnose(
        diagnoser, folder, {.machine = "machine.ext.yaml", .answer = "again.json"});
  }
  Judgement judgement = Judge(made.truth, answer, again);
  judgement.seconds = took.count();
  if (!diagnoser.keep) std::filesystem::remove_all(folder);
  return judgement;
}

std::vector<Judgement> ExamineAll(const Options& options) {
  const std::vector<DeltaRequest> requests = RequestsOf(options);
  const Diagnoser diagnoser{
      .binary = options.binary, .folder = options.folder, .keep = options.keep};
  std::vector<Judgement> judgements(requests.size());
  std::atomic<std::size_t> next = 0;
  std::mutex printing;
  const auto work = [&] {
    for (std::size_t i = next++; i < requests.size(); i = next++) {
      judgements[i] = ExamineDelta(diagnoser, requests[i]);
      const std::lock_guard lock(printing);
      const std::string line = Line(judgements[i]);
      const bool is_wrong = line.find("WRONG") != std::string::npos ||
                            line.find("not none") != std::string::npos ||
                            !judgements[i].ran;
      if (!options.failures_only || is_wrong) std::cout << line << std::endl;
    }
  };
  std::vector<std::thread> threads;
  for (int j = 0; j < options.jobs; ++j) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return judgements;
}

int Run(const Options& options) {
  if (!options.out.empty()) {
    WriteDeltaCase(MakeDeltaCase(options.one), options.out);
    return 0;
  }
  const auto judgements = ExamineAll(options);
  const std::string text = FiguresText(judgements) + "\n" + ConfusionText(judgements);
  std::cout << "\n" << text;
  if (!options.markdown.empty()) std::ofstream(options.markdown) << text;
  for (const Figure& figure : Figures(judgements)) {
    if (figure.cases > 0 && figure.IsBeyondChance()) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace blind

int main(int argc, char** argv) {
  blind::Options options;
  CLI::App app{"Hides causes in a delta's data and asks caltwin for them."};
  app.add_option("--binary", options.binary, "the caltwin to be judged");
  app.add_option("--folder", options.folder, "for the cases");
  app.add_option("--nulls", options.nulls);
  app.add_option("--singles", options.singles);
  app.add_option("--outside", options.outside);
  app.add_option("--seed", options.seed, "of the set");
  app.add_option("--jobs", options.jobs);
  app.add_option("--markdown", options.markdown, "writes the tables there too");
  app.add_flag("--keep", options.keep, "keeps the cases' folders");
  app.add_flag("--failures-only", options.failures_only);
  app.add_option("--cause", options.one.cause, "only this cause");
  app.add_option("--axis", options.one.axis, "with --out: where it acts");
  app.add_option("--kind", options.one.kind, "with --out: null, single or outside");
  app.add_option("--sigma", options.one.sigma, "with --out: how large");
  app.add_option("--case-seed", options.one.seed, "with --out: of the case");
  app.add_option("--out", options.out, "writes one case into this folder");
  CLI11_PARSE(app, argc, argv);
  try {
    return blind::Run(options);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
