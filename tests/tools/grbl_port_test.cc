#include "tools/commands/serve/grbl_port.h"

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/rigid_plant.h"

namespace caltwin {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A grbl served to one client, who hears all of it.
class Served {
 public:
  explicit Served(double speed)
      : pace_(speed),
        paced_(&plant_, &pace_),
        grbl_(machine_, machine_.settings, &paced_, &pace_, Motors::Zero(3)),
        served_(&grbl_, &pace_),
        port_(served_.ports()([this](std::string_view bytes) {
          const std::lock_guard<std::mutex> lock(mutex_);
          heard_ += bytes;
        })) {}

  /// Sends and waits until the answer has that in it; what was heard since the last.
  std::string Say(const std::string& bytes, const std::string& until) {
    port_->Hear(bytes);
    for (int i = 0; i < 3000; ++i) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (heard_.find(until) != std::string::npos) return std::exchange(heard_, {});
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(heard_, {}) + "(waited for " + until + " in vain)";
  }
  /// Sends and asks until the state is that.
  void SayAndWaitFor(const std::string& bytes, const std::string& state) {
    port_->Hear(bytes);
    for (int i = 0; i < 1000 && Status().find(state) == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  std::string Status() { return Say("?", ">"); }

 private:
  Machine machine_ = TestMachine();
  RigidPlant plant_{machine_};
  Pace pace_;
  PacedPlant paced_;
  grbl::Controller grbl_;
  std::mutex mutex_{};
  std::string heard_{};
  GrblMachine served_;
  std::unique_ptr<Port> port_;
};

// Found by an independent review.
TEST(GrblPort, AnswersWhileAMoveGoesOn) {
  Served served(/*speed=*/10);
  served.Say("$H\n", "ok");
  served.Say("G90 G1 X-100 F2400\n", "ok");  // Half a second of ours.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_THAT(served.Say("$G\n", "ok"), HasSubstr("[GC:G1"));
  EXPECT_THAT(served.Say("$$\n", "error:"), HasSubstr("error:8"));
  EXPECT_THAT(served.Say("G1 Y-200\n", "ok"), HasSubstr("ok"));
  EXPECT_THAT(served.Status(), HasSubstr("<Run|"));
}

// Lines behind one that waits for moves do not overtake it.
TEST(GrblPort, LinesKeepTheirOrder) {
  Served served(/*speed=*/20);
  served.Say("$H\n", "ok");
  const std::string said = served.Say(
      "G90 G1 X-250 F2400\nG38.3 Z-10 F1200\nG1 X-280 F2400\n$I\nM2\n", "Pgm End");
  // Probed where the first move ended, x -250, and not on the way to the third.
  EXPECT_THAT(said, HasSubstr("[PRB:-250.000,-298.000,-10.000:0]"));
  EXPECT_LT(said.find("PRB"), said.find("Pgm End"));
  EXPECT_THAT(served.Status(), HasSubstr("MPos:-280.000,-298.000,-10.000"));
}

TEST(GrblPort, LinesBehindHomingWaitForIt) {
  Served served(/*speed=*/20);
  const std::string said = served.Say("$H\nG0X-10\nM2\n", "Pgm End");
  EXPECT_THAT(said, Not(HasSubstr("error")));
  EXPECT_THAT(said, Not(HasSubstr("ALARM")));
}

TEST(GrblPort, JogCancelEndsTheJogsBehindItToo) {
  Served served(/*speed=*/10);
  served.Say("$H\n", "ok");
  served.Say("$J=G91X20F600\n", "ok");
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  served.Say("$J=G91X20F600\n", "ok");
  EXPECT_THAT(served.Say("G0X-1\n", "error:"), HasSubstr("error:9"));
  EXPECT_THAT(served.Status(), HasSubstr("<Jog|"));
  served.Say("\x85?", ">");
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  const std::string at = served.Status();
  EXPECT_THAT(at, HasSubstr("<Idle|"));
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ(served.Status().substr(0, 30), at.substr(0, 30));
}

TEST(GrblPort, ObeysNoLineWhileItIsHeld) {
  Served served(/*speed=*/10);
  served.Say("$H\n", "ok");
  EXPECT_THAT(served.Say("!?", ">"), HasSubstr("<Hold:0|"));
  EXPECT_THAT(served.Say("G10L20P1X0\n?", ">"), Not(HasSubstr("ok")));
  EXPECT_THAT(served.Say("~", "ok"), HasSubstr("ok"));
}

TEST(GrblPort, ResetWhileItHomesLocksEvenIfHeld) {
  Served served(/*speed=*/1);
  served.Say("$X\n", "ok");
  served.SayAndWaitFor("$H\n", "<Home|");
  served.Say("!?", ">");
  EXPECT_THAT(served.Say("\x18", "unlock]"), HasSubstr("ALARM:6"));
  EXPECT_THAT(served.Status(), HasSubstr("<Alarm|"));
}

TEST(GrblPort, EndsWhileItIsHeld) {
  Served served(/*speed=*/1);
  served.SayAndWaitFor("$H\n", "<Home|");
  served.Say("!?", ">");
}

}  // namespace
}  // namespace caltwin
