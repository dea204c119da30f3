#include "sim/controllers/linuxcnc/plant_page.h"

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/futex.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace linuxcnc {
namespace {

using std::chrono::milliseconds;
using Now = std::chrono::steady_clock;

/// LinuxCNC asks some ten thousand times a second: a sleep would cost more than it.
constexpr int kSpins = 2000;

std::uint32_t Read(const std::uint32_t* word) {
  return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

void Wake(std::uint32_t* word) {
  syscall(SYS_futex, word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

[[noreturn]] void Refuse(const std::filesystem::path& file, int error) {
  throw InputError({.file = file.string()}, SystemSays(error));
}

}  // namespace

PlantPage::PlantPage(const std::filesystem::path& file,
                     Joints* joints,
                     milliseconds patience)
    : file_(file), joints_(joints), asked_(Motors::Zero(joints->size())) {
  if (joints->size() > kCaltwinPageJoints) {
    throw InputError({},
                     fmt::format("LinuxCNC has no more than {} joints, this machine {}",
                                 static_cast<int>(kCaltwinPageJoints),
                                 joints->size()));
  }
  // LinuxCNC runs as whoever started it.
  constexpr mode_t kForOthersToo = 0666;
  descriptor_.Set(
      open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kForOthersToo));
  if (!descriptor_.is_open()) Refuse(file, errno);
  if (flock(descriptor_.number(), LOCK_EX | LOCK_NB) != 0) {
    throw InputError({.file = file.string()},
                     "another caltwin serves a machine there",
                     "take another name, or end it");
  }
  if (ftruncate(descriptor_.number(), kCaltwinPageBytes) != 0) Refuse(file, errno);
  void* const at = mmap(nullptr,
                        kCaltwinPageBytes,
                        PROT_READ | PROT_WRITE,
                        MAP_SHARED,
                        descriptor_.number(),
                        0);
  if (at == MAP_FAILED) Refuse(file, errno);
  page_ = static_cast<CaltwinPage*>(at);
  // A LinuxCNC may still be there that a killed twin left behind.
  const bool is_taken_over =
      page_->magic == kCaltwinPageMagic && page_->version == kCaltwinPageVersion;
  if (!is_taken_over) *page_ = CaltwinPage{};
  page_->version = kCaltwinPageVersion;
  page_->patience_ms = static_cast<std::uint32_t>(patience.count());
  page_->magic = kCaltwinPageMagic;
  __atomic_store_n(&page_->is_served, 1, __ATOMIC_RELEASE);
}

PlantPage::~PlantPage() {
  __atomic_store_n(&page_->is_served, 0, __ATOMIC_RELEASE);
  Wake(&page_->answered);
  munmap(page_, kCaltwinPageBytes);
  unlink(file_.c_str());
}

bool PlantPage::Await(milliseconds patience) {
  const std::uint32_t answered = page_->answered;
  for (int i = 0; i < kSpins; ++i) {
    if (Read(&page_->asked) != answered) return true;
  }
  const auto until = Now::now() + patience;
  while (Read(&page_->asked) == answered) {
    const auto left =
        std::chrono::duration_cast<std::chrono::nanoseconds>(until - Now::now());
    if (left.count() <= 0) return false;
    const timespec most{.tv_sec = left.count() / 1'000'000'000,
                        .tv_nsec = left.count() % 1'000'000'000};
    const long woken =
        syscall(SYS_futex, &page_->asked, FUTEX_WAIT, answered, &most, nullptr, 0);
    if (woken < 0 && errno == EINTR) return Read(&page_->asked) != answered;
  }
  return true;
}

void PlantPage::Answer() {
  Motors to(asked_.size());
  for (Eigen::Index i = 0; i < to.size(); ++i) {
    // A scale of nothing, or a kinematics gone wild: the motor stays.
    constexpr double kMost_steps = 1e12;
    const double steps = page_->commanded_steps[i];
    to[i] = std::abs(steps) < kMost_steps ? steps : asked_[i];
  }
  still_cycles_ = to == asked_ ? std::min(still_cycles_ + 1, INT_MAX - 1) : 0;
  asked_ = to;
  const Joints::Inputs inputs = joints_->Cycle(to, page_->time_s);
  page_->switches = inputs.switches;
  page_->has_met = inputs.probe ? 1 : 0;
  const Motors& reported = inputs.reported_steps;
  std::copy(reported.begin(), reported.end(), page_->feedback_steps);
  __atomic_store_n(&page_->answered, Read(&page_->asked), __ATOMIC_RELEASE);
  Wake(&page_->answered);
}

bool PlantPage::Turn(milliseconds patience) {
  if (!Await(patience)) return false;
  Answer();
  return true;
}

}  // namespace linuxcnc
}  // namespace caltwin
