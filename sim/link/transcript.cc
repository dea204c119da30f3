#include "sim/link/transcript.h"

#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/link/reply.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostBytes = 100'000'000;
constexpr std::string_view kTimeout = "timeout";
constexpr std::string_view kLinkLost = "link_lost";

/// Splits a reply that was joined by newlines.
void AppendLines(const std::string& reply, std::string_view mark, std::string* text) {
  std::istringstream lines(reply);
  for (std::string line; std::getline(lines, line);) {
    *text += fmt::format("{} {}\n", mark, line);
  }
}

}  // namespace

TranscriptLink::TranscriptLink(const std::filesystem::path& file)
    : file_(file.string()) {
  Read(ReadTextFile(file, kMostBytes));
}

void TranscriptLink::Read(const std::string& text) {
  Faults faults;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const std::string rest = line.size() > 2 ? line.substr(2) : "";
    if (line.front() == '>') {
      exchanges_.push_back({.line_number = number, .sent = rest});
    } else if (line.front() == '<' && !exchanges_.empty()) {
      exchanges_.back().lines.push_back(rest);
    } else if (line.front() == '!' && !exchanges_.empty()) {
      exchanges_.back().ending = rest;
    } else {
      faults.Add({file_, number, 1},
                 "this is no line of a transcript",
                 "'> sent', '< reply', '! timeout' or '# remark', a '>' first");
      break;
    }
  }
  if (faults.empty() && exchanges_.empty()) {
    faults.Add({file_, 1, 1}, "the transcript is empty");
  }
  faults.ThrowIfAny();
}

Expected<std::vector<std::string>> TranscriptLink::Send(std::string_view line,
                                                        std::chrono::milliseconds) {
  const auto lost = [](std::string reply) {
    return tl::make_unexpected(
        MachineFault{.kind = MachineFault::Kind::kLinkLost, .reply = std::move(reply)});
  };
  if (finished()) {
    return lost(
        fmt::format("{}: the transcript is at its end, '{}' was sent", file_, line));
  }
  const Exchange& exchange = exchanges_[next_];
  if (has_parted_ || exchange.sent != line) {
    has_parted_ = true;
    return lost(fmt::format("{}:{}: the transcript has '{}', '{}' was sent",
                            file_,
                            exchange.line_number,
                            exchange.sent,
                            line));
  }
  ++next_;
  if (exchange.ending.empty()) return JudgeReply(exchange.lines);
  const std::size_t space = exchange.ending.find(' ');
  const bool timed_out = exchange.ending.substr(0, space) == kTimeout;
  return tl::make_unexpected(MachineFault{
      .kind = timed_out ? MachineFault::Kind::kTimeout : MachineFault::Kind::kLinkLost,
      .reply = space == std::string::npos ? "" : exchange.ending.substr(space + 1)});
}

RecordingLink::RecordingLink(Link* inner, std::filesystem::path file)
    : inner_(inner), file_(std::move(file)), text_("# caltwin transcript\n") {}

RecordingLink::~RecordingLink() {
  try {
    if (!is_saved_) Save();
  } catch (const InputError&) {
    // A destructor has nobody to tell; whoever cares calls Save.
  }
}

Expected<std::vector<std::string>> RecordingLink::Send(
    std::string_view line, std::chrono::milliseconds patience) {
  text_ += fmt::format("> {}\n", line);
  is_saved_ = false;
  auto reply = inner_->Send(line, patience);
  if (reply) {
    for (const std::string& answer : *reply) text_ += fmt::format("< {}\n", answer);
  } else if (reply.error().kind == MachineFault::Kind::kTimeout) {
    text_ += fmt::format("! {} {}\n", kTimeout, reply.error().reply);
  } else if (reply.error().kind == MachineFault::Kind::kLinkLost) {
    text_ += fmt::format("! {} {}\n", kLinkLost, reply.error().reply);
  } else {
    AppendLines(reply.error().reply, "<", &text_);
  }
  return reply;
}

void RecordingLink::Save() {
  if (!file_.empty()) WriteTextFile(file_, text_);
  is_saved_ = true;
}

}  // namespace caltwin
