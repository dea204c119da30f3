#include "sim/controllers/linuxcnc/plant_page.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/base/temporary_folder.h"
#include "tests/linuxcnc/fake_board.h"

namespace caltwin {
namespace linuxcnc {
namespace {

using std::chrono::milliseconds;

// The component's side, as component/caltwin.comp has it.
class Component {
 public:
  explicit Component(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CLOEXEC);
    page_ = static_cast<CaltwinPage*>(mmap(
        nullptr, kCaltwinPageBytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0));
    close(descriptor);
  }
  ~Component() { munmap(page_, kCaltwinPageBytes); }
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  void Ask(double u_steps) {
    page_->commanded_steps[0] = u_steps;
    page_->asked += 1;
  }
  bool is_answered() const { return page_->asked == page_->answered; }
  CaltwinPage* page() { return page_; }

 private:
  CaltwinPage* page_ = nullptr;
};

class LinuxCncPage : public testing::Test {
 protected:
  std::unique_ptr<PlantPage> Twin() {
    return std::make_unique<PlantPage>(file_, &joints_, milliseconds(5000));
  }
  TemporaryFolder folder_{"caltwin_page_test"};
  std::filesystem::path file_ = folder_.path() / "page";
  FakeBoard board_{};
  Joints joints_{&board_};
};

TEST_F(LinuxCncPage, ACycleIsAnsweredWithWhatTheMotorsDid) {
  const auto twin = Twin();
  Component component(file_);
  component.Ask(50.25);
  ASSERT_TRUE(twin->Turn(milliseconds(0)));
  EXPECT_TRUE(component.is_answered());
  EXPECT_EQ(component.page()->feedback_steps[0], 50.25);
  EXPECT_EQ(component.page()->has_met, 1U);
  EXPECT_EQ(joints_.steps()[0], 50);
}

TEST_F(LinuxCncPage, WithoutAQuestionNothingIsAnswered) {
  const auto twin = Twin();
  EXPECT_FALSE(twin->Turn(milliseconds(1)));
  EXPECT_TRUE(board_.followed.empty());
}

TEST_F(LinuxCncPage, ACommandThatIsNoPlaceLeavesTheMotorWhereItIs) {
  const auto twin = Twin();
  Component component(file_);
  component.Ask(7);
  twin->Turn(milliseconds(0));
  for (const double wild : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300}) {
    component.Ask(wild);
    ASSERT_TRUE(twin->Turn(milliseconds(0)));
    EXPECT_EQ(component.page()->feedback_steps[0], 7);
  }
}

TEST_F(LinuxCncPage, OneMachineAPage) {
  const auto twin = Twin();
  try {
    Twin();
    FAIL() << "a second twin took the page";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("another caltwin serves a machine"));
  }
  Component component(file_);
  EXPECT_EQ(component.page()->is_served, 1U);
}

TEST_F(LinuxCncPage, TheComponentLearnsThatTheTwinHasEndedAndThePageIsGone) {
  auto twin = Twin();
  Component component(file_);
  twin.reset();
  EXPECT_EQ(component.page()->is_served, 0U);
  EXPECT_FALSE(std::filesystem::exists(file_));
}

// A twin that was killed leaves its page, with a LinuxCNC that still waits on it.
TEST_F(LinuxCncPage, WhatAKilledTwinWasAskedTheNextOneAnswers) {
  const std::filesystem::path copy = folder_.path() / "copy";
  {
    const auto killed = Twin();
    Component(file_).Ask(30);
    std::filesystem::copy_file(file_, copy);
  }
  std::filesystem::rename(copy, file_);
  Component component(file_);
  ASSERT_FALSE(component.is_answered());
  const auto twin = Twin();
  EXPECT_TRUE(twin->Turn(milliseconds(0)));
  EXPECT_TRUE(component.is_answered());
  EXPECT_EQ(joints_.steps()[0], 30);
}

TEST_F(LinuxCncPage, AnOtherFileIsNoPageAndBecomesOne) {
  std::ofstream(file_) << std::string(5000, 'x');
  const auto twin = Twin();
  Component component(file_);
  EXPECT_EQ(component.page()->asked, 0U);
  EXPECT_EQ(component.page()->magic, static_cast<std::uint32_t>(kCaltwinPageMagic));
}

}  // namespace
}  // namespace linuxcnc
}  // namespace caltwin
