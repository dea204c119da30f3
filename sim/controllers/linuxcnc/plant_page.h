#pragma once

#include <chrono>
#include <filesystem>

#include "sim/base/descriptor.h"
#include "sim/controllers/linuxcnc/component/page.h"
#include "sim/controllers/linuxcnc/joints.h"

namespace caltwin {
namespace linuxcnc {

/// The page that LinuxCNC's component (component/caltwin.comp) asks on, and the joints
/// that answer. LinuxCNC may come, go or be killed: the machine stands where it was
/// left.
class PlantPage {
 public:
  /// Makes `file`, or takes it over where a twin left it that was killed. `joints` is
  /// borrowed. `patience`: so long the component waits for an answer before it takes
  /// the twin for dead; 0: for ever. Throws InputError where the file cannot be had or
  /// another twin has it.
  PlantPage(const std::filesystem::path& file,
            Joints* joints,
            std::chrono::milliseconds patience);
  /// The component learns that the twin has ended; the file goes.
  ~PlantPage();
  PlantPage(const PlantPage&) = delete;
  PlantPage& operator=(const PlantPage&) = delete;

  /// Waits for a cycle of LinuxCNC's and answers it. False: none came in that time.
  bool Turn(std::chrono::milliseconds patience);

  /// LinuxCNC's time: its cycles times their period [s].
  double time_s() const { return page_->time_s; }
  /// For how many cycles nothing has moved.
  int still_cycles() const { return still_cycles_; }

 private:
  bool Await(std::chrono::milliseconds patience);
  void Answer();

  std::filesystem::path file_;
  Joints* joints_;
  Descriptor descriptor_{};
  CaltwinPage* page_ = nullptr;
  Motors asked_;
  int still_cycles_ = 0;
};

}  // namespace linuxcnc
}  // namespace caltwin
