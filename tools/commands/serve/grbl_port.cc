#include "tools/commands/serve/grbl_port.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using Lines = grbl::Controller::Lines;

constexpr std::size_t kRxBuffer = 128, kLineBuffer = 80;
constexpr std::size_t kLongestRaw = 1024;  // With comments, which it never keeps.
constexpr std::chrono::milliseconds kGathering(30);

std::string TextOf(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += Printable(line) + "\r\n";
  return text;
}

}  // namespace

/// One client: bytes that act at once, and lines.
class GrblMachine::ClientPort final : public Port {
 public:
  ClientPort(GrblMachine* machine, Say say)
      : machine_(machine), client_(machine->Join(std::move(say))) {}
  ~ClientPort() override { machine_->Leave(client_); }
  ClientPort(const ClientPort&) = delete;
  ClientPort& operator=(const ClientPort&) = delete;

  bool RestartsWhenOpened() const override { return true; }
  void Open(bool has_restarted) override {
    grbl::Controller* const controller = machine_->controller_;
    if (!has_restarted) {
      client_->Tell("\r\nGrbl 1.1h ['$' for help]\r\n");
      return;
    }
    line_.clear();
    machine_->StopFor([controller] { return controller->SwitchOn(); },
                      /*drops_lines=*/true);
  }

  bool Hear(std::string_view bytes) override {
    for (const char byte : bytes) Take(byte);
    return true;
  }

 private:
  void Take(char byte) {
    const auto code = static_cast<unsigned char>(byte);
    if (code == 0x18) {
      line_.clear();
      machine_->SoftReset();
    } else if (byte == '?') {
      const std::string status =
          machine_->controller_->Status(std::min(Free(), kRxBuffer));
      if (!status.empty()) client_->Tell(status + "\r\n");
    } else if (code == 0x85 || (byte == '!' && machine_->controller_->is_jogging())) {
      machine_->EndJogs();
    } else if (byte == '!') {
      machine_->controller_->Hold();
    } else if (byte == '~') {
      machine_->controller_->Resume();
    } else if (code >= 0x80) {
      machine_->controller_->Override(code);
    } else if (Free() == 0) {
      // Lost, as in a buffer that is full: ends of lines too.
    } else if (byte == '\n' || byte == '\r') {
      const std::size_t bytes = line_.size() + 1;
      machine_->Put(
          {.client = client_, .text = std::exchange(line_, {}), .bytes = bytes});
    } else if (line_.size() < kLongestRaw) {
      line_ += byte;
    }
  }

  /// What still fits: into the serial buffer, and the line that is taken out of it to
  /// be obeyed and may have to wait for moves.
  std::size_t Free() const {
    constexpr std::size_t kAll = kRxBuffer + kLineBuffer;
    const std::size_t waiting = client_->waiting;
    return waiting < kAll ? kAll - waiting : 0;
  }

  GrblMachine* machine_;
  std::shared_ptr<Client> client_;
  std::string line_{};
};

void GrblMachine::Client::Tell(std::string_view bytes) {
  const std::lock_guard<std::mutex> lock(mutex);
  if (say) say(bytes);
}

GrblMachine::GrblMachine(grbl::Controller* controller, Pace* pace)
    : controller_(controller), pace_(pace), thread_([this] { Work(); }) {}

GrblMachine::~GrblMachine() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_over_ = true;
  }
  pace_->StopForGood();
  changed_.notify_all();
  thread_.join();
}

OpenPort GrblMachine::ports() {
  return [this](Say say) {
    return std::make_unique<ClientPort>(this, std::move(say));
  };
}

std::shared_ptr<GrblMachine::Client> GrblMachine::Join(Say say) {
  auto client = std::make_shared<Client>();
  client->say = std::move(say);
  const std::lock_guard<std::mutex> lock(mutex_);
  clients_.push_back(client);
  return client;
}

void GrblMachine::Leave(const std::shared_ptr<Client>& client) {
  {
    const std::lock_guard<std::mutex> lock(client->mutex);
    client->say = nullptr;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  clients_.remove(client);
}

void GrblMachine::Put(Line line) {
  line.client->waiting += line.bytes;
  const std::lock_guard<std::mutex> lock(mutex_);
  lines_.push_back(std::move(line));
  changed_.notify_all();
}

void GrblMachine::StopFor(std::function<Lines()> act, bool drops_lines) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (drops_lines) {
    for (const Line& line : lines_) line.client->waiting -= line.bytes;
    lines_.clear();
  }
  acts_.push_back(std::move(act));
  pace_->Stop();
  changed_.notify_all();
}

void GrblMachine::SoftReset() {
  const bool in_motion = controller_->InMotion();
  StopFor([this, in_motion] { return controller_->Reset(in_motion); },
          /*drops_lines=*/true);
}

void GrblMachine::EndJogs() {
  if (!controller_->is_jogging()) return;
  StopFor(
      [this] {
        controller_->EndJogs();
        return Lines{};
      },
      /*drops_lines=*/false);
}

void GrblMachine::TellAll(const Lines& lines, const Client* but) {
  if (lines.empty()) return;
  std::list<std::shared_ptr<Client>> clients;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    clients = clients_;
  }
  const std::string text = TextOf(lines);
  for (const auto& client : clients) {
    if (client.get() != but) client->Tell(text);
  }
}

void GrblMachine::Answer(const Line& line) {
  // Out of the buffer while it is obeyed, as in grbl.
  line.client->waiting -= line.bytes;
  is_obeying_ = true;
  const Lines answer = controller_->Execute(line.text);
  is_obeying_ = false;
  line.client->Tell(TextOf(answer));
  Lines for_all;
  std::ranges::copy_if(
      answer, std::back_inserter(for_all), [](const std::string& said) {
        return said.starts_with("ALARM:") || said.starts_with("[MSG:Reset") ||
               said.starts_with("Grbl ") || said.starts_with("[MSG:'$H'");
      });
  TellAll(for_all, line.client.get());
}

void GrblMachine::TakeLinesMeanwhile() {
  // A line that waits for moves lets them be made: those behind it wait for their turn.
  if (is_obeying_) return;
  for (;;) {
    Line line;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!acts_.empty() || lines_.empty() || pace_->is_held() ||
          !controller_->TakesMeanwhile(lines_.front().text)) {
        return;
      }
      line = std::move(lines_.front());
      lines_.pop_front();
    }
    Answer(line);
  }
}

void GrblMachine::Work() {
  pace_->SetMeanwhile([this] { TakeLinesMeanwhile(); });
  while (Turn()) {
  }
}

bool GrblMachine::Turn() {
  constexpr std::chrono::milliseconds kGlance(10);
  std::unique_lock<std::mutex> lock(mutex_);
  // Held, it obeys no line.
  const auto takes_line = [&] {
    return !lines_.empty() && !pace_->is_held() &&
           (!controller_->has_moves() ||
            controller_->TakesMeanwhile(lines_.front().text));
  };
  const auto is_wanted = [&] {
    return is_over_ || !acts_.empty() || takes_line();
  };
  if (controller_->has_moves()) {
    // A line that waits for them is no reason to.
    if (lines_.empty()) changed_.wait_until(lock, begin_, is_wanted);
  } else if (!lines_.empty()) {
    changed_.wait_for(lock, kGlance, is_wanted);
  } else {
    changed_.wait(lock, [&] { return is_wanted() || !lines_.empty(); });
  }
  if (is_over_) return false;
  if (!acts_.empty()) {
    const auto act = std::move(acts_.front());
    acts_.pop_front();
    lock.unlock();
    is_obeying_ = true;
    const Lines said = act();
    is_obeying_ = false;
    TellAll(said);
  } else if (takes_line()) {
    const Line line = std::move(lines_.front());
    lines_.pop_front();
    lock.unlock();
    Answer(line);
    begin_ = std::chrono::steady_clock::now() + kGathering;
  } else if (controller_->has_moves()) {
    lock.unlock();
    TellAll(controller_->GoOn());
  }
  return true;
}

}  // namespace caltwin
