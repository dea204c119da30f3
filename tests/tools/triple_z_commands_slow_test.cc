// A triple-Z printer as its user types it: run, record, diagnose, correct, serve.
#include <atomic>
#include <fstream>
#include <future>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calibration/kinds/triple_z/procedures.h"
#include "sim/base/text_file.h"
#include "sim/link/open_link.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/kinds/simulated_printer.h"
#include "tools/commands/serve/serve.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kMostBytes = 1'000'000;

std::string SwappedTruth(const TempFolder& folder) {
  const auto truth = folder / "truth.yaml";
  std::ofstream(truth) << "effects: {bed_tilt: {slope_x_mrad: 3}, "
                          "motors_swapped.z1z3: {}}\n";
  return truth.string();
}

// Whatever the scenario's own procedure found: its touches say it again.
TEST(TripleZCommands, WhatARunRecordsIsDiagnosed) {
  const TempFolder folder;
  const std::string rows = (folder / "rows.csv").string();
  const std::string json = (folder / "answer.json").string();
  Printed(
      DeclareRun,
      {std::string(CALTWIN_SOURCE_DIR) + "/scenarios/tz_three_motors_in_a_ring.yaml",
       "--fidelity",
       "fast",
       "--record",
       rows});

  Printed(DeclareDiagnose, {rows, "--replay", "none", "--json", json});

  const auto answer = nlohmann::json::parse(ReadTextFile(json, kMostBytes));
  EXPECT_EQ(answer["verdict"], "named");
  ASSERT_EQ(answer["findings"].size(), 1U);
  EXPECT_EQ(answer["findings"][0]["cause"], "motors_swapped");
  EXPECT_EQ(answer["findings"][0]["axis"], "z1z2z3");
}

TEST(TripleZCommands, WhatIsFoundIsWrittenForAController) {
  const TempFolder folder;
  const std::string rows = (folder / "rows.csv").string();
  const std::string fix = (folder / "fix.cfg").string();
  const auto plan = folder / "plan.yaml";
  std::ofstream(plan) << "format: 1\nmachine: triple_z_printer\n"
                         "instruments: {probe: {sigma_um: 5}}\n"
                         "campaigns: [tz_grid, screws_one_by_one: {travel_mm: 1}]\n";
  Printed(DeclareSimulate,
          {plan.string(),
           "--truth",
           SwappedTruth(folder),
           "--fidelity",
           "fast",
           "--out",
           rows});

  Printed(DeclareDiagnose,
          {rows, "--replay", "none", "--for", "klipper", "--correction", fix});

  EXPECT_THAT(ReadTextFile(fix, kMostBytes),
              HasSubstr("[z_tilt]\nz_positions:\n    20.00, 215.00\n"
                        "    215.00, 20.00\n    20.00, 20.00\n"));
  EXPECT_THAT(
      RunCommand(DeclareDiagnose, {rows, "--for", "linuxcnc", "--correction", fix})
          .fault,
      HasSubstr("levels no bed by its screws"));
}

// One program serves the printer, another finds its wiring over the port.
TEST(TripleZCommands, AServedPrinterIsCalibratedAsBesideIt) {
  const TempFolder folder;
  const TwinOptions named{
      .machine = "triple_z_printer", .truth = SwappedTruth(folder), .fidelity = "fast"};
  SimulatedPrinter served(named), beside(named);
  std::atomic<bool> stop = false;
  std::promise<int> port;
  std::thread server([&] {
    ServeTcp(PortsOf(&served.link()), 0, &stop, [&port](int number) {
      port.set_value(number);
    });
  });
  const auto over_port =
      OpenLink("tcp:127.0.0.1:" + std::to_string(port.get_future().get()));

  const auto found_by = [&](Link* link) {
    TripleZPrinter printer(BenchOf(served.machine(), link, 0));
    return RunPivotsAndWiring(&printer, {}).result.messages;
  };
  const auto said = found_by(over_port.get());

  stop = true;
  server.join();
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front().text, "Z1 and Z3 are swapped");
  EXPECT_EQ(said, found_by(&beside.link()));
}

}  // namespace
}  // namespace caltwin
