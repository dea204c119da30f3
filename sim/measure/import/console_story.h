#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/screw_differences.h"

namespace caltwin {

/// What a console tells beyond its touches: levelling and what each motor was moved by,
/// the configuration that people paste above it, what came after what, and what a
/// firmware's own calibration said of itself.
class ConsoleStory {
 public:
  /// Takes the line where it is a part of the story; `home`: the session of the touches
  /// that follow.
  bool Take(const ConsoleLine& line, const Place& place, const std::string& home);
  /// A command that homes, after which some firmware forgets its levelling.
  void Home(const Place& place);
  void Level() { was_levelled_ = true; }

  /// Adds notes and levelling to what was imported.
  void Tell(Imported* imported) const;

  /// Of a pasted [probe] or [bltouch]; kUnknown: none.
  const std::array<double, 2>& probe_offset_mm() const { return probe_offset_mm_; }
  /// A touch was made where the last report said.
  void Touch();
  /// A move was commanded to there.
  void Move(const std::array<double, 3>& to_mm);

 private:
  bool TakeConfig(const ConsoleLine& line);
  bool TakeAdjustment(const ConsoleLine& line, const std::string& home);
  bool TakeAlignment(const ConsoleLine& line);
  bool TakeCalibration(const ConsoleLine& line);
  void TellAlignment(Imported* imported) const;
  void TellCalibrations(Imported* imported) const;
  void TellHeights(Imported* imported) const;
  void TellDeviations(Imported* imported) const;

  LevellingLog levelling_{};
  ScrewDifferences differences_{};
  std::string section_, key_;
  std::array<double, 2> probe_offset_mm_{kUnknown, kUnknown};
  bool was_levelled_ = false;
  Place forgotten_at_{};  ///< Homing after levelling, and nothing that restores it.
  int lost_accuracy_after_ =
      0;  ///< Differences seen before the first such message; 0: none.
  /// One line of RepRapFirmware's own calibration.
  struct Calibration {
    double factors = 0, after_mm = kUnknown, arm_mm = kUnknown;
  };
  std::vector<Calibration> calibrations_{};
  double arm_mm_ = kUnknown;
  /// G33 of a delta: the height that it set out from, and what the middle read.
  struct Height {
    double height_mm = kUnknown, middle_mm = kUnknown;
  };
  std::vector<Height> heights_{};
  std::vector<double> deviations_mm_{};  ///< G33: "std dev:", once an iteration.

  void TellProbing(Imported* imported) const;
  void TellSigns(Imported* imported) const;
  bool TakePositions(const ConsoleLine& line);

  std::vector<double>
      results_mm_{};  ///< z_offset as a command reported it, once a run.
  std::vector<std::array<double, 2>> touched_at_mm_{};  ///< M114 before each touch.
  std::array<double, 2> at_mm_{kUnknown, kUnknown};     ///< Of the last M114.
  std::array<double, 2> trigger_offset_mm_{0, 0};       ///< G31 X Y.
  bool was_moved_ = false;  ///< Between the last touch and now.
  bool is_zeroed_ = false;  ///< G92 X0 Y0.
  std::array<double, 2> moved_to_mm_{kUnknown, kUnknown};  ///< After that.
  bool has_probed_ = false;
  bool has_homed_backlash_ = false;  ///< M425 measured it.
  Place idle_offset_at_{};  ///< A work offset with its Z still 0 behind a probing.
};

}  // namespace caltwin
