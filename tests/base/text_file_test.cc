#include "sim/base/text_file.h"

#include <filesystem>
#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

class TextFile : public ::testing::Test {
 protected:
  static std::string MessageOf(const std::function<void()>& act) {
    try {
      act();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TempFolder folder_{};
};

TEST_F(TextFile, WhatWasWrittenIsReadBack) {
  const std::string text = "one\r\ntwo\n\xC3\xA4";

  WriteTextFile(folder_ / "new" / "f.txt", text);

  EXPECT_EQ(ReadTextFile(folder_ / "new" / "f.txt", 100), text);
}

TEST_F(TextFile, NothingIsLeftBesideTheFile) {
  WriteTextFile(folder_ / "f.txt", "old");
  WriteTextFile(folder_ / "f.txt", "new");

  EXPECT_EQ(
      std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()),
      1);
  EXPECT_EQ(ReadTextFile(folder_ / "f.txt", 100), "new");
}

TEST_F(TextFile, WhatAKilledWriterLeftGoesAndALivingOnesStays) {
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  const std::string theirs = fmt::format("f.txt.{}.part", gone);
  const std::string living = fmt::format("f.txt.{}.part", getppid());
  for (const std::string& name : {theirs, living, std::string("f.txt.old.part")}) {
    WriteTextFile(folder_ / name, "half");
  }

  WriteDurably(folder_ / "f.txt", "whole");

  EXPECT_FALSE(fs::exists(folder_ / theirs));
  EXPECT_TRUE(fs::exists(folder_ / living));
  EXPECT_TRUE(fs::exists(folder_ / "f.txt.old.part"));
  EXPECT_EQ(ReadTextFile(folder_ / "f.txt", 100), "whole");
}

TEST_F(TextFile, ADeviceIsWrittenInPlace) {
  WriteTextFile("/dev/null", "text");

  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(TextFile, WhatCannotBeReadIsSaid) {
  const std::string folder = folder_.path().string();

  EXPECT_EQ(MessageOf([&] { ReadTextFile(folder + "/none", 9); }),
            folder + "/none: there is no such file");
  EXPECT_EQ(MessageOf([&] { ReadTextFile(folder, 9); }),
            folder + ": this is a folder, where a file is wanted");
}

TEST_F(TextFile, TheSizeLimitIsInclusive) {
  WriteTextFile(folder_ / "f", "123456789");
  const std::string file = (folder_ / "f").string();

  EXPECT_EQ(ReadTextFile(file, 9), "123456789");
  EXPECT_EQ(MessageOf([&] { ReadTextFile(file, 8); }),
            file + ":1:1: larger than any file of this kind (at most 8 bytes)");
  EXPECT_EQ(MessageOf([&] { ReadTextFile("/dev/zero", 8); }),
            "/dev/zero:1:1: larger than any file of this kind (at most 8 bytes)");
}

TEST_F(TextFile, AFolderIsNotOverwritten) {
  EXPECT_EQ(MessageOf([&] { WriteTextFile(folder_.path(), "x"); }),
            folder_.path().string() + ": this file cannot be written");
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

// RFC 3629 section 3 and its tables: the first and last of each length, and what lies
// just outside.
TEST(RequireText, TakesUtf8AndNothingElse) {
  for (const char* good : {"",
                           "plain",
                           "\xC2\x80",
                           "\xDF\xBF",
                           "\xE0\xA0\x80",
                           "\xED\x9F\xBF",
                           "\xEE\x80\x80",
                           "\xEF\xBF\xBF",
                           "\xF0\x90\x80\x80",
                           "\xF4\x8F\xBF\xBF"}) {
    EXPECT_NO_THROW(RequireText(good, "f")) << good;
  }
  for (const char* bad : {"\x80",
                          "\xC1\xBF",
                          "\xC2",
                          "\xC2\x41",
                          "\xE0\x9F\xBF",
                          "\xE2\x82",
                          "\xED\xA0\x80",
                          "\xF0\x8F\xBF\xBF",
                          "\xF0\x90\x80",
                          "\xF4\x90\x80\x80",
                          "\xF5\x80\x80\x80",
                          "\xFF"}) {
    EXPECT_THROW(RequireText(bad, "f"), InputError) << bad;
  }
}

TEST(RequireText, NamesTheFirstBadPlace) {
  try {
    RequireText(std::string("ab\ncd\0", 6), "f");
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "f:2:3: a zero byte: this is not a text file");
  }
}

}  // namespace
}  // namespace caltwin
