#pragma once

#include <cstddef>

namespace caltwin {

/// What the bodies of all requests together may hold of the memory [bytes], from the
/// first byte until the request is answered. One thread's.
class BodyBudget {
 public:
  /// A body up to this size is never refused, so that no upload stands in the way of an
  /// answer to a question: connections are few, and so is what they hold of these.
  static constexpr std::size_t kFree_bytes = 65'536;

  explicit BodyBudget(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// What one body holds; gives it back at its end.
  class Share {
   public:
    explicit Share(BodyBudget* budget) : budget_(budget) {}
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share() { Release(); }

    /// The body has, or is going to have, this length in all; false where that is too
    /// much beside the others: then nothing changes.
    bool GrowTo(std::size_t length_bytes) {
      if (length_bytes <= kFree_bytes || length_bytes <= bytes_) return true;
      const std::size_t more = length_bytes - bytes_;
      if (more > budget_->most_bytes_ - budget_->held_bytes_) return false;
      budget_->held_bytes_ += more;
      bytes_ = length_bytes;
      return true;
    }
    void Release() {
      budget_->held_bytes_ -= bytes_;
      bytes_ = 0;
    }

   private:
    BodyBudget* budget_;
    std::size_t bytes_ = 0;
  };

  std::size_t held_bytes() const { return held_bytes_; }

 private:
  std::size_t most_bytes_;
  std::size_t held_bytes_ = 0;  // Never above the most.
};

}  // namespace caltwin
