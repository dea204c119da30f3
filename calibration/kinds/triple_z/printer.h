#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/loop/probe_reading.h"
#include "sim/link/link.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// What is known of a triple-Z printer before it is asked anything: its drawing.
struct TripleZBench {
  Link* link = nullptr;
  Pivots<double> drawn_mm{};          ///< Where the drawing has the screws.
  double top_mm = 250;                ///< Heights of the screws go from 0 to this.
  Eigen::Vector2d most_mm{235, 235};  ///< Travel of x and y.
  double sigma_mm = 0.01;             ///< Standard uncertainty of one touch.
  /// Whether somebody stated it; else touches are believed to scatter as they do.
  bool is_sigma_stated = true;
};

/// What calibration knows of a printer beforehand. `sigma_mm`: of the probe as stated;
/// a touch is counted in whole steps beside.
TripleZBench BenchOf(const Machine& machine, Link* link, double sigma_mm);

/// Speaks to a triple-Z printer in RepRapFirmware's dialect: probes heights, and moves
/// its screws singly by giving each driver an axis of its own for the move (M584).
///
/// Heights of screws are counted as commands have it, up from the lower endstops. What
/// moves them past this is to be told by Heard or LoseHeights. Faults are the
/// machine's, named; where an answer cannot be read, with the answer.
class TripleZPrinter {
 public:
  explicit TripleZPrinter(const TripleZBench& bench) : bench_(bench) {}

  Expected<void> Home();
  /// Homes where that was not done, or nobody knows where the screws stand any more.
  Expected<void> HomeIfNeeded();
  /// Raises the bed over (x, y) to the nozzle: its height over the nozzle's zero, from
  /// "Stopped at height 0.123 mm". Homes first where that was not done.
  Expected<double> Probe(const Eigen::Vector2d& at_mm);
  Expected<std::vector<BedTouch>> ProbeAll(const std::vector<Eigen::Vector2d>& at_mm);
  /// What its probe reads with the bed lowered halfway, out of any touch.
  ProbeReading ReadProbeClear();
  /// The published move_triple_z: to (x, y), the screws to these heights, 0 .. top
  /// each; homes if that was not done or nobody knows where the screws stand any more,
  /// and waits (M400).
  Expected<void> MoveTripleZ(double x_mm, double y_mm, const Vec3<double>& heights_mm);
  /// Raises each screw by so much beyond where it stands; Z reads as before.
  Expected<void> Raise(const Vec3<double>& raise_mm);
  /// `G30 P0 X Y Z-99999` .. and `S3` with the last: the firmware levels by itself.
  /// What it printed.
  Expected<std::vector<std::string>> Level(const std::vector<Eigen::Vector2d>& at_mm);
  /// A line that somebody else has sent over the same link, and what it does to
  /// heights.
  void Heard(const std::string& line);
  /// Somebody else has moved the screws, nobody knows where to.
  void LoseHeights();
  /// M671: where the firmware shall believe the screws to stand.
  Expected<void> SetPivots(const Pivots<double>& pivots_mm);
  Expected<Pivots<double>> ReadPivots();

  const TripleZBench& bench() const { return bench_; }
  /// How far each screw was raised beyond the others since homing, corrections
  /// that Level's answer names among them.
  const Vec3<double>& raised_mm() const { return raised_mm_; }
  int touches() const { return touches_; }
  /// How often it was homed: what was raised before is undone by it.
  int homings() const { return homings_; }

 private:
  Expected<std::vector<std::string>> Say(const std::string& line);
  Expected<void> SayAll(const std::vector<std::string>& lines);
  Expected<void> NeedHome();
  Expected<void> MoveScrews(const Vec3<double>& up_mm, double z_after_mm);
  Expected<double> StandingZ();
  void CountAdjustments(const std::vector<std::string>& said);

  TripleZBench bench_;
  bool is_homed_ = false;
  bool are_heights_known_ = false;
  bool is_relative_ = false;  ///< Somebody has sent G91.
  /// Of the nozzle over the bed, as the firmware has it; none: it moved by itself.
  std::optional<double> z_mm_{};
  Vec3<double> raised_mm_ = Vec3<double>::Zero();
  int touches_ = 0;
  int homings_ = 0;
  bool is_split_ = false;  ///< A move of single screws broke off: M584 is to be undone.
};

/// The number in "... 0.123 mm" behind "Stopped at height"; nullopt where no line has
/// it.
std::optional<double> StoppedHeight_mm(const std::vector<std::string>& lines);

/// Columns by rows of points between margins, boustrophedon, as printers go.
std::vector<Eigen::Vector2d> ProbeGrid(const TripleZBench& bench,
                                       int columns,
                                       int rows,
                                       double margin_mm);

}  // namespace caltwin
