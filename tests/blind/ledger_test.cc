// A count in parts is the count in one, and never one of two programs.

#include "tests/blind/ledger.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace blind {
namespace {

class LedgerTest : public testing::Test {
 protected:
  LedgerTest()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
    std::filesystem::remove(folder_ / "ledger");
    Write("program", "one");
  }
  std::string File(const char* name) const { return (folder_ / name).string(); }
  void Write(const char* name, const char* text) const {
    std::ofstream(File(name)) << text;
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(LedgerTest, JudgementsComeBackAsTheyWere) {
  const Judgement judgement{.kind = "single",
                            .name = "cyclic_lead x",
                            .seed = 12345678901234567890ULL,
                            .sigma = 4.25,
                            .ran = true,
                            .findings = {{.cause = "cyclic_lead", .probability = 0.99}},
                            .covered = 2};
  Ledger(File("ledger"), File("program")).Add("case 1", judgement);
  const Ledger again(File("ledger"), File("program"));
  ASSERT_EQ(again.size(), 1U);
  const auto found = again.Find("case 1");
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->seed, judgement.seed);
  EXPECT_EQ(found->sigma, judgement.sigma);
  EXPECT_EQ(found->separation, judgement.separation);
  ASSERT_EQ(found->findings.size(), 1U);
  EXPECT_EQ(found->findings[0].probability, 0.99);
  EXPECT_FALSE(again.Find("case 2").has_value());
}

TEST_F(LedgerTest, OfAnotherProgramIsRefused) {
  Ledger(File("ledger"), File("program")).Add("case 1", {});
  Write("program", "two");
  EXPECT_THROW(Ledger(File("ledger"), File("program")), std::runtime_error);
}

TEST_F(LedgerTest, ALineThatWasCutOffIsDropped) {
  {
    Ledger ledger(File("ledger"), File("program"));
    ledger.Add("case 1", {});
    ledger.Add("case 2", {});
  }
  std::filesystem::resize_file(File("ledger"),
                               std::filesystem::file_size(File("ledger")) - 5);
  Ledger ledger(File("ledger"), File("program"));
  EXPECT_EQ(ledger.size(), 1U);
  ledger.Add("case 2", {});
  EXPECT_EQ(Ledger(File("ledger"), File("program")).size(), 2U);
}

}  // namespace
}  // namespace blind
