#pragma once

#include <array>
#include <vector>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// What a console of grbl tells of its own arithmetic: positions rounded to whole
/// steps, probings reported in inches, a rest beyond the contact, a zero set where the
/// axis came to rest in place of where it touched. None of them is the machine's fault.
class GrblStory {
 public:
  void Take(const ConsoleLine& line);
  void Tell(Imported* imported) const;
  /// Motors that are off between moves, where readings drift pause by pause.
  void TellIdle(Imported* imported) const;

 private:
  void TakeMove(const ConsoleLine& line);
  void TakeProbingMove(const ConsoleLine& line);
  void TakeProbing(const ConsoleLine& line);
  void TakeStatus(const ConsoleLine& line);
  void TakeExtents(const ConsoleLine& line);
  void TellExtents(Imported* imported) const;
  void TellSteps(Imported* imported) const;
  void TellUnit(Imported* imported) const;
  void TellZero(Imported* imported) const;
  void TellPlaces(Imported* imported) const;
  void TellRest(Imported* imported) const;
  void TakeRest(const std::array<double, 3>& at_mm);

  /// A move between two reports of the position: told and reported [mm].
  struct Reported {
    std::size_t axis = 0;
    double told_mm = 0, moved_mm = 0, at_mm = 0;
  };
  std::array<double, 3> steps_per_mm_{kUnknown, kUnknown, kUnknown};
  double idle_ms_ = kUnknown;  ///< $1: after so long the motors are switched off.
  bool has_pauses_ = false;
  bool is_relative_ = false;
  std::array<double, 3> told_mm_{};         ///< Since the last report.
  std::array<double, 3> since_probe_mm_{};  ///< Told since the last probing.
  std::array<bool, 3> is_probed_{};         ///< Moved by a probing since then.
  std::array<double, 3> reported_mm_{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> probe_{kUnknown, kUnknown, kUnknown};  ///< As reported.
  double touch_mm_ = kUnknown;                                 ///< Z of the last touch.
  double zero_mm_ = kUnknown;  ///< Z as told by G10 L20, until it is reported.
  /// Of a loaded program, and of the map that was touched, along x and y.
  std::array<double, 2> program_mm_{}, touched_{};
  std::vector<Reported> moves_{};
  std::vector<Reported> probings_{};  ///< `moved_mm` as reported, unit unknown.
  std::vector<double> zeros_mm_{};    ///< Zero less touch.
  /// Where the last G0 or G1 was told to go; kUnknown: relative, or by a probing.
  std::array<double, 3> to_mm_{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> work_zero_mm_{};  ///< G54.
  std::vector<Reported> places_{};        ///< Told and reported places of touches.
  std::size_t probed_axis_ = 2;
  double probed_sense_ = 0;         ///< Of the last G38; 0: not known, or it is over.
  double probed_to_mm_ = kUnknown;  ///< Where it was to end; kUnknown: relative.
  double probing_mm_min_ = kUnknown;
  std::vector<double> beyond_mm_{};  ///< Rest less contact, along the probing.
};

}  // namespace caltwin
