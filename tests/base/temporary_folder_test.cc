#include "sim/base/temporary_folder.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

TEST(TemporaryFolder, IsGoneWithItsOwner) {
  const TempFolder where;
  fs::path path;
  {
    const TemporaryFolder folder("caltwin_here", where.path());
    path = folder.path();
    EXPECT_TRUE(path.filename().string().starts_with("caltwin_here_"));
    std::ofstream(path / "file") << "text";
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(TemporaryFolder, RemovesThoseOfTheDeadAndNoOthers) {
  const TempFolder where;
  const pid_t dead = fork();
  if (dead == 0) _exit(0);
  waitpid(dead, nullptr, 0);
  const fs::path left = where / fmt::format("caltwin_here_{}_ab", dead);
  const fs::path alive = where / fmt::format("caltwin_here_{}_ab", getpid());
  const fs::path other = where / fmt::format("caltwin_there_{}_ab", dead);
  for (const fs::path& folder : {left, alive, other}) fs::create_directory(folder);

  const TemporaryFolder folder("caltwin_here", where.path());

  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(alive));
  EXPECT_TRUE(fs::exists(other));
}

}  // namespace
}  // namespace caltwin
