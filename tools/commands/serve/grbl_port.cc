#include "tools/commands/serve/grbl_port.h"

#include <chrono>
#include <utility>

#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using Lines = grbl::Controller::Lines;

constexpr std::size_t kRxBuffer = 128;
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
    machine_->pace_->Stop();
    machine_->PutFirst([controller] { return controller->SwitchOn(); });
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
      const std::string status = machine_->controller_->Status(Free());
      if (!status.empty()) client_->Tell(status + "\r\n");
    } else if (byte == '!') {
      machine_->controller_->Hold();
    } else if (byte == '~') {
      machine_->controller_->Resume();
    } else if (code == 0x85) {
      machine_->EndJogs();
    } else if (code >= 0x80) {
      machine_->controller_->Override(code);
    } else if (byte == '\n' || byte == '\r') {
      TakeLine(byte);
    } else if (line_.size() < Free()) {
      line_ += byte;
    }  // Else it is lost, as in a buffer that is full.
  }

  void TakeLine(char end) {
    // CR LF is one end: the LF behind it would be an empty line, and get its ok.
    const bool is_second = end == '\n' && last_end_ == '\r' && line_.empty();
    last_end_ = line_.empty() && is_second ? '\0' : end;
    if (is_second) return;
    const std::size_t bytes = line_.size() + 1;
    machine_->Put(
        {.client = client_, .text = std::exchange(line_, {}), .bytes = bytes});
  }

  std::size_t Free() const {
    const std::lock_guard<std::mutex> lock(client_->mutex);
    return client_->waiting < kRxBuffer ? kRxBuffer - client_->waiting : 0;
  }

  GrblMachine* machine_;
  std::shared_ptr<Client> client_;
  std::string line_{};
  char last_end_ = '\0';
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
  pace_->Stop();
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
  {
    const std::lock_guard<std::mutex> lock(line.client->mutex);
    line.client->waiting += line.bytes;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  lines_.push_back(std::move(line));
  changed_.notify_all();
}

void GrblMachine::PutFirst(std::function<Lines()> act) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const Line& line : lines_) {
    const std::lock_guard<std::mutex> client_lock(line.client->mutex);
    line.client->waiting -= line.bytes;
  }
  lines_.clear();
  acts_.push_back(std::move(act));
  changed_.notify_all();
}

void GrblMachine::SoftReset() {
  const bool in_motion = controller_->InMotion();
  pace_->Stop();
  PutFirst([this, in_motion] { return controller_->Reset(in_motion); });
}

void GrblMachine::EndJogs() {
  if (!controller_->is_jogging()) return;
  pace_->Stop();
  const std::lock_guard<std::mutex> lock(mutex_);
  acts_.push_back([this] {
    controller_->EndJogs();
    return Lines{};
  });
  changed_.notify_all();
}

void GrblMachine::TellAll(const Lines& lines) {
  if (lines.empty()) return;
  std::list<std::shared_ptr<Client>> clients;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    clients = clients_;
  }
  const std::string text = TextOf(lines);
  for (const auto& client : clients) client->Tell(text);
}

void GrblMachine::Work() {
  while (Turn()) {
  }
}

bool GrblMachine::Turn() {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto is_wanted = [&] {
    return is_over_ || !acts_.empty() || !lines_.empty();
  };
  if (controller_->has_moves()) {
    changed_.wait_until(lock, begin_, is_wanted);
  } else {
    changed_.wait(lock, is_wanted);
  }
  if (is_over_) return false;
  if (!acts_.empty()) {
    const auto act = std::move(acts_.front());
    acts_.pop_front();
    lock.unlock();
    TellAll(act());
  } else if (!lines_.empty()) {
    const Line line = std::move(lines_.front());
    lines_.pop_front();
    lock.unlock();
    {
      // Out of the buffer while it is obeyed, as in grbl.
      const std::lock_guard<std::mutex> client_lock(line.client->mutex);
      line.client->waiting -= line.bytes;
    }
    const std::string answer = TextOf(controller_->Execute(line.text));
    line.client->Tell(answer);
    begin_ = std::chrono::steady_clock::now() + kGathering;
  } else {
    lock.unlock();
    TellAll(controller_->GoOn());
  }
  return true;
}

}  // namespace caltwin
