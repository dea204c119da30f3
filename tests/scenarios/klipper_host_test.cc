#include <filesystem>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "scenarios/klipper/host_api.h"
#include "scenarios/klipper/host_process.h"
#include "scenarios/scenario.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/measure/import/printer_cfg_text.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A host's API socket of which the test is the other end.
class Api : public testing::Test {
 protected:
  Api() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    listener_ = socket(AF_UNIX, SOCK_STREAM, 0);
    if (listener_ < 0) throw std::runtime_error("there are no sockets");
    const auto* const where = reinterpret_cast<const sockaddr*>(&address);
    EXPECT_EQ(bind(listener_, where, sizeof address), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    EXPECT_TRUE(api_.Open());
    host_ = accept(listener_, nullptr, nullptr);
  }
  ~Api() override {
    close(host_);
    close(listener_);
  }
  void Say(const std::string& text) const {
    EXPECT_EQ(write(host_, text.data(), text.size()),
              static_cast<ssize_t>(text.size()));
  }

  TempFolder folder_{};
  std::filesystem::path path_ = folder_ / "api";
  HostApi api_{path_};
  int listener_ = -1, host_ = -1;
};

TEST_F(Api, AnswersComeByTheirNumbersAndInAnyPieces) {
  const int first = api_.Ask("info", nlohmann::json::object());
  const int second = api_.Ask("gcode/script", {{"script", "G28"}});
  Say("{\"id\": 2, \"result\": {}}\x03{\"id\": 1, \"resu");
  api_.Receive();
  EXPECT_FALSE(api_.TakeAnswer(first));
  EXPECT_TRUE(api_.TakeAnswer(second));
  EXPECT_FALSE(api_.TakeAnswer(second));
  Say("lt\": {\"state\": \"ready\"}}\x03");
  api_.Receive();
  const auto answer = api_.TakeAnswer(first);
  ASSERT_TRUE(answer);
  EXPECT_EQ((*answer)["result"]["state"], "ready");
}

TEST_F(Api, WhatIsPrintedIsKeptAndWhatIsNoMessageIsNot) {
  Say("{\"params\": {\"response\": \"// hello\"}}\x03no json\x03[1]\x03"
      "{\"id\": \"text\"}\x03{\"params\": 3}\x03{\"params\": {\"response\": 4}}\x03");
  api_.Receive();
  EXPECT_THAT(api_.TakePrinted(), ElementsAre("// hello"));
  EXPECT_THAT(api_.TakePrinted(), ElementsAre());
}

TEST_F(Api, ThatTheHostHasClosedIsNoticed) {
  EXPECT_TRUE(api_.is_open());
  shutdown(host_, SHUT_RDWR);
  api_.Receive();
  EXPECT_FALSE(api_.is_open());
}

std::string MessageOf(const std::string& scenario) {
  try {
    ReadScenarioText(scenario, "test.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ControllerKey, StandsInPlaceOfCalibrate) {
  const std::string machine = "machine: delta_printer\nfidelity: fast\n";
  EXPECT_EQ(MessageOf(machine + "controller: {klipper: {gcode: [G28]}}\n"), "");
  EXPECT_THAT(MessageOf(machine + "controller: {klipper: {gcode: [G28]}}\n"
                                  "calibrate: [g33]\n"),
              HasSubstr("test.yaml:4:12: calibrate stands beside `controller`"));
  EXPECT_THAT(MessageOf(machine + "controller: {klipper: {gcode: []}}\n"),
              HasSubstr("says nothing"));
  EXPECT_THAT(MessageOf(machine + "controller: {klipper: {}}\n"), HasSubstr("gcode"));
  EXPECT_THAT(
      MessageOf(machine + "controller: {klipper: {gcode: [G28], config: no.cfg}}"),
      HasSubstr("there is no file no.cfg"));
  EXPECT_THAT(
      MessageOf("machine: motor_stage\ncontroller: {klipper: {gcode: [G28]}}\n"),
      HasSubstr("cannot yet be driven by Klipper's host"));
}

TEST(ControllerKey, APersonStandsAmongTheLines) {
  const std::string machine = "machine: delta_printer\nfidelity: fast\n";
  EXPECT_EQ(MessageOf(machine + "controller: {klipper: {gcode: [G28, {person: "
                                "feeler_gauge}]}}\n"),
            "");
  EXPECT_THAT(
      MessageOf(machine + "controller: {klipper: {gcode: [{person: juggles}]}}\n"),
      testing::AllOf(HasSubstr("juggles"), HasSubstr("paper_test")));
  EXPECT_THAT(MessageOf("machine: gantry_router\nfidelity: fast\ncontroller: {klipper: "
                        "{gcode: [{person: measured_print}]}}\n"),
              testing::AllOf(HasSubstr("measured_print"), HasSubstr("feeler_gauge")));
}

TEST(ConfigText, LinesAreAddedBeforeWhatWasSaved) {
  EXPECT_EQ(WithAdded("[a]\nb: 1\n#*# <--- SAVE_CONFIG --->\n#*# [a]\n", "[c]\nd: 2\n"),
            "[a]\nb: 1\n[c]\nd: 2\n\n#*# <--- SAVE_CONFIG --->\n#*# [a]\n");
  EXPECT_EQ(WithAdded("[a]", "[c]\n"), "[a]\n[c]\n");
}

TEST(ConfigText, IncludedFilesStandWhereTheyAreNamed) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "parts");
  WriteTextFile(folder / "parts/a.cfg", "[a]\n[include b.cfg]\n");
  WriteTextFile(folder / "parts/b.cfg", "[b]\n[include ../printer.cfg]\n");
  WriteTextFile(folder / "printer.cfg", "[include parts/*.cfg]\n");
  EXPECT_EQ(WithIncluded("[x]\n[include parts/*.cfg]\n[include none.cfg]\n[y]\n",
                         folder.path()),
            "[x]\n[a]\n[b]\n[include none.cfg]\n[y]\n");
}

TEST(ConfigText, AComplaintHasTheLineOfWhatItNames) {
  const std::string config = "[mcu]\nserial: x\n[stepper_x]\nbad: 1\n";
  EXPECT_EQ(
      PlaceOfComplaint("Option 'bad' is not valid in section 'stepper_x'", config, "p")
          .line,
      4);
  EXPECT_EQ(
      PlaceOfComplaint("Section 'stepper_x' is not a valid config section", config, "p")
          .line,
      3);
  EXPECT_EQ(
      PlaceOfComplaint("Option 'a' in section 'none' must be specified", config, "p")
          .line,
      Place{}.line);
  EXPECT_EQ(PlaceOfComplaint("Internal error", config, "p").line, Place{}.line);
}

TEST(HostProgram, ThatIsNotThereIsSaidSo) {
  EXPECT_THROW(HostProgram("/no/such/host"), InputError);
}

}  // namespace
}  // namespace caltwin
