#pragma once

#include <string>
#include <vector>

#include "calibration/estimate/touch_noise.h"
#include "calibration/loop/bench.h"
#include "calibration/loop/controller.h"
#include "calibration/loop/face.h"

namespace caltwin {

/// How one face is to be touched.
struct TouchPlan {
  int repeats = 1;
  double feed_mm_s = 0;  ///< Of the measuring touch; 0: the probe's slow one.
  bool release = false;  ///< Back off by G38.4 and read where it lets go.
  /// Before a release: push the stylus on by so much, so that the switch's scatter
  /// cannot open it before the machine has turned.
  double push_on_mm = 0;
  std::string campaign{};  ///< As the rows say it.
};

/// What the repeated touches of one face read, along its outward normal [mm]:
/// (tip centre - nominal) . n - R_cfg, as the rows hold it.
struct Touched {
  Face face{};
  std::vector<double> trigger_mm{};
  std::vector<double> release_mm{};  ///< Tip centre likewise; as many, or none.
};

/// Touches faces over a link and writes every reading down.
///
/// Travels up to a safe height, over, and down in front of a face, never through an
/// artefact; so far off that steps/mm wrong by 8 % still end in the air. Approaches
/// fast, backs off, comes again slowly. Before every touch it moves on in the same
/// sense for more than ten times the backlash compensation, over which RepRapFirmware
/// spreads it.
class Probing {
 public:
  Probing(Bench* bench, Controller* controller);

  /// Homes if the machine says it is not, and reads settings.
  Expected<void> Prepare();
  Expected<void> Home();
  Expected<Touched> Touch(const Face& face, const TouchPlan& plan);
  /// Up to the safe height.
  Expected<void> Raise();
  /// As far up as the axis goes: room for whatever is put down next.
  Expected<void> RaiseToTop();
  /// Up, over, down: to where the tip stands off `off_mm` from the face along its
  /// normal.
  Expected<void> GoBefore(const Face& face, double off_mm);
  /// Where a touch of that face would be started [mm off it].
  double StandOff_mm(const Face& face) const;

  /// What blurs one touch along `axis`: the probe's sigma, and the motor's step.
  TouchNoise Noise(Axis axis) const;
  double SafeHeight_mm() const;
  /// Longest way over which a compensation of the axes in `n` is spread, with reserve.
  double LeadIn_mm(const Vec3<double>& n) const;
  int touches() const { return touches_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// Adds a reading that was not taken by the probe.
  void Record(Row row);
  /// Id of the settings in force, for rows.
  std::string SettingsId();
  std::string HomeId() const;
  /// Placement of an artefact: its id, then with the number of times it was put down.
  std::string SetupId(const std::string& artefact) const;
  /// Placement that a touch of the face shares: "table" for the tops of what stands on
  /// it.
  std::string SetupOf(const Face& face) const;

 private:
  Vec3<double> Start_mm(const Face& face, double off_mm) const;
  Expected<void> TouchOnce(const Face& face, const TouchPlan& plan, Touched* touched);
  Expected<void> ReleaseOnce(const Face& face, const TouchPlan& plan, Touched* touched);
  Vec3<double> Within(Vec3<double> target_mm) const;
  Row RowOf(const Face& face, const TouchPlan& plan) const;

  Bench* bench_;
  Controller* controller_;
  std::vector<Row> rows_{};
  int touches_ = 0;
};

}  // namespace caltwin
