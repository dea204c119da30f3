// blind_score: runs the diagnosis on hidden truth, and only here opens the truth.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tests/blind/diagnosis.h"
#include "tests/blind/figures.h"
#include "tests/blind/ledger.h"
#include "tests/blind/metamorphic.h"
#include "tests/blind/sets.h"
#include "tests/blind/volumetric.h"

namespace {

/// 20261122, in UTC.
std::uint64_t Today() {
  const std::chrono::year_month_day today(
      std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()));
  return static_cast<std::uint64_t>(static_cast<int>(today.year())) * 10'000 +
         static_cast<unsigned>(today.month()) * 100 +
         static_cast<unsigned>(today.day());
}

struct Options {
  blind::Diagnoser diagnoser{.folder = "/tmp/blind_score"};
  std::uint64_t seed = 1;
  std::uint64_t date = Today();
  int full = 0;
  int physics = 10;
  int loops = 10;
  int changes = 8;
  int volumetric = 0;
  int jobs = 2;
  double minutes = 0;  // 0: as long as it takes.
  std::string ledger{};
  std::string markdown{};
  std::string only{};
  bool failures_only = false;
};

bool IsWrong(const blind::Judgement& j) {
  const bool wrong_name = std::ranges::any_of(j.findings, [](const auto& finding) {
    return !finding.right && !finding.holds && !finding.tolerable;
  });
  return !j.ran || wrong_name || (j.hidden > 0 && j.kind != "outside" && !j.set_holds);
}

/// One case; a case that cannot even be made counts as one without an answer.
blind::Judgement ExamineOne(const Options& options,
                            const blind::CaseRequest& request,
                            std::mutex* output) {
  try {
    return blind::Examine(options.diagnoser, request);
  } catch (const std::exception& error) {
    const std::scoped_lock lock(*output);
    std::cout << "not made: " << error.what() << "\n";
    return {.kind = request.kind,
            .name = request.hidden.empty() ? "-" : request.hidden[0].cause,
            .seed = request.seed,
            .physics = request.physics};
  }
}

/// The order in which cases are taken: wherever time runs out, every
/// part of the set has its share (multiples of the golden ratio, modulo one).
std::vector<std::size_t> FairOrder(std::size_t count) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    return std::fmod(static_cast<double>(i) * golden, 1.0);
  });
  return order;
}

/// What a ledger holds of the requests is taken from there, and no longer in the order.
std::unique_ptr<blind::Ledger> OpenLedger(
    const Options& options,
    const std::vector<blind::CaseRequest>& requests,
    std::vector<std::size_t>* order,
    std::vector<std::optional<blind::Judgement>>* judgements) {
  if (options.ledger.empty()) return nullptr;
  auto ledger =
      std::make_unique<blind::Ledger>(options.ledger, options.diagnoser.binary);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    (*judgements)[i] = ledger->Find(blind::RerunCommand(requests[i]));
  }
  std::erase_if(*order, [&](std::size_t i) { return (*judgements)[i].has_value(); });
  std::cout << fmt::format(
      "{} of {} judged before\n", requests.size() - order->size(), requests.size());
  return ledger;
}

/// All cases, or as many as the time allows, a few at a time; the judgements stand in
/// the order of the requests.
std::vector<blind::Judgement> ExamineAll(
    const Options& options, const std::vector<blind::CaseRequest>& requests) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto is_over = [&] {
    const std::chrono::duration<double, std::ratio<60>> spent = Clock::now() - start;
    return options.minutes > 0 && spent.count() >= options.minutes;
  };
  std::vector<std::size_t> order = FairOrder(requests.size());
  std::vector<std::optional<blind::Judgement>> judgements(requests.size());
  const auto ledger = OpenLedger(options, requests, &order, &judgements);
  std::atomic<std::size_t> next = 0;
  std::mutex output;
  const auto work = [&] {
    for (std::size_t k = next++; k < order.size() && !is_over(); k = next++) {
      const std::size_t i = order[k];
      const blind::Judgement judgement = ExamineOne(options, requests[i], &output);
      judgements[i] = judgement;
      if (ledger) ledger->Add(blind::RerunCommand(requests[i]), judgement);
      const std::scoped_lock lock(output);
      const bool wrong = IsWrong(judgement);
      if (!options.failures_only || wrong) {
        std::cout << blind::Line(judgement) << "\n";
      }
      if (wrong) std::cout << "        " << blind::RerunCommand(requests[i]) << "\n";
      std::cout.flush();
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < options.jobs; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  std::vector<blind::Judgement> done;
  for (std::optional<blind::Judgement>& judgement : judgements) {
    if (judgement) done.push_back(std::move(*judgement));
  }
  return done;
}

/// Causes along x or y, each changed in ways after which the answer is known.
int CountBrokenChanges(const Options& options) {
  const std::vector<std::string> causes = {"cyclic_lead",
                                           "backlash_worn",
                                           "pitch_progressive",
                                           "thermal_screw",
                                           "missed_steps",
                                           "probe_lobing",
                                           "trigger_latency",
                                           "windup_load"};
  int broken = 0;
  for (int i = 0; i < options.changes; ++i) {
    blind::CaseRequest request{.kind = "single", .clean = true};
    request.seed = (i % 2 == 0 ? options.seed : options.date) + 1000 + i;
    request.hidden = {{causes[static_cast<std::size_t>(i) % causes.size()], "any", 8}};
    for (const auto& result : blind::ExamineChanges(options.diagnoser, request)) {
      const bool ok = result.ran && result.held;
      broken += ok ? 0 : 1;
      std::cout << fmt::format("change  {:34} {:26} {}\n",
                               request.hidden[0].cause,
                               result.what,
                               !result.ran ? "FAILED"
                               : ok        ? "held"
                                           : "BROKEN");
      if (!ok) std::cout << "        " << blind::RerunCommand(request) << "\n";
    }
  }
  return broken;
}

blind::SetSizes SizesOf(const Options& options) {
  if (options.full <= 0) return {.physics = options.physics, .loops = options.loops};
  return {.nulls = options.full,
          .singles = options.full,
          .pairs = options.full / 3,
          .outside = options.full / 3,
          .physics = 0,
          .loops = options.loops,
          .half_physics = true,
          .two_sizes = false};
}

void WriteMarkdown(const Options& options, const std::string& text) {
  std::ofstream stream(options.markdown, std::ios::binary);
  stream << "# Blind tests\n\nMade by `blind_score --binary caltwin"
         << (options.full > 0 ? fmt::format(" --full {}", options.full) : std::string())
         << (options.minutes > 0 ? fmt::format(" --minutes {:g}", options.minutes) : "")
         << (options.ledger.empty() ? "" : " --ledger FILE")
         << fmt::format(" --seed {} --date {}`.\n\n", options.seed, options.date)
         << text;
  if (!stream) throw std::runtime_error("cannot write " + options.markdown);
}

/// What diagnoses are worth at poses that nobody measured.
std::string VolumetricReport(const Options& options) {
  const auto requests = blind::VolumetricSet(options.volumetric, options.seed);
  std::vector<blind::Volumetric> all(requests.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < requests.size(); i = next++) {
      try {
        all[i] = blind::ExamineVolumetric(options.diagnoser, requests[i]);
      } catch (const std::exception& error) {
        all[i] = {.name = std::string("not made: ") + error.what(),
                  .sigma = requests[i].sigma,
                  .seed = requests[i].seed};
      }
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < options.jobs; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  return blind::VolumetricText(all);
}

void Declare(CLI::App* to, Options* into) {
  CLI::App& app = *to;
  Options& options = *into;
  app.add_option("--binary", options.diagnoser.binary, "the caltwin under test")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--folder", options.diagnoser.folder, "scratch folder");
  app.add_flag("--keep", options.diagnoser.keep, "keep the cases and their answers");
  app.add_option("--limit", options.diagnoser.limit_s, "seconds a diagnosis may take");
  app.add_option("--seed", options.seed, "of the first half");
  app.add_option(
      "--date", options.date, "of the second half, as 20261121; default: today");
  app.add_option(
      "--full", options.full, "so many nulls and singles, a third of the rest");
  app.add_option(
      "--physics", options.physics, "cases performed by MuJoCo in the small set");
  app.add_option("--loops", options.loops, "closed loops on an edited model");
  app.add_option("--model", options.diagnoser.model, "the model.xml that they edit");
  app.add_option("--changes", options.changes, "cases to swap, shuffle and reduce");
  app.add_option("--volumetric",
                 options.volumetric,
                 "only this: so many causes at 3 and at 20 sigma, and what is left of "
                 "them at poses that nobody measured");
  app.add_option("--jobs", options.jobs, "diagnoses at a time");
  app.add_option("--minutes",
                 options.minutes,
                 "begins no case after so many; every part of the set has its share");
  app.add_option("--ledger",
                 options.ledger,
                 "file of judgements: those in it are not examined again, new ones are "
                 "written there at once");
  app.add_option("--only",
                 options.only,
                 "only cases of this kind (or physics), or hiding this cause");
  app.add_option("--markdown", options.markdown, "writes figures and confusion there");
  app.add_flag("--failures-only", options.failures_only, "prints only what went wrong");
}

int Run(int argc, char** argv) {
  CLI::App app("Diagnoses hidden causes and counts how often it was right.");
  Options options;
  Declare(&app, &options);
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(options.diagnoser.folder);
  if (options.volumetric > 0) {
    const std::string text = VolumetricReport(options);
    std::cout << text;
    if (!options.markdown.empty()) WriteMarkdown(options, text);
    return 0;
  }
  auto requests = blind::MakeSet(SizesOf(options), options.seed, options.date);
  std::erase_if(requests, [&](const blind::CaseRequest& request) {
    const bool hides =
        !request.hidden.empty() && request.hidden[0].cause == options.only;
    const bool is_physics = options.only == "physics" && request.physics;
    return !options.only.empty() && request.kind != options.only && !hides &&
           !is_physics;
  });
  std::cout << fmt::format("the second half is drawn from --date {}\n", options.date);
  const auto judgements = ExamineAll(options, requests);
  const int broken = options.only.empty() ? CountBrokenChanges(options) : 0;
  std::string text = blind::AllText(judgements);
  if (judgements.size() < requests.size()) {
    text = fmt::format("{} of {} cases, as far as {:g} minutes went.\n\n{}",
                       judgements.size(),
                       requests.size(),
                       options.minutes,
                       text);
  }
  std::cout << "\n" << text;
  if (!options.markdown.empty()) WriteMarkdown(options, text);
  const auto figures = blind::Figures(judgements);
  const bool failed = std::ranges::any_of(figures, &blind::Figure::IsBeyondChance);
  return failed || broken > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "blind_score: " << error.what() << "\n";
    return 2;
  }
}
