#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "sim/link/link.h"
#include "tools/commands/api/seat.h"

namespace caltwin {

/// What a procedure asks of the person at the machine.
struct Question {
  int id = 0;
  std::string kind{};  ///< confirm, turn_block, fit_stylus, other, reading, zero
  std::string text{};
  std::string gauge{};              ///< Of a reading: "calliper.block.x".
  std::optional<double> hint_mm{};  ///< A twin's own instrument reads this.
};
nlohmann::ordered_json ToJson(const Question& question);

/// The person at the machine as an HTTP client is: asked by an event, answered by a
/// request, while the procedure waits in its own thread. A twin's hands and gauges
/// help: what the person says was done is done there, and what its instruments read is
/// offered.
class ClientOperator final : public Operator, public Gauge {
 public:
  /// Of a twin; null of a real machine, and for what it lacks. Borrowed.
  struct Helpers {
    Operator* hands = nullptr;
    Gauge* gauge = nullptr;
  };
  /// `asked` is called, in the procedure's thread, when a question is put or answered.
  ClientOperator(Helpers helpers, std::function<void()> asked)
      : helpers_(helpers), asked_(std::move(asked)) {}

  Expected<void> Do(const Act& act) override;
  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;

  /// @name From other threads
  /// false: no such question waits.
  bool Answer(int id, bool is_yes, std::optional<double> value_mm);
  std::optional<Question> question() const;
  /// Every question from now on is refused, the one that waits too; until Begin.
  void Abort();
  void Begin();

 private:
  struct Answered {
    bool is_yes = false;
    std::optional<double> value_mm{};
  };
  Expected<Answered> Ask(Question question);

  Helpers helpers_;
  std::function<void()> asked_;
  mutable std::mutex mutex_{};
  std::condition_variable changed_{};
  std::optional<Question> question_{};
  std::optional<Answered> answer_{};
  int last_ = 0;
  bool is_aborted_ = false;
};

/// Passes lines on until the person aborts, then no more but what puts back what was
/// set for a measurement.
class AbortableLink final : public Link {
 public:
  /// Both are borrowed. `sent` is called after each line.
  AbortableLink(Link* inner,
                const OperatorSeat* seat,
                std::function<void(std::string_view)> sent)
      : inner_(inner), seat_(seat), sent_(std::move(sent)) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  bool Interject(std::string_view line) override { return inner_->Interject(line); }

 private:
  Link* inner_;
  const OperatorSeat* seat_;
  std::function<void(std::string_view line)> sent_;
};

}  // namespace caltwin
