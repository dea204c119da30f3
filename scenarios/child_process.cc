#include "scenarios/child_process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <optional>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scenarios/interrupt.h"
#include "scenarios/spawn.h"
#include "sim/base/descriptor.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kLongestLine_bytes = 64 * 1024;
constexpr std::size_t kMostUnread_bytes = 1024 * 1024;
constexpr std::chrono::milliseconds kLook{50};  // How often the child is looked after.

struct Pipe {
  Descriptor read;
  Descriptor write;
  Pipe() {
    std::array<int, 2> ends{};
    Require(pipe2(ends.data(), O_CLOEXEC) == 0, "no pipe is to be had");
    read.Set(ends[0]);
    write.Set(ends[1]);
  }
};

void SetNonBlocking(int fd) {
  fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
}

// While one lives, writing to a child that is gone is an error and no signal.
class NoBrokenPipeSignal {
 public:
  NoBrokenPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  NoBrokenPipeSignal(const NoBrokenPipeSignal&) = delete;
  NoBrokenPipeSignal& operator=(const NoBrokenPipeSignal&) = delete;
  ~NoBrokenPipeSignal() {
    if (sigismember(&before_, SIGPIPE) == 0) {
      const timespec at_once{};
      while (sigtimedwait(&pipe_, nullptr, &at_once) > 0) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  const sigset_t& before() const { return before_; }

 private:
  sigset_t pipe_{};
  sigset_t before_{};
};

// The talk with one running child.
class Conversation {
 public:
  Conversation(pid_t pid, const ChildCommand& command, const AnswerLine& answer)
      : pid_(pid),
        command_(command),
        answer_(answer),
        deadline_(Clock::now() + command.patience) {}

  ChildEnd Run(Descriptor* in, Descriptor* out, Descriptor* err) {
    while (!status_ || out->is_open() || err->is_open()) {
      if (!status_) LookAfter();
      const bool nothing_more = status_.has_value() && !Poll(in, out, err, 0);
      if (nothing_more) break;
      if (!status_) Poll(in, out, err, static_cast<int>(kLook.count()));
    }
    return End();
  }

 private:
  // Whether the child is still there; kills it when its time is over.
  void LookAfter() {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
      status_ = status;
      return;
    }
    if (!why_killed_ && Clock::now() > deadline_) Kill(ChildEnd::How::kTimedOut);
    if (!why_killed_ && IsStopped()) Kill(ChildEnd::How::kInterrupted);
  }

  bool IsStopped() const {
    return InterruptRequested() || (command_.stop != nullptr && *command_.stop);
  }

  void Kill(ChildEnd::How why) {
    why_killed_ = why;
    kill(-pid_, SIGKILL);
  }

  // Moves what can be moved; false where nothing could within the time.
  bool Poll(Descriptor* in, Descriptor* out, Descriptor* err, int timeout_ms) {
    const bool is_full = unread_.size() > kMostUnread_bytes;
    std::array<pollfd, 3> polled = {
        pollfd{unread_.empty() ? -1 : in->number(), POLLOUT, 0},
        pollfd{is_full ? -1 : out->number(), POLLIN, 0},
        pollfd{err->number(), POLLIN, 0}};
    if (poll(polled.data(), polled.size(), timeout_ms) <= 0) return false;
    if (polled[0].revents != 0) Write(in);
    if (polled[1].revents != 0) ReadLines(in, out);
    if (polled[2].revents != 0) ShowErrors(err);
    return true;
  }

  void Write(Descriptor* in) {
    const ssize_t count = write(in->number(), unread_.data(), unread_.size());
    if (count > 0) unread_.erase(0, static_cast<std::size_t>(count));
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
      in->Close();
      unread_.clear();
    }
  }

  void ReadLines(Descriptor* in, Descriptor* out) {
    std::array<char, 4096> buffer{};
    const ssize_t count = read(out->number(), buffer.data(), buffer.size());
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {  // It has said its last: so have we.
      out->Close();
      in->Close();
      unread_.clear();
      return;
    }
    said_.append(buffer.data(), static_cast<std::size_t>(count));
    std::size_t start = 0;
    for (std::size_t end = said_.find('\n'); end != std::string::npos;
         end = said_.find('\n', start)) {
      std::string_view line(said_.data() + start, end - start);
      if (line.ends_with('\r')) line.remove_suffix(1);
      start = end + 1;
      if (why_killed_ || IsStopped()) continue;
      const std::string reply = answer_(line);
      if (in->is_open()) unread_ += reply;
      if (Clock::now() > deadline_) LookAfter();
    }
    said_.erase(0, start);
    if (said_.size() > kLongestLine_bytes) {
      last_words_ += "\na line longer than 64 kB\n";
      kill(-pid_, SIGKILL);
      said_.clear();
    }
  }

  void ShowErrors(Descriptor* err) {
    std::array<char, 4096> buffer{};
    const ssize_t count = read(err->number(), buffer.data(), buffer.size());
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {
      err->Close();
      return;
    }
    const std::string_view text(buffer.data(), static_cast<std::size_t>(count));
    if (command_.shows_errors) fmt::print(stderr, "{}", text);
    last_words_ += text;
    if (last_words_.size() > command_.last_words_bytes) {
      last_words_.erase(0, last_words_.size() - command_.last_words_bytes);
    }
  }

  ChildEnd End() {
    kill(-pid_, SIGKILL);  // Whatever it has left behind in its group.
    ChildEnd end{.last_words = last_words_};
    if (why_killed_) {
      end.how = *why_killed_;
    } else if (WIFEXITED(*status_)) {
      end.code = WEXITSTATUS(*status_);
    } else {
      end.how = ChildEnd::How::kKilled;
      end.code = WTERMSIG(*status_);
    }
    return end;
  }

  pid_t pid_;
  const ChildCommand& command_;
  const AnswerLine& answer_;
  Clock::time_point deadline_;
  std::optional<int> status_{};
  std::optional<ChildEnd::How> why_killed_{};
  std::string said_{};    // By the child, not yet a whole line.
  std::string unread_{};  // Answers it has not taken yet.
  std::string last_words_{};
};

}  // namespace

std::string ToString(const ChildEnd& end) {
  switch (end.how) {
    case ChildEnd::How::kExited:
      return fmt::format("exited with {}", end.code);
    case ChildEnd::How::kKilled:
      return fmt::format("was killed by signal {}", end.code);
    case ChildEnd::How::kTimedOut:
      return "took longer than its timeout_s and was ended";
    case ChildEnd::How::kInterrupted:
      return "was interrupted";
    case ChildEnd::How::kNotStarted:
      break;
  }
  return fmt::format("could not be started: {}", std::strerror(end.code));
}

ChildEnd ConverseWith(const ChildCommand& command, const AnswerLine& answer) {
  Require(!command.words.empty(), "a command has a first word");
  const NoBrokenPipeSignal quiet;
  Pipe in;
  Pipe out;
  Pipe err;
  const Spawned spawned = Spawn({.words = command.words,
                                 .folder = command.folder,
                                 .environment = command.environment,
                                 .descriptors = {{in.read.number(), STDIN_FILENO},
                                                 {out.write.number(), STDOUT_FILENO},
                                                 {err.write.number(), STDERR_FILENO}},
                                 .most_memory_bytes = command.most_memory_bytes,
                                 .blocked = quiet.before()});
  if (spawned.error != 0) {
    return {.how = ChildEnd::How::kNotStarted, .code = spawned.error};
  }
  in.read.Close();
  out.write.Close();
  err.write.Close();
  for (const int fd : {in.write.number(), out.read.number(), err.read.number()})
    SetNonBlocking(fd);
  Conversation conversation(spawned.pid, command, answer);
  return conversation.Run(&in.write, &out.read, &err.read);
}

}  // namespace caltwin
