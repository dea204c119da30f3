#pragma once

#include <string>
#include <utility>

namespace caltwin {

/// A file descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  /// Closes the one it had.
  void Set(int number);
  void Close() { Set(-1); }
  /// Whoever takes it closes it.
  int Release() { return std::exchange(number_, -1); }

 private:
  int number_ = -1;
};

/// What the system says of that errno.
std::string SystemSays(int error);

}  // namespace caltwin
