#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/calibrate.h"
#include "calibration/kinds/delta/link_probe.h"
#include "calibration/kinds/delta/settings.h"
#include "scenarios/kinds/delta_g33.h"
#include "scenarios/machine_file.h"
#include "sim/kinds/delta/twin.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::StrEq;

const Machine& Drawn() {
  static const Machine machine =
      ReadAnyMachineFile(CALTWIN_SOURCE_DIR "/models/delta_printer/machine.yaml")
          .machine;
  return machine;
}

/// Passes lines on to a twin and keeps them; falls silent at a line that begins so.
class HeardLink : public Link {
 public:
  explicit HeardLink(Link* inner, std::string silent_at = "nothing")
      : inner_(inner), silent_at_(std::move(silent_at)) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    heard.emplace_back(line);
    if (line.starts_with(silent_at_)) {
      return tl::unexpected(MachineFault{MachineFault::Kind::kLinkLost, "silence"});
    }
    return inner_->Send(line, patience);
  }
  std::vector<std::string> heard{};

 private:
  Link* inner_;
  std::string silent_at_;
};

/// Answers every line alike.
class ParrotLink : public Link {
 public:
  explicit ParrotLink(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      answer_.push_back("echo:  " + line);
  }
  Expected<std::vector<std::string>> Send(std::string_view,
                                          std::chrono::milliseconds) override {
    return answer_;
  }

 private:
  std::vector<std::string> answer_{};
};

class Person : public Operator {
 public:
  explicit Person(bool agrees) : agrees_(agrees) {}
  Expected<void> Do(const Act&) override {
    if (agrees_) return {};
    return tl::unexpected(MachineFault{MachineFault::Kind::kRefused, "no"});
  }

 private:
  bool agrees_;
};

// A machine that three rods of one length hold, in closed form.
DeltaTwinConfig Crooked() {
  DeltaTwinConfig config{.machine = Drawn(),
                         .settings = DeltaOf(Drawn()).settings,
                         .fidelity = Fidelity::kFast};
  config.built.build = DeltaOf(Drawn()).Build();
  config.built.bed.radius_mm = DeltaOf(Drawn()).print_radius_mm;
  config.built.build.model.endstop_mm[0] += 0.3;
  config.built.build.model.endstop_mm[1] -= 0.2;
  for (double& radius_mm : config.built.build.model.radius_mm) radius_mm += 0.5;
  return config;
}

/// With a G33 in its controller.
class ServedDelta : public DeltaTwin {
 public:
  explicit ServedDelta(const DeltaTwinConfig& config) : DeltaTwin(config) {
    SetG33(MarlinG33(G33Variant::kCorrected, DeltaOf(config.machine).print_radius_mm));
  }
};

const DeltaStep kJoint = {
    .name = "delta_joint", .points = 37, .knobs = FirmwareKnobs()};
const DeltaStep kG33 = {.name = "g33", .points = 4, .words = " V1 T"};

ProcedureResult Calibrated(const DeltaStep& step,
                           bool agrees,
                           DeltaTwin* twin,
                           HeardLink* link) {
  Person person(agrees);
  return CalibrateDelta(step,
                        {.link = link,
                         .person = &person,
                         .calliper = CalliperOf(twin),
                         .machine = Drawn()});
}

// The largest error of the nozzle's height on the bed, commanded to 0.
double HeightError_mm(const DeltaTwin& twin) {
  const double radius_mm = DeltaOf(Drawn()).print_radius_mm;
  double most_mm = 0;
  for (const Eigen::Vector2d& at : DiscPoints(60, radius_mm)) {
    const Vec3<double> motors_mm =
        DeltaMotors_mm<double>(twin.marlin().settings(), {at[0], at[1], 0});
    const auto pose = DeltaPoseOf(twin.config().built.build, motors_mm);
    most_mm = std::max(most_mm, std::abs(pose.value().nozzle_mm[2]));
  }
  return most_mm;
}

TEST(BelievedDelta, IsReadFromWhatMarlinIsSent) {
  DeltaModel<double> settings = DeltaOf(Drawn()).model;
  settings.endstop_mm = {300.25, 299.5, 300.125};
  settings.radius_mm.fill(130.75);
  settings.arm_mm = {250.5, 250.25, 250};
  settings.angle_rad[0] += 0.01;
  settings.angle_rad[1] -= 0.02;
  ParrotLink link(AsMarlin(settings, DeltaOf(Drawn()).model) +
                  "M851 X15.00 Y0.00 Z-1.70");

  const BelievedDelta read = ReadBelievedDelta(&link, DeltaOf(Drawn()).model).value();

  constexpr double kPrinted = 1e-4;  // Four decimals, and two of them add up.
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(read.settings.endstop_mm[i], settings.endstop_mm[i], kPrinted);
    EXPECT_NEAR(read.settings.radius_mm[i], settings.radius_mm[i], kPrinted);
    EXPECT_NEAR(read.settings.arm_mm[i], settings.arm_mm[i], kPrinted);
    EXPECT_NEAR(read.settings.angle_rad[i], settings.angle_rad[i], kPrinted);
  }
  EXPECT_EQ(read.probe_offset_mm, Vec3<double>(15, 0, -1.7));
}

TEST(BelievedDelta, AnotherFirmwareIsRefusedWithAReason) {
  ParrotLink link("M92 X80.00");

  EXPECT_THAT(ReadBelievedDelta(&link, DeltaOf(Drawn()).model).error().reply,
              StrEq("M503 was answered without M665 and M666: a delta is calibrated in "
                    "Marlin's dialect"));
}

TEST(DeltaCalibration, MakesTheBedFlatOverTheWire) {
  ServedDelta twin(Crooked());
  HeardLink link(&twin.link());
  const double before_mm = HeightError_mm(twin);

  const ProcedureResult result = Calibrated(kJoint, /*agrees=*/true, &twin, &link);

  constexpr double kStep_mm = 0.0125;  // What a trigger is counted in.
  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_EQ(result.touches, 37);
  EXPECT_GT(before_mm, 0.2);
  EXPECT_LT(HeightError_mm(twin), kStep_mm / 2);
  EXPECT_THAT(link.heard.back(), StrEq("M500"));
}

TEST(DeltaCalibration, WithoutConsentNoSettingIsSent) {
  ServedDelta twin(Crooked()), applied(Crooked());
  HeardLink link(&twin.link()), other(&applied.link());

  const ProcedureResult refused = Calibrated(kJoint, /*agrees=*/false, &twin, &link);
  const ProcedureResult done = Calibrated(kJoint, /*agrees=*/true, &applied, &other);

  EXPECT_EQ(refused.ending, Ending::kRefused);
  EXPECT_THAT(link.heard, Each(Not(StartsWith("M6"))));
  EXPECT_THAT(link.heard, Not(Contains("M500")));
  ASSERT_EQ(refused.steps.size(), done.steps.size());
  for (std::size_t i = 0; i < done.steps.size(); ++i) {
    EXPECT_EQ(refused.steps[i].verdict, Verdict::kRefused);
    EXPECT_EQ(done.steps[i].verdict, Verdict::kApplied);
    EXPECT_EQ(refused.steps[i].after, done.steps[i].after);
  }
}

TEST(DeltaCalibration, G33RunsDryWithoutConsent) {
  ServedDelta twin(Crooked());
  HeardLink link(&twin.link());
  const auto before = twin.marlin().settings();

  const ProcedureResult result = Calibrated(kG33, /*agrees=*/false, &twin, &link);

  EXPECT_EQ(result.ending, Ending::kRefused);
  EXPECT_THAT(link.heard, Contains("G33 P4 T V0"));
  EXPECT_EQ(twin.marlin().settings().endstop_mm, before.endstop_mm);
}

TEST(DeltaCalibration, G33TellsWhatItSet) {
  ServedDelta twin(Crooked());
  HeardLink link(&twin.link());

  const ProcedureResult result =
      Calibrated({.name = "g33", .points = 4}, /*agrees=*/true, &twin, &link);

  constexpr double kPrinted_mm = 1e-4;
  EXPECT_EQ(result.ending, Ending::kDone);
  const auto step = std::ranges::find(result.steps, "delta_radius", &Step::name);
  ASSERT_NE(step, result.steps.end());
  EXPECT_NEAR(step->after, twin.marlin().settings().radius_mm[0], kPrinted_mm);
  EXPECT_NEAR(step->before, DeltaOf(Drawn()).settings.radius_mm[0], kPrinted_mm);
}

TEST(DeltaCalibration, ALostLinkSetsNothing) {
  ServedDelta twin(Crooked());
  HeardLink link(&twin.link(), "G30 X-");
  const auto before = twin.marlin().settings();

  const ProcedureResult result = Calibrated(kJoint, /*agrees=*/true, &twin, &link);

  EXPECT_EQ(result.ending, Ending::kLinkLost);
  EXPECT_THAT(result.fault, HasSubstr("silence"));
  EXPECT_EQ(twin.marlin().settings().endstop_mm, before.endstop_mm);
}

TEST(DeltaCalibration, ARodThatNobodyReadSetsNothing) {
  ServedDelta twin(Crooked());
  HeardLink link(&twin.link());
  Person person(/*agrees=*/true);
  DeltaStep step = kJoint;
  step.reads_rods = true;

  const ProcedureResult result = CalibrateDelta(step,
                                                {.link = &link,
                                                 .person = &person,
                                                 .calliper = {.rod_mm =
                                                                  [](int) {
                                                                    return std::nullopt;
                                                                  }},
                                                 .machine = Drawn()});

  EXPECT_EQ(result.ending, Ending::kRefused);
  EXPECT_THAT(result.fault,
              StrEq("6 readings of the calliper were not given; nothing is set"));
  EXPECT_THAT(link.heard, Not(Contains("M500")));
}

TEST(DeltaCalibration, EveryTouchIsWrittenDown) {
  ServedDelta twin(Crooked());
  Person person(/*agrees=*/false);
  DeltaRecord record;

  CalibrateDelta(
      kJoint,
      {.link = &twin.link(), .person = &person, .machine = Drawn(), .record = &record});

  ASSERT_EQ(record.rows.rows.size(), 37U);
  ASSERT_EQ(twin.record().rows.rows.size(), 37U);
  constexpr double kPrinted_mm = 5.1e-4;  // G30 answers to the micrometre.
  for (std::size_t i = 0; i < 37; ++i) {
    EXPECT_NEAR(
        record.rows.rows[i].value_mm, twin.record().rows.rows[i].value_mm, kPrinted_mm);
  }
}

}  // namespace
}  // namespace caltwin
