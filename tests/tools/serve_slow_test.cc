#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "calibration/kinds/delta/calibrate.h"
#include "scenarios/machine_file.h"
#include "sim/base/input_error.h"
#include "sim/kinds/delta/twin.h"
#include "sim/link/open_link.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "tools/commands/serve/serve.h"

namespace caltwin {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;

class CountingLink : public Link {
 public:
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    if (line == "M112") {
      return tl::make_unexpected(
          MachineFault{.kind = MachineFault::Kind::kAlarm, .reply = "Emergency Stop!"});
    }
    return std::vector<std::string>{std::string(line), std::to_string(++count_)};
  }

 private:
  int count_ = 0;
};

/// A server in a thread of its own, stopped and joined at the end of the test.
class TcpServer {
 public:
  TcpServer() {
    std::promise<int> port;
    std::future<int> known = port.get_future();
    thread_ = std::thread([this, &port] {
      ServeTcp(
          PortsOf(&link_), 0, &stop_, [&port](int number) { port.set_value(number); });
    });
    port_ = known.get();
  }
  ~TcpServer() {
    stop_ = true;
    thread_.join();
  }
  int port() const { return port_; }

 private:
  CountingLink link_;
  std::atomic<bool> stop_ = false;
  int port_ = 0;
  std::thread thread_;
};

TEST(ServeTcp, ClientsTalkToTheMachineOneAfterTheOther) {
  TcpServer server;
  for (const char* const count : {"1", "2"}) {
    const auto link = OpenLink("tcp:127.0.0.1:" + std::to_string(server.port()));
    const auto reply = link->Send("G28", seconds(5));
    ASSERT_TRUE(reply.has_value()) << reply.error().reply;
    EXPECT_THAT(*reply, ElementsAre("G28", count));
  }
}

TEST(ServeTcp, FaultsTravel) {
  TcpServer server;
  TcpLink link("127.0.0.1", server.port());

  const auto reply = link.Send("M112", seconds(5));

  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kAlarm);
}

TEST(ServeTcp, StopsWithAClientStillConnected) {
  auto server = std::make_unique<TcpServer>();
  TcpLink link("127.0.0.1", server->port());
  ASSERT_TRUE(link.Send("G28", seconds(5)).has_value());

  const auto before = std::chrono::steady_clock::now();
  server.reset();

  EXPECT_LT(std::chrono::steady_clock::now() - before, seconds(5));
  const auto reply = link.Send("G28", seconds(5));
  ASSERT_FALSE(reply.has_value());
  EXPECT_EQ(reply.error().kind, MachineFault::Kind::kLinkLost);
}

TEST(ServeTcp, TakenPortIsAnInputError) {
  TcpServer server;
  CountingLink link;
  const std::atomic<bool> stop = true;

  EXPECT_THROW(ServeTcp(PortsOf(&link), server.port(), &stop), InputError);
}

TEST(ServePty, TerminalMayBeOpenedTwice) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("caltwin_pty_" + std::to_string(getpid()));
  CountingLink machine;
  std::atomic<bool> stop = false;
  std::promise<void> ready;
  std::thread server(
      [&] { ServePty(PortsOf(&machine), path, &stop, [&] { ready.set_value(); }); });
  ready.get_future().get();

  for (const char* const count : {"1", "2"}) {
    const auto link = OpenLink("serial:" + path.string() + "?baud=115200");
    const auto reply = link->Send("G28", seconds(5));
    EXPECT_TRUE(reply.has_value());
    if (reply) {
      EXPECT_THAT(*reply, ElementsAre("G28", count));
    }
  }

  stop = true;
  server.join();
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(path)));
}

// What a user does: one program serves the printer, another calibrates it over the
// port.
TEST(ServeTcp, ADeltaIsCalibratedOverThePortAsBesideIt) {
  class Nobody : public Operator {
    Expected<void> Do(const Act&) override {
      return tl::unexpected(MachineFault{.reply = "nobody"});
    }
  } nobody;
  const MachineFile file = ReadAnyMachineFile("models/delta_printer/machine.yaml");
  DeltaTwinConfig config{.machine = file.machine,
                         .settings = DeltaOf(file.machine).settings,
                         .fidelity = Fidelity::kFast};
  config.built.build = DeltaOf(file.machine).Build();
  config.built.build.model.endstop_mm[0] += 0.3;
  DeltaTwin served(config), beside(config);
  const DeltaStep step{.name = "klipper_descent"};
  std::atomic<bool> stop = false;
  std::promise<int> port;
  std::thread server([&] {
    ServeTcp(PortsOf(&served.link()), 0, &stop, [&port](int number) {
      port.set_value(number);
    });
  });

  const auto link =
      OpenLink("tcp:127.0.0.1:" + std::to_string(port.get_future().get()));
  const auto over_port = CalibrateDelta(
      step, {.link = link.get(), .person = &nobody, .machine = file.machine});
  const auto direct = CalibrateDelta(
      step, {.link = &beside.link(), .person = &nobody, .machine = file.machine});

  stop = true;
  server.join();
  EXPECT_EQ(over_port.touches, 7);
  ASSERT_EQ(over_port.steps.size(), direct.steps.size());
  ASSERT_FALSE(direct.steps.empty());
  for (std::size_t i = 0; i < direct.steps.size(); ++i) {
    EXPECT_EQ(over_port.steps[i].after, direct.steps[i].after) << direct.steps[i].name;
  }
}

TEST(SharedLink, TwoThreadsTakeTurns) {
  CountingLink machine;
  SharedLink shared(&machine);
  const auto talk = [&] {
    for (int i = 0; i < 1000; ++i) shared.Send("G28", seconds(1));
  };

  std::thread one(talk);
  std::thread two(talk);
  one.join();
  two.join();

  EXPECT_THAT(*shared.Send("G28", seconds(1)), ElementsAre("G28", "2001"));
}

TEST(ServePty, ExistingFileIsNotOverwritten) {
  CountingLink machine;
  const std::atomic<bool> stop = true;

  EXPECT_THROW(
      ServePty(PortsOf(&machine), std::filesystem::temp_directory_path(), &stop),
      InputError);
}

}  // namespace
}  // namespace caltwin
