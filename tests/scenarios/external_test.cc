#include "scenarios/external.h"

#include <cerrno>
#include <chrono>
#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StrEq;

using How = ChildEnd::How;

// A machine that answers every line with itself, and refuses "G1".
class EchoLink final : public Link {
 public:
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    if (line == "G1") {
      return tl::unexpected(
          MachineFault{MachineFault::Kind::kRefused, "Error: not homed"});
    }
    return std::vector{"echo " + std::string(line)};
  }
};

class FixedGauge final : public Gauge {
 public:
  Expected<double> Read_mm(std::string_view id) override {
    if (id == "laser.x") return 12.5;
    return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, "no such gauge"});
  }
  Expected<void> Zero(std::string_view) override { return {}; }
};

class WatchedOperator final : public Operator {
 public:
  Expected<void> Do(const Act& act) override {
    last = act;
    return {};
  }
  Act last{};
};

struct Workshop {
  EchoLink link{};
  FixedGauge gauge{};
  WatchedOperator person{};
  Bench bench{};
  Workshop() {
    bench.link = &link;
    bench.gauge = &gauge;
    bench.person = &person;
    bench.artefacts = {{.id = "block"}};
  }
};

TEST(ExternalProtocol, GcodeGoesToTheMachine) {
  Workshop workshop;
  ExternalProtocol protocol(&workshop.bench);

  EXPECT_THAT(protocol.Answer("G28"), StrEq("echo G28\nok\n"));
  EXPECT_THAT(protocol.Answer("G1"), StrEq("Error: not homed\nok\n"));
  EXPECT_THAT(protocol.Answer("M118 hello"), StrEq("echo M118 hello\nok\n"));
  EXPECT_THAT(protocol.Answer(""), StrEq("ok\n"));
}

TEST(ExternalProtocol, GaugesAreReadById) {
  Workshop workshop;
  ExternalProtocol protocol(&workshop.bench);

  EXPECT_THAT(protocol.Answer("M118 GAUGE laser.x"),
              StrEq("gauge laser.x 12.5000000\nok\n"));
  EXPECT_THAT(protocol.Answer("M118 GAUGE scale.q"),
              StrEq("Error: no such gauge\nok\n"));
  EXPECT_THAT(protocol.Answer("M118 ZERO dial.x"), StrEq("ok\n"));
  EXPECT_THAT(protocol.Answer("M118 GAUGE"),
              StrEq("Error: M118 GAUGE takes one id, such as laser.x\nok\n"));
}

TEST(ExternalProtocol, ASentenceTurnsTheBlock) {
  Workshop workshop;
  ExternalProtocol protocol(&workshop.bench);

  EXPECT_THAT(protocol.Answer("M118 OPERATOR Turn the block: 50.8mm along Y"),
              StrEq("ok\n"));
  EXPECT_THAT(workshop.person.last.kind,
              Eq(Act::Kind::kOther));  // "block:" is no word.

  protocol.Answer("M118 OPERATOR Turn the block to 50.8mm along Y");
  EXPECT_THAT(workshop.person.last.kind, Eq(Act::Kind::kTurnBlock));
  EXPECT_THAT(workshop.person.last.artefact, StrEq("block"));
  EXPECT_THAT(workshop.person.last.axis, Eq('y'));
  EXPECT_THAT(workshop.person.last.length_mm, Eq(50.8));

  protocol.Answer("M118 OPERATOR fit the disc stylus");
  EXPECT_THAT(workshop.person.last.kind, Eq(Act::Kind::kFitStylus));

  protocol.Answer("M118 OPERATOR wipe the table");
  EXPECT_THAT(workshop.person.last.kind, Eq(Act::Kind::kOther));
  EXPECT_THAT(workshop.person.last.text, StrEq("wipe the table"));
}

TEST(ExternalProtocol, EstimatesAreTakenAndBadOnesRefused) {
  Workshop workshop;
  ExternalProtocol protocol(&workshop.bench);

  EXPECT_THAT(protocol.Answer("M118 ESTIMATE backlash.x 0.05 0.001"), StrEq("ok\n"));
  for (const char* bad : {"M118 ESTIMATE backlash.x 0.05",
                          "M118 ESTIMATE backlash.x nan 0.001",
                          "M118 ESTIMATE backlash.x 0.05 -1"}) {
    EXPECT_THAT(protocol.Answer(bad), HasSubstr("Error: M118 ESTIMATE takes")) << bad;
  }

  ASSERT_THAT(protocol.estimates(), SizeIs(1));
  EXPECT_THAT(protocol.estimates()[0].unit, StrEq("mm"));
  EXPECT_THAT(protocol.estimates()[0].sd, Eq(0.001));
}

ChildEnd Shell(const std::string& script,
               const AnswerLine& answer,
               std::chrono::milliseconds patience = std::chrono::seconds(20)) {
  return ConverseWith({.words = {"sh", "-c", script}, .patience = patience}, answer);
}

std::string Ok(std::string_view) {
  return "ok\n";
}

bool HasNoChildren() {
  return waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD;
}

TEST(ChildProcess, HearsAnswersToItsLines) {
  std::vector<std::string> heard;

  const ChildEnd end =
      Shell("echo one; read a; echo $a; read b; echo $b", [&](auto line) {
        heard.emplace_back(line);
        return fmt::format("answer{}\n", heard.size());
      });

  EXPECT_THAT(heard, ElementsAre("one", "answer1", "answer2"));
  EXPECT_THAT(ToString(end), StrEq("exited with 0"));
  EXPECT_TRUE(HasNoChildren());
}

TEST(ChildProcess, EndsWithItsExitCodeAndLastWords) {
  const ChildEnd end = Shell("echo sorry >&2; exit 3", Ok);

  EXPECT_THAT(ToString(end), StrEq("exited with 3"));
  EXPECT_THAT(end.last_words, StrEq("sorry\n"));
}

TEST(ChildProcess, IsEndedWhenItsTimeIsOver) {
  const ChildEnd end = Shell("sleep 60", Ok, std::chrono::milliseconds(30));

  EXPECT_THAT(end.how, Eq(How::kTimedOut));
  EXPECT_TRUE(HasNoChildren());
}

TEST(ChildProcess, ThatCannotBeStartedSaysWhy) {
  const ChildEnd end = ConverseWith({.words = {"/no/such/program"}}, Ok);

  EXPECT_THAT(ToString(end), StrEq("could not be started: No such file or directory"));
}

// 660 kB one way and the same back, ten times what a pipe holds, and read only then.
TEST(ChildProcess, ThatReadsLateNeitherBlocksNorDies) {
  int lines = 0;

  const ChildEnd end = Shell(
      "yes aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa | head -n 20000; head -n 20000 >/dev/null",
      [&](auto) {
        ++lines;
        return std::string(32, 'b') + "\n";
      });

  EXPECT_THAT(lines, Eq(20000));
  EXPECT_THAT(end.how, Eq(How::kExited));
}

TEST(ChildProcess, ThatClosesItsInputLosesTheAnswersOnly) {
  const ChildEnd end =
      Shell("exec <&-; i=0; while [ $i -lt 50 ]; do echo line; i=$((i+1)); done", Ok);

  EXPECT_THAT(ToString(end), StrEq("exited with 0"));
}

TEST(ChildProcess, ThatLeavesAnotherBehindDoesNotHoldUsUp) {
  const ChildEnd end = Shell("sleep 60 & exit 0", Ok, std::chrono::seconds(20));

  EXPECT_THAT(ToString(end), StrEq("exited with 0"));
}

TEST(ChildProcess, RunsInTheFolderAskedFor) {
  std::string heard;

  ConverseWith({.words = {"pwd", "-P"}, .folder = "/usr"}, [&](auto line) {
    heard = line;
    return std::string();
  });

  EXPECT_THAT(heard, StrEq("/usr"));
}

}  // namespace
}  // namespace caltwin
