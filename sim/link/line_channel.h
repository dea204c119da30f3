#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>

namespace caltwin {

/// Lines of text over a file descriptor: a socket, a serial port, a pseudo-terminal.
/// Lines end in LF, CR or both; empty ones are dropped.
class LineChannel {
 public:
  enum class Status { kLine, kTimeout, kClosed };
  struct Result {
    Status status = Status::kClosed;
    std::string line{};  ///< Without its end.
  };

  /// Owns `descriptor` from now on and makes it non-blocking. A line longer than
  /// `most_bytes` closes the channel: it is noise.
  explicit LineChannel(int descriptor, std::size_t most_bytes = 4'000'000);
  ~LineChannel();
  LineChannel(const LineChannel&) = delete;
  LineChannel& operator=(const LineChannel&) = delete;

  /// The next line, or why there is none within `patience`.
  Result ReadLine(std::chrono::milliseconds patience);
  /// Sends the line and a newline; false where the other side is gone or takes nothing
  /// for ten seconds.
  bool WriteLine(std::string_view line);
  /// Forgets what has arrived and was not read.
  void Discard();

 private:
  bool TakeLine(std::string* line);
  /// Reads what is there; false where the other side is gone.
  bool Fill();

  int descriptor_;
  std::size_t most_bytes_;
  std::string waiting_{};
  std::mutex writing_{};  ///< A line is sent whole, whoever else sends one.
};

}  // namespace caltwin
