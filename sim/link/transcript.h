#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/link/link.h"

namespace caltwin {

/// A transcript is text: `> line` was sent, `< line` came back before the ok, `! kind
/// words` ended it instead (timeout or link_lost); `#` lines are remarks.
///
/// Replays one as if the machine were there. A line that differs from the one recorded
/// is answered by a kLinkLost fault that says where and what was expected, and so is
/// every later one: from there on the recording knows nothing.
class TranscriptLink : public Link {
 public:
  /// Throws InputError for a file that is no transcript (at most 100 MB).
  explicit TranscriptLink(const std::filesystem::path& file);
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  /// Whether every recorded line has been sent.
  bool finished() const { return next_ == exchanges_.size(); }

 private:
  struct Exchange {
    int line_number = 0;
    std::string sent{};
    std::vector<std::string> lines{};
    std::string ending{};  ///< Empty: ok; else what stands behind "! ".
  };
  void Read(const std::string& text);

  std::string file_;
  std::vector<Exchange> exchanges_{};
  std::size_t next_ = 0;
  bool has_parted_ = false;
};

/// Passes everything on to another link and keeps the transcript of it.
class RecordingLink : public Link {
 public:
  /// `inner` is borrowed. Without a file the transcript is only held.
  explicit RecordingLink(Link* inner, std::filesystem::path file = {});
  /// Writes the file, if Save has not; a failure to write is silent here.
  ~RecordingLink() override;
  RecordingLink(const RecordingLink&) = delete;
  RecordingLink& operator=(const RecordingLink&) = delete;

  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  /// Writes what has been recorded so far; throws InputError where it cannot.
  void Save();
  /// What has been recorded so far.
  const std::string& text() const { return text_; }

 private:
  Link* inner_;
  std::filesystem::path file_;
  std::string text_;
  bool is_saved_ = false;
};

}  // namespace caltwin
