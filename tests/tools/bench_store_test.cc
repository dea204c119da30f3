#include "tools/commands/api/bench_store.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/base/temp_folder.h"
#include "tools/commands/api/bench_settings.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::IsEmpty;

RunningJob AtWork() {
  return {.job = {{"id", 7},
                  {"procedure", "next_cluster_backlash"},
                  {"said", {"touching"}},
                  {"readings", {{{"value_mm", 0.1}}, {{"value_mm", 0.2}}}},
                  {"result", nullptr}},
          .question = {{"id", 2}, {"text", "Set backlash.x?"}},
          .kept_at = "2026-01-02T03:04:05Z"};
}

TEST(BenchStore, AJobAtWorkIsReadAgainAndDropped) {
  const TempFolder folder;
  const BenchStore store(folder / "router.bench.json");
  std::string note;
  EXPECT_FALSE(store.ReadJob(&note));

  store.WriteJob(AtWork());

  const auto read = store.ReadJob(&note);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->job, AtWork().job);
  EXPECT_EQ(read->question, AtWork().question);
  EXPECT_THAT(note, IsEmpty());
  store.DropJob();
  EXPECT_FALSE(store.ReadJob(&note));
}

TEST(BenchStore, WhatIsNoJobIsPutAside) {
  const TempFolder folder;
  const BenchStore store(folder / "router.bench.json");
  for (const char* const text :
       {"{", R"({"job": {}, "question": null, "applied": []})"}) {
    std::string note;
    std::ofstream(folder / "router.bench.job.json") << text;

    EXPECT_FALSE(store.ReadJob(&note)) << text;
    EXPECT_THAT(note, HasSubstr("put aside")) << text;
  }
}

TEST(BenchStore, AnInterruptedJobSaysWhereItStoodAndWhatIsOtherNow) {
  Settings kept;
  kept.steps_per_mm = {797.2, 800, 800};
  kept.backlash_mm = {0.05, 0, 0};
  Settings now = kept;
  now.backlash_mm[0] = 0;
  RunningJob running = AtWork();
  Settings before = kept;
  before.steps_per_mm[0] = 800;
  running.applied = ChangesOf(before, kept);

  const Json job = InterruptedJob(running, kept, now);

  EXPECT_EQ(job["result"]["ending"], "interrupted");
  EXPECT_EQ(job["result"]["touches"], 2);
  ASSERT_EQ(job["result"]["steps"].size(), 1);
  EXPECT_EQ(job["result"]["steps"][0]["name"], "steps_per_mm.x");
  EXPECT_EQ(job["result"]["steps"][0]["after"], 797.2);
  EXPECT_EQ(job["question"]["text"], "Set backlash.x?");
  EXPECT_THAT(job["result"]["messages"].dump(),
              HasSubstr("backlash_mm.x was 0.05 and is now 0"));
}

TEST(SettingsWatch, AGapThatIsOffForAMeasurementIsNotLasting) {
  Settings kept;
  kept.backlash_mm = {0.05, 0.03, 0};
  Settings now = kept;
  now.backlash_mm[0] = 0;
  SettingsWatch watch;
  watch.Begin(/*measures=*/true);
  EXPECT_FALSE(watch.Sees("G1 X0 F600"));

  EXPECT_TRUE(watch.Sees("M425 X0"));
  EXPECT_EQ(watch.Lasting(now, kept).backlash_mm[0], 0.05);
  EXPECT_TRUE(watch.Sees("M425 X0.0620"));
  now.backlash_mm[0] = 0.062;
  EXPECT_EQ(watch.Lasting(now, kept).backlash_mm[0], 0.062);
}

TEST(SettingsWatch, AGapThatAPersonSetsToNothingLasts) {
  Settings kept;
  kept.backlash_mm = {0.05, 0, 0};
  SettingsWatch watch;
  watch.Begin(/*measures=*/false);

  EXPECT_TRUE(watch.Sees("M425 X0"));

  EXPECT_EQ(watch.Lasting(Settings{}, kept).backlash_mm[0], 0);
}

}  // namespace
}  // namespace caltwin
