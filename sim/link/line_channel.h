#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace caltwin {

/// Takes bytes as they come and gives lines: they end in LF, CR or both; empty ones are
/// dropped.
class LineSplitter {
 public:
  void Add(std::string_view bytes) { waiting_.append(bytes); }
  /// The next line, without its end; false: none is whole.
  bool Take(std::string* line);
  /// Of what is not taken yet.
  std::size_t size() const { return waiting_.size(); }
  void Clear() { waiting_.clear(); }

 private:
  std::string waiting_{};
};

/// Lines of text over a file descriptor: a socket, a serial port, a pseudo-terminal.
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
  /// What has come, at most so long waited for: kLine with bytes as they are.
  Result ReadSome(std::chrono::milliseconds patience);
  /// Sends the line and a newline; false where the other side is gone or takes nothing
  /// for as long as the patience, ten seconds.
  bool WriteLine(std::string_view line) { return Write(std::string(line) + "\n"); }
  bool Write(std::string_view bytes,
             std::chrono::milliseconds patience = std::chrono::seconds(10));
  /// Forgets what has arrived and was not read.
  void Discard();

 private:
  /// Reads what is there, perhaps nothing; nullopt where the other side is gone.
  std::optional<std::string> ReadNow();
  bool Fill();

  int descriptor_;
  std::size_t most_bytes_;
  LineSplitter waiting_{};
  std::mutex writing_{};  ///< A line is sent whole, whoever else sends one.
};

}  // namespace caltwin
