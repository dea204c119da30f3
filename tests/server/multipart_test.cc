#include "tools/server/multipart.h"

#include <gtest/gtest.h>

#include "tools/server/problem.h"

namespace caltwin {
namespace {

constexpr const char* kType = "multipart/form-data; boundary=XX";

int StatusOf(const std::string& type, const std::string& body) {
  try {
    ReadForm(type, body);
  } catch (const Problem& problem) {
    return problem.status();
  }
  return 200;
}

TEST(Multipart, AFormIsTakenApart) {
  const auto parts =
      ReadForm(kType,
               "--XX\r\nContent-Disposition: form-data; name=\"file\"; "
               "filename=\"a \\\"b\\\".csv\"\r\nContent-Type: text/csv\r\n\r\n"
               "x,y\r\n--X\r\n\r\n--XX\r\ncontent-disposition: form-data; "
               "name=unit\r\n\r\nmm\r\n--XX--\r\n");

  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].name, "file");
  EXPECT_EQ(parts[0].file_name, "a \"b\".csv");
  EXPECT_EQ(parts[0].body, "x,y\r\n--X\r\n");
  EXPECT_EQ(parts[1].name, "unit");
  EXPECT_EQ(parts[1].body, "mm");
}

TEST(Multipart, BrokenFormsAreRefused) {
  const std::string part =
      "--XX\r\nContent-Disposition: form-data; name=a\r\n\r\nb\r\n";

  EXPECT_EQ(StatusOf(kType, part + "--XX--"), 200);
  EXPECT_EQ(StatusOf(kType, part), 400);
  EXPECT_EQ(StatusOf(kType, ""), 400);
  EXPECT_EQ(
      StatusOf(kType, "--XX\r\nContent-Disposition: form-data\r\n\r\nb\r\n--XX--"),
      400);
  EXPECT_EQ(StatusOf(kType, "--XX\r\nno end of headers\r\n--XX--"), 400);
  EXPECT_EQ(StatusOf("application/json", part), 415);
  EXPECT_EQ(StatusOf("multipart/form-data", part), 415);
  EXPECT_EQ(StatusOf("multipart/form-data; boundary=" + std::string(71, 'x'), part),
            415);
  std::string many;
  for (int i = 0; i < 65; ++i) many += part;
  EXPECT_EQ(StatusOf(kType, many + "--XX--"), 400);
}

TEST(Multipart, AFileNameIsNoPath) {
  EXPECT_EQ(SafeFileName("../../etc/passwd"), "passwd");
  EXPECT_EQ(SafeFileName("C:\\data\\my run.csv"), "my_run.csv");
  EXPECT_EQ(SafeFileName("--json=x"), "jsonx");
  EXPECT_EQ(SafeFileName("..."), "file");
  EXPECT_EQ(SafeFileName(""), "file");
  EXPECT_EQ(SafeFileName(std::string(300, 'a') + ".csv").size(), 100u);
  EXPECT_TRUE(SafeFileName(std::string(300, 'a') + ".csv").ends_with(".csv"));
}

}  // namespace
}  // namespace caltwin
