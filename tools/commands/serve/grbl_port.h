#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "sim/firmware/grbl/controller.h"
#include "sim/firmware/pace.h"
#include "tools/commands/serve/port.h"

namespace caltwin {

/// A grbl at work in a thread of its own, on as many ports as there are clients: what
/// they send is obeyed in the order in which it came, each gets the answers to its own
/// lines and all hear of alarms.
class GrblMachine {
 public:
  /// Both are borrowed, and nobody else's from now on.
  GrblMachine(grbl::Controller* controller, Pace* pace);
  ~GrblMachine();
  GrblMachine(const GrblMachine&) = delete;
  GrblMachine& operator=(const GrblMachine&) = delete;

  OpenPort ports();

 private:
  class ClientPort;
  /// A client as lines that wait remember it; it may have gone.
  struct Client {
    std::mutex mutex{};
    Say say{};  ///< Empty: gone.
    std::atomic<std::size_t> waiting =
        0;  ///< Bytes of its lines that are not obeyed yet.
    void Tell(std::string_view bytes);
  };
  struct Line {
    std::shared_ptr<Client> client{};
    std::string text{};
    std::size_t bytes = 0;  ///< In the buffer, with its end.
  };

  std::shared_ptr<Client> Join(Say say);
  void Leave(const std::shared_ptr<Client>& client);
  void Put(Line line);
  /// Stops the move that is on its way; what acts then comes before any line, and where
  /// `drops_lines`, in place of those that wait.
  void StopFor(std::function<grbl::Controller::Lines()> act, bool drops_lines);
  void SoftReset();
  void EndJogs();
  void TellAll(const grbl::Controller::Lines& lines, const Client* but = nullptr);
  void Answer(const Line& line);
  /// While a move goes on: lines that need not wait for its end.
  void TakeLinesMeanwhile();
  void Work();
  /// The next thing to do; false: the end.
  bool Turn();

  grbl::Controller* controller_;
  Pace* pace_;
  std::mutex mutex_{};
  std::condition_variable changed_{};
  std::deque<Line> lines_{};
  std::deque<std::function<grbl::Controller::Lines()>> acts_{};
  std::list<std::shared_ptr<Client>> clients_{};
  bool is_over_ = false;
  bool is_obeying_ = false;  ///< A line or an act, in the thread that performs moves.
  /// When moves that wait begin: soon after the last line, of which more may come and
  /// be blended.
  std::chrono::steady_clock::time_point begin_{};
  std::thread thread_;
};

}  // namespace caltwin
