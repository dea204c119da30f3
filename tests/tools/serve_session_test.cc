#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/commands/serve/session.h"

namespace caltwin {
namespace {

using testing::ElementsAre;

/// Answers every line with itself, but "bad" with a refusal.
class EchoLink : public Link {
 public:
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    if (line == "M1") {
      return tl::make_unexpected(MachineFault{.reply = "Error: no\nat all"});
    }
    return std::vector<std::string>{std::string(line)};
  }
};

TEST(ServeSession, EveryLineGetsItsOk) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("G28 X"), ElementsAre("G28 X", "ok"));
  EXPECT_THAT(session.Answer("M1"), ElementsAre("Error: no", "at all", "ok"));
}

TEST(ServeSession, NumbersAndChecksumsAreTakenOff) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("N0 M110 N0*125"), ElementsAre("ok"));
  EXPECT_THAT(session.Answer("N1 G28*18"), ElementsAre("G28", "ok"));
}

TEST(ServeSession, LineNumberIsSetWithoutBeingNumbered) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("M110 N5"), ElementsAre("ok"));
  EXPECT_THAT(session.Answer("N6 G28*21"), ElementsAre("G28", "ok"));
}

// What words mean is the controller's affair: RepRapFirmware has lists.
TEST(ServeSession, WordsAreNotRead) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("M584 Z0:1:2 P3"), ElementsAre("M584 Z0:1:2 P3", "ok"));
  EXPECT_THAT(session.Answer("N1 M584 Z0:1:2 P3*33"),
              ElementsAre("M584 Z0:1:2 P3", "ok"));
}

TEST(ServeSession, DamagedLineIsAskedForAgain) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("N1 G29*18"),
              ElementsAre("Error:checksum mismatch, Last Line: 0", "Resend: 1", "ok"));
  EXPECT_THAT(session.Answer("N3 G28*16"),
              ElementsAre("Error:Line Number is not Last Line Number+1, Last Line: 0",
                          "Resend: 1",
                          "ok"));
  EXPECT_THAT(session.Answer("N1 G28*18"), ElementsAre("G28", "ok"));
}

TEST(ServeSession, NoiseIsAnswered) {
  EchoLink link;
  ServeSession session(&link);

  EXPECT_THAT(session.Answer("\x02\x03"),
              ElementsAre(testing::HasSubstr("begins no word"), "ok"));
}

}  // namespace
}  // namespace caltwin
