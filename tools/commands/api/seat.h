#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "tools/server/http.h"

namespace caltwin {

/// The one seat at a machine: who sits there may move it, others look on.
class OperatorSeat {
 public:
  /// Sits as long as it lives.
  class Held {
   public:
    explicit Held(OperatorSeat* seat) : seat_(seat) {}
    Held(Held&& other) noexcept : seat_(other.seat_) { other.seat_ = nullptr; }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    Held& operator=(Held&&) = delete;
    ~Held() {
      if (seat_ != nullptr) seat_->Rise();
    }

   private:
    OperatorSeat* seat_;
  };

  /// Throws Problem 409 with `held_by` and what is done there.
  /// @param request  whose header `X-Operator` says who asks; else "somebody"
  /// @param doing  "probing the bed"
  Held Take(const HttpRequest& request, const std::string& doing);
  /// Who sits there and does what; nullopt: nobody.
  struct Sitter {
    std::string name{};
    std::string doing{};
  };
  std::optional<Sitter> sitter() const;
  /// Whoever sits there is to stop at the next line; false: nobody does.
  bool Abort();
  bool is_aborted() const { return is_aborted_; }
  /// Calls `look` while nobody sits there and nobody can sit down; not at all
  /// otherwise.
  void IfFree(const std::function<void()>& look) const;

 private:
  void Rise();

  mutable std::mutex mutex_{};
  std::optional<Sitter> sitter_{};
  std::atomic<bool> is_aborted_ = false;
};

}  // namespace caltwin
