// What a study keeps on disk: nothing is lost, and nothing is taken for something else.

#include <filesystem>
#include <fstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include "scenarios/study/merge.h"
#include "scenarios/study/run.h"
#include "scenarios/study/store.h"
#include "scenarios/study/trials_csv.h"
#include "sim/base/text_file.h"
#include "tests/scenarios/study_fixture.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

using StudyStoreTest = StudyTest;

TEST_F(StudyStoreTest, QuotesNamesInCsv) {
  fs::copy(folder() / "gap.yaml", folder() / "a,\"b.yaml");
  Write("study.yaml", "study:\n  scenarios: ['a,\"b.yaml', gap.yaml]\n  trials: 1\n");
  const Study study = ReadStudy(folder() / "study.yaml");

  EXPECT_THAT(CsvOf(study, folder() / "out", 1), HasSubstr(",\"a,\"\"b\"\n"));
}

TEST_F(StudyStoreTest, OneProgramAtATimeWritesToAFolder) {
  const Study study = Read(kVaried);
  {
    StudyStore store(folder() / "out", study, /*may_resume=*/false);
    EXPECT_THAT(
        [&] { StudyStore(folder() / "out", study, /*may_resume=*/true); },
        ThrowsMessage<InputError>(HasSubstr("another caltwin is writing there")));
  }
  EXPECT_NO_THROW(StudyStore(folder() / "out", study, /*may_resume=*/true));
}

TEST_F(StudyStoreTest, WhatWasLostIsDoneAgainAndNothingElse) {
  const Study study = Read(kVaried);
  const std::string undisturbed = CsvOf(study, folder() / "whole", 2);
  {
    StudyStore store(folder() / "parts", study, /*may_resume=*/false);
    for (const std::int64_t trial : {0, 1, 7}) {
      store.Add(KeptOf(RunTrial(study, 0, trial), 0, trial));
    }
  }
  StudyStore store(folder() / "parts", study, /*may_resume=*/true);
  EXPECT_EQ(store.Done().size(), 3U);
  EXPECT_EQ(RunStudy(study, {}, &store).done, 12);
  EXPECT_EQ(TrialsCsv(study, store), undisturbed);
  WriteTrialsCsv(study, store, folder() / "trials.csv");
  EXPECT_EQ(ReadTextFile(folder() / "trials.csv", 1'000'000), undisturbed);
  EXPECT_EQ(RunStudy(study, {}, &store).per_s, 0);  // Nothing left to do.
}

TEST_F(StudyStoreTest, PartsPutTogetherAreTheWhole) {
  const Study study = Read(kVaried);
  const std::string undisturbed = CsvOf(study, folder() / "whole", 2);
  std::vector<fs::path> parts;
  for (const std::string shard : {"1/3", "2/3", "3/3"}) {
    parts.push_back(folder() / ("part" + shard.substr(0, 1)));
    StudyStore store(parts.back(), study, /*may_resume=*/false, ReadShard(shard));
    const StudyProgress done = RunStudy(study, {.shard = ReadShard(shard)}, &store);
    EXPECT_EQ(done.done, 4);
    EXPECT_EQ(done.all, 4);
  }
  StudyStore merged(folder() / "merged", study, /*may_resume=*/false);
  try {
    MergeParts(study, {parts[2], parts[0]}, &merged);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("trial 1 is in none of these folders"));
  }
  EXPECT_TRUE(merged.Done().empty());
  MergeParts(study, {parts[2], parts[0], parts[1], parts[0]}, &merged);

  EXPECT_EQ(TrialsCsv(study, merged), undisturbed);
}

TEST_F(StudyStoreTest, APartIsNotTakenForAnother) {
  const Study study = Read(kVaried);
  { const StudyStore part(folder() / "part", study, false, ReadShard("1/2")); }

  EXPECT_THROW(StudyStore(folder() / "part", study, true), InputError);
  EXPECT_THROW(StudyStore(folder() / "part", study, true, ReadShard("2/2")),
               InputError);
  EXPECT_THROW(StudyStore::OpenPart(folder() / "nowhere", study), InputError);
  for (const char* wrong : {"0/2", "3/2", "1", "1/2x", "/", "a/b", "-1/2"}) {
    EXPECT_THROW(ReadShard(wrong), InputError) << wrong;
  }
}

TEST_F(StudyStoreTest, AChangedMachineIsAnotherStudy) {
  fs::copy(fs::path(CALTWIN_SOURCE_DIR) / "models" / "gantry_router", folder() / "own");
  Write("gap.yaml",
        "machine: own/machine.yaml\nfidelity: fast\ncalibrate: [next_all]\n");
  const std::string before = Read("  trials: 1\n").Fingerprint();
  EXPECT_EQ(Read("  trials: 1\n").Fingerprint(), before);

  std::ofstream(folder() / "own" / "model.xml", std::ios::app) << "<!-- other -->\n";
  EXPECT_NE(Read("  trials: 1\n").Fingerprint(), before);
}

TEST_F(StudyStoreTest, TellsBeforehandThatThereIsNoRoom) {
  const Study study = Read("  trials: 1000000000\n");  // 2 TB.
  std::error_code error;
  if (fs::space(folder(), error).available > std::uintmax_t{2'000'000'000'000}) {
    GTEST_SKIP() << "this disk has room for anything";
  }
  EXPECT_THAT([&] { StudyStore(folder() / "out", study, /*may_resume=*/false); },
              ThrowsMessage<InputError>(HasSubstr("need about 2000005.0 MB")));
  EXPECT_FALSE(fs::exists(folder() / "out"));
}

// A disk of 8 MB of one's own, seen by this process alone; false where it may not.
bool MountSmallDisk(const fs::path& at) {
  return unshare(CLONE_NEWNS) == 0 &&
         mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         mount("tmpfs", at.c_str(), "tmpfs", 0, "size=8m") == 0;
}

TEST_F(StudyStoreTest, AFullDiskLeavesWhatWasDone) {
  const fs::path disk = folder() / "disk";
  fs::create_directories(disk);
  if (!MountSmallDisk(disk)) GTEST_SKIP() << "no right to mount a disk";
  const Study study = Read("  trials: 12\n");
  std::int64_t kept = 0;
  {
    StudyStore store(disk / "out", study, /*may_resume=*/false);
    std::ofstream(disk / "filler") << std::string(8 << 20, 'x');
    const std::string long_message(20'000, 'm');
    try {
      for (; kept < 12; ++kept) {
        store.Add({.trial = kept, .status = "failed", .message = long_message});
      }
      FAIL() << "all fitted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the disk is full"));
    }
  }
  EXPECT_THAT([&] { StudyStore(disk / "elsewhere", study, /*may_resume=*/false); },
              ThrowsMessage<InputError>(HasSubstr("MB of room")));
  fs::remove(disk / "filler");
  StudyStore store(disk / "out", study, /*may_resume=*/true);
  EXPECT_EQ(store.Done().size(), static_cast<std::size_t>(kept));
  EXPECT_EQ(RunStudy(study, {}, &store).done, 12);
}

TEST_F(StudyStoreTest, AFinishedStudyIsReadInAReadOnlyFolder) {
  const fs::path disk = folder() / "disk";
  fs::create_directories(disk);
  if (!MountSmallDisk(disk)) GTEST_SKIP() << "no right to mount a disk";
  const Study study = Read(kVaried);
  const std::string csv = CsvOf(study, disk / "o #%", 1);
  ASSERT_EQ(mount("none", disk.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
  StudyStore store(disk / "o #%", study, /*may_resume=*/true);

  EXPECT_EQ(RunStudy(study, {}, &store).done, 12);
  EXPECT_EQ(TrialsCsv(study, store), csv);
  EXPECT_THROW(store.Add({.trial = 99, .status = "recovers"}), InputError);
}

TEST_F(StudyStoreTest, SaysThatAStoreIsBroken) {
  const Study study = Read(kVaried);
  CsvOf(study, folder() / "out", 1);
  StudyStore store(folder() / "out", study, /*may_resume=*/true);
  // Somebody else's program takes a table away.
  SQLite::Database(folder() / "out" / "study.sqlite", SQLite::OPEN_READWRITE)
      .exec("DROP TABLE trials");

  EXPECT_THROW(store.Done(), InputError);
  const auto no_matter = [](const TrialResult&) {
  };
  EXPECT_THROW(store.ForEach(no_matter), InputError);
  EXPECT_THROW(store.Add({.trial = 99, .status = "recovers"}), InputError);
}

TEST_F(StudyStoreTest, AFolderThatHoldsTrialsIsNotWrittenToUnasked) {
  const Study study = Read(kVaried);
  CsvOf(study, folder() / "out", 1);
  EXPECT_THAT([&] { StudyStore(folder() / "out", study, /*may_resume=*/false); },
              ThrowsMessage<InputError>(HasSubstr("--resume")));
  const Study other = Read("  trials: 12\n  seed: 2\n");
  EXPECT_THROW(StudyStore(folder() / "out", other, true), InputError);
  Write("no_study", "text");
  fs::create_directories(folder() / "bad");
  fs::rename(folder() / "no_study", folder() / "bad" / "study.sqlite");
  EXPECT_THROW(StudyStore(folder() / "bad", study, true), InputError);
  Write("file", "");
  EXPECT_THROW(StudyStore(folder() / "file", study, false), InputError);
}

}  // namespace
}  // namespace caltwin
