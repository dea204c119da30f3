// Whether the server that began a study is still there.

#include "tools/commands/api/own_program.h"

#include <csignal>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace caltwin {
namespace {

TEST(IsAnotherAlive, IsOnlyOneOfThisProgramThatRuns) {
  EXPECT_FALSE(IsAnotherAlive(0));
  EXPECT_FALSE(IsAnotherAlive(getpid()));
  EXPECT_FALSE(IsAnotherAlive(1)) << "init is another program";
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    pause();
    _exit(0);
  }
  EXPECT_TRUE(IsAnotherAlive(child));
  // Ended, and not waited for yet: its number is there, it is not.
  ASSERT_EQ(kill(child, SIGKILL), 0);
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_FALSE(IsAnotherAlive(child));
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
}

}  // namespace
}  // namespace caltwin
