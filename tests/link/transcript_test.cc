#include "sim/link/transcript.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/link/open_link.h"
#include "sim/link/reply.h"

namespace caltwin {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class TranscriptTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }

  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() /
      ("caltwin_transcript_" + std::to_string(getpid()) + ".txt");
};

/// Answers by what is asked of it.
class MoodyLink : public Link {
 public:
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    if (line == "M114") return std::vector<std::string>{"X:1 Count 800", "second"};
    if (line == "G38.2 X9") {
      return JudgeReply({"Error: Probe was not triggered during probing move"});
    }
    if (line == "G4 S9") {
      return tl::make_unexpected(
          MachineFault{.kind = MachineFault::Kind::kTimeout, .reply = "no ok in time"});
    }
    return std::vector<std::string>{};
  }
};

TEST_F(TranscriptTest, RecordingReplaysTheSameConversation) {
  MoodyLink machine;
  {
    RecordingLink recording(&machine, file_);
    for (const char* line : {"G28", "M114", "G38.2 X9", "G4 S9"}) {
      recording.Send(line, seconds(1));
    }
  }

  TranscriptLink replay(file_);
  for (const char* line : {"G28", "M114", "G38.2 X9", "G4 S9"}) {
    const auto expected = machine.Send(line, seconds(1));
    const auto got = replay.Send(line, seconds(1));
    ASSERT_EQ(got.has_value(), expected.has_value()) << line;
    if (expected) {
      EXPECT_EQ(*got, *expected);
    } else {
      EXPECT_EQ(got.error().kind, expected.error().kind);
      EXPECT_EQ(got.error().reply, expected.error().reply);
    }
  }
  EXPECT_TRUE(replay.finished());
}

TEST_F(TranscriptTest, LineThatDiffersIsRefusedWithItsPlace) {
  WriteTextFile(file_, "# by hand\n> G28\n> M114\n< X:1\n");
  TranscriptLink replay(file_);
  EXPECT_TRUE(replay.Send("G28", seconds(1)).has_value());

  const auto reply = replay.Send("M115", seconds(1));

  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kLinkLost);
  EXPECT_EQ(reply.error().reply,
            file_.string() + ":3: the transcript has 'M114', 'M115' was sent");
  // From there on it knows nothing, not even what it has recorded.
  EXPECT_FALSE(replay.Send("M114", seconds(1)).has_value());
}

TEST_F(TranscriptTest, EndOfTheTranscriptIsSaid) {
  WriteTextFile(file_, "> G28\n");
  TranscriptLink replay(file_);
  EXPECT_THAT(*replay.Send("G28", seconds(1)), IsEmpty());

  const auto reply = replay.Send("M114", seconds(1));

  ASSERT_FALSE(reply.has_value());
  EXPECT_THAT(reply.error().reply, HasSubstr("at its end"));
}

TEST_F(TranscriptTest, FileThatIsNoTranscriptIsRefused) {
  WriteTextFile(file_, "> G28\nhello\n");
  EXPECT_THROW(TranscriptLink{file_}, InputError);
  WriteTextFile(file_, "< reply first\n");
  EXPECT_THROW(TranscriptLink{file_}, InputError);
  WriteTextFile(file_, "# nothing\n");
  EXPECT_THROW(TranscriptLink{file_}, InputError);
  EXPECT_THROW(TranscriptLink{"/nowhere/at/all"}, InputError);
}

TEST_F(TranscriptTest, OpensByItsUrl) {
  WriteTextFile(file_, "> M115\n< FIRMWARE_NAME: x\n");

  const auto link = OpenLink("transcript:" + file_.string());

  EXPECT_THAT(*link->Send("M115", seconds(1)), ElementsAre("FIRMWARE_NAME: x"));
}

TEST(OpenLink, WrongUrlsAreInputErrors) {
  for (const char* url : {"",
                          "G28",
                          "twin:a.yaml",
                          "tcp:",
                          "tcp:localhost",
                          "tcp:localhost:http",
                          "tcp:localhost:0",
                          "tcp:localhost:99999",
                          "tcp::80",
                          "serial:",
                          "serial:/dev/null",
                          "serial:/dev/null?baud=fast",
                          "serial:/dev/null?baud=12345",
                          "serial:/dev/no_such_device",
                          "transcript:/no/such/file"}) {
    EXPECT_THROW(OpenLink(url), InputError) << url;
  }
}

TEST(JudgeReply, WordsDecideWhatAFaultIs) {
  const auto kind = [](std::vector<std::string> lines) {
    return JudgeReply(std::move(lines)).error().kind;
  };
  using Kind = MachineFault::Kind;

  EXPECT_TRUE(JudgeReply({"X:1", "Warning: M1: Command is not supported"}).has_value());
  EXPECT_EQ(kind({"Error: G0/G1: insufficient axes homed"}), Kind::kRefused);
  EXPECT_EQ(kind({"Error: Probe was not triggered during probing move"}),
            Kind::kNoTrigger);
  EXPECT_EQ(kind({"Error: Probe did not lose contact during probing move"}),
            Kind::kNoTrigger);
  EXPECT_EQ(kind({"Error: Probe already triggered before probing move started"}),
            Kind::kRefused);
  EXPECT_EQ(kind({"Emergency Stop! Reset the controller to continue."}), Kind::kAlarm);
  EXPECT_EQ(JudgeReply({"before", "Error: a", "after"}).error().reply,
            "Error: a\nafter");
}

}  // namespace
}  // namespace caltwin
