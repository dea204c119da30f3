#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "sim/base/text_file.h"

namespace caltwin {

/// What a process of the program ended with.
struct Finished {
  int code = -1;
  std::string out{};
  std::string err{};
};

/// A folder of this test process.
inline std::filesystem::path Scratch() {
  static const std::filesystem::path folder = [] {
    std::string name = ::testing::TempDir() + "/caltwin_cli_XXXXXX";
    return std::filesystem::path(mkdtemp(name.data()));
  }();
  return folder;
}

/// Runs the program as a person would, from the source folder, stdin no terminal.
inline Finished Caltwin(const std::string& arguments) {
  const std::string out = (Scratch() / "out").string();
  const std::string err = (Scratch() / "err").string();
  const int status = std::system(
      fmt::format("{} {} </dev/null >{} 2>{}", CALTWIN_BINARY, arguments, out, err)
          .c_str());
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          .out = ReadTextFile(out, 10'000'000),
          .err = ReadTextFile(err, 10'000'000)};
}

/// The path of a scratch file with that text.
inline std::string Written(const std::string& name, const std::string& text) {
  WriteTextFile(Scratch() / name, text);
  return (Scratch() / name).string();
}

}  // namespace caltwin
