#pragma once

#include <string>
#include <string_view>

#include "calibration/diagnosis/controller.h"
#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// Writes what a controller's own settings can do against what was found, as every kind
/// of machine has it: steps/mm and play of one drive, comments, findings that none of
/// them carries. What only one kind sets it adds as lines.
class CorrectionText {
 public:
  /// `diagnosis` is borrowed.
  CorrectionText(ControllerKind controller, const Diagnosis& diagnosis);

  ControllerKind controller() const { return controller_; }
  bool is_gcode() const { return is_gcode_; }
  std::string text() const { return text_; }

  void Comment(const std::string& words);
  /// Lines as they are, with their line ends.
  void Add(const std::string& lines) { text_ += lines; }
  /// A setting, with where it comes from: behind it in G-code, above it in a file.
  void Set(const std::string& setting, const std::string& source);

  /// The baseline's line of that name; null: there is none.
  const BaselineLine* Fitted(std::string_view name) const;
  /// Whether two standard deviations tell it from `believed`.
  static bool IsTold(const BaselineLine& line, double believed = 0);
  /// Whether it is told from 0; if not, a comment says so.
  bool IsToBeSet(const BaselineLine& line);

  /// What moves too far by `error` gets steps/mm / (1 + error).
  /// @param letter  of the drive in G-code
  /// @param steps_a_turn  for Klipper's rotation_distance
  void SetSteps(char letter,
                double old_per_mm,
                double error,
                double steps_a_turn,
                const std::string& source);
  /// The play of a drive, by what the baseline has of it.
  void SetPlay(char letter, const BaselineLine& play);
  /// That nothing here carries a finding, and what to do instead.
  void LeaveOver(const Finding& finding);

 private:
  ControllerKind controller_;
  const Diagnosis& diagnosis_;
  bool is_gcode_;
  std::string text_{};
};

/// "pivot_position.z2, dx_mm +1.2 +- 0.1": a finding with its numbers.
std::string SaidOf(const Finding& finding);

}  // namespace caltwin
