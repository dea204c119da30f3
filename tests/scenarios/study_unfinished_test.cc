// A study that keeps no trials, stopped on its way: what it leaves is enough to go on
// with, to the same bytes.

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenarios/study/half_done.h"
#include "scenarios/study/unkept.h"
#include "tests/scenarios/study_fixture.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kUnkept =
    "  vary: {backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 2}}}\n"
    "  compare: [next_cluster_backlash, trigger_release_backlash]\n"
    "  trials: 12\n"
    "  keep: none\n";

class StudyUnfinishedTest : public StudyTest {
 protected:
  static std::string BytesOf(const Study& study, const Aggregates& aggregates) {
    return SummaryJson(study, SummaryOf(study, aggregates)).dump();
  }

  // What a killed program leaves of part 1/2: some runs folded, one since then.
  void LeaveUnfinished(const Study& study) const {
    StudyStore store(folder() / "out", study, /*may_resume=*/false, kPart);
    HalfDone half{.aggregates = Aggregates(2)};
    for (const auto& [trial, of_case] :
         {std::pair<std::int64_t, std::size_t>{0, 0}, {2, 1}, {8, 0}}) {
      const TrialResult result =
          KeptOf(RunTrial(study, of_case, trial), of_case, trial);
      store.Add(result);
      half.aggregates.at(of_case).Add(result);
      half.done.Add(RunIndex(study, kPart, trial, of_case));
    }
    store.Fold(half.Text());
    store.Add(KeptOf(RunTrial(study, 1, 0), 1, 0));
    EXPECT_EQ(store.Done().size(), 1U);  // The others are in what was folded.
  }

  static constexpr Shard kPart{.index = 0, .count = 2};
};

TEST_F(StudyUnfinishedTest, GoesOnToTheSameBytesAndRunsNothingTwice) {
  const Study study = Read(kUnkept);
  LeaveUnfinished(study);
  StudyStore store(folder() / "out", study, /*may_resume=*/true, kPart);
  const Aggregates whole = RunUnkept(study, {.workers = 2, .shard = kPart}, &store);

  EXPECT_EQ(store.Done().size(), 9U);  // Two times six, three folded.
  EXPECT_EQ(BytesOf(study, whole), BytesOf(study, RunUnkept(study, {.shard = kPart})));
}

TEST_F(StudyUnfinishedTest, IsNotWrittenOverNorTakenForAnother) {
  const Study study = Read(kUnkept);
  LeaveUnfinished(study);
  const fs::path out = folder() / "out";
  EXPECT_THAT([&] { StudyStore(out, study, /*may_resume=*/false, kPart); },
              ThrowsMessage<InputError>(HasSubstr("--resume")));
  EXPECT_THAT([&] { StudyStore(out, study, /*may_resume=*/true); },
              ThrowsMessage<InputError>(HasSubstr("holds part 1/2")));
  const Study other = Read(std::string(kUnkept) + "  seed: 2\n");
  EXPECT_THROW(StudyStore(out, other, /*may_resume=*/true, kPart), InputError);
  {
    StudyStore store(out, study, /*may_resume=*/true, kPart);
    store.Fold("{\"done\": {}}");
    EXPECT_THAT([&] { RunUnkept(study, {.shard = kPart}, &store); },
                ThrowsMessage<InputError>(HasSubstr("cannot be gone on with")));
    store.Discard();
  }
  EXPECT_TRUE(fs::is_empty(out));
}

TEST(DoneIndices, KnowsWhatEndedInWhateverOrder) {
  DoneIndices done;
  for (const std::int64_t index : {3, 0, 5, 1, 3}) done.Add(index);
  EXPECT_EQ(done.count(), 4);
  const DoneIndices read = DoneIndices::OfJson(done.ToJson());

  for (const std::int64_t index : {0, 1, 3, 5}) EXPECT_TRUE(read.Has(index)) << index;
  for (const std::int64_t index : {2, 4, 6}) EXPECT_FALSE(read.Has(index)) << index;
  EXPECT_EQ(read.count(), 4);
  done.Add(2);
  EXPECT_EQ(done.ToJson().at("before"), 4);  // None but 5 is kept one by one.
  EXPECT_EQ(done.ToJson().at("beyond").size(), 1U);
}

}  // namespace
}  // namespace caltwin
