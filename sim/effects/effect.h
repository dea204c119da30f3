#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/machine/axis.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/machine/machine.h"
#include "sim/measure/climate.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Where in the error chain an effect lives. Motion errors change parts; the others
/// only poison a calibration.
enum class Bucket { kMotion, kMeasurement, kArtefact, kTime };

/// Where in the error chain an effect acts, in the order errors build up: what a later
/// stage sees is what the earlier ones have left.
enum class Stage { kDrive, kFrame, kProbe, kArtefact, kReadout };

/// How diagnosis looks for a parameter.
enum class Role {
  kSize,   ///< The effect is proportional to it.
  kPhase,  ///< An angle [deg] that shares the size: A sin(.. + phase) is two sizes.
  kForm    ///< Changes the shape: sought on a grid (Sight::forms), then refined.
};

/// One number an effect has. Its name ends in its unit and is its key in files; values
/// are in that unit wherever effects are stored, converted only inside closed forms.
struct Parameter {
  std::string_view name;
  std::string_view unit;  ///< As printed: "mm", "um", "mrad", "1/mm".
  double min, max;        ///< Beyond these the model is wrong, not merely unlikely.
  Distribution prior;     ///< What is believed before anything is measured.
  std::string_view doc;   ///< What it is, with its sign.
  Role role = Role::kSize;
  /// Its value where a file names the effect and leaves this out; none: neutral.
  std::optional<double> if_named{};
};

/// How far measured rows reach: what the values of form parameters are sought in.
struct Extent {
  double t_min_s = 0, t_max_s = 0;
  Vec3<double> q_min_mm = Vec3<double>::Zero();
  Vec3<double> q_max_mm = Vec3<double>::Zero();
  /// The same of a delta's or a triple-Z printer's motors.
  Vec3<double> motor_min_mm = Vec3<double>::Zero();
  Vec3<double> motor_max_mm = Vec3<double>::Zero();
  /// Times of the rows that could feel the effect, ascending, each once.
  std::vector<double> times_s{};
};

/// In which channel an effect shows and what it depends on, in CONTRACT's words.
struct Shown {
  std::string channel{};  ///< x y z (motion), a b c (a tower's), probe or bed.
  std::vector<std::string> covariates{};
};

/// How diagnosis looks for an effect in measured rows.
struct Sight {
  Shown (*shown)(std::string_view axis) = nullptr;
  /// What its form parameters may be, each entry one value for each of them in the
  /// declared order. Null: it has none.
  std::vector<std::vector<double>> (*forms)(const Machine& machine,
                                            std::string_view axis,
                                            const Extent& extent) = nullptr;
  /// Harmonics of a periodic effect, as columns of their own: 2 .. this. 0: not so.
  int harmonics = 0;
  /// As `shown`, of a machine whose bed is on screws, where it differs.
  Shown (*shown_on_screws)(std::string_view axis) = nullptr;
  bool shows_at_rest = false;  ///< Also where its covariates do not change.
};

/// The five things a person wants to know of a cause, in that order.
struct Words {
  std::string_view plot;    ///< What to look at, and what it looks like there.
  std::string_view values;  ///< Which number, in which unit, how large is usual.
  std::string_view cause;
  std::string_view effect;  ///< On parts, or on the calibration.
  std::string_view action;
};

/// One way in which a machine differs from its drawing: its declaration. The closed
/// form (templated on the scalar) stands in the same header, as `Add` of the struct
/// that carries the declaration; its act on the physics in `sim/effects/acts`.
struct Effect {
  std::string_view name;   ///< The cause's id in files and JSON.
  std::string_view about;  ///< One sentence.
  Bucket bucket;
  Stage stage;
  /// Allowed after the dot on a cartesian machine; {""}: none. Empty: not there.
  /// Another kind of machine says itself which effects it has (MachineKind::effects).
  std::span<const std::string_view> axes{};
  std::span<const Parameter> parameters;
  std::string_view formula;
  std::string_view source;  ///< Where the model and its typical size come from.
  std::string_view twin;    ///< The cause that looks most like it, and what separates.
  Words words;
  /// The values with which it changes nothing on this machine (the drawing's, or 0).
  void (*neutral)(const Machine& machine,
                  std::string_view axis,
                  std::span<double> values);
  /// Words that files may write in place of axes[0], where there is but one axis.
  std::span<const std::string_view> aliases{};
  /// What diagnosis may find; none: baseline, or injected only.
  std::optional<Sight> sight{};
};

/// In `axes`: any word, such as an artefact's id.
inline constexpr std::string_view kAnyAxis = "*";

/// The screws under a bed, after the dot.
inline constexpr std::array<std::string_view, 3> kScrewAxes = {"z1", "z2", "z3"};

/// What a reading over a bed on screws has beside its pose.
struct ScrewsAt {
  /// Commanded heights of the screws with the nozzle at `stated_z_mm`; all three go
  /// down as it rises.
  Vec3<double> stated_mm = Vec3<double>::Zero();
  double stated_z_mm = 0;
  Vec3<double> motor_dir = Vec3<double>::Zero();  ///< Sense of each in the approach.
  Pivots<double> drawn_mm{};                      ///< Where the screws are drawn.
  Vec3<double> weights = Vec3<double>::Zero();    ///< ScrewWeights there, by that.
  double off_mm = 0;  ///< Nozzle over bed by its motors, less commanded.
  /// Read by a gauge on the frame: what the gantry does, it does not feel.
  bool is_fixed = false;
};

/// What drives that move the axes together did before a reading.
struct DrivesAt {
  const DriveMap* map = nullptr;                ///< Never null.
  Vec3<double> dir = Vec3<double>::Zero();      ///< Sense of each drive's last move.
  Vec3<double> home_mm = Vec3<double>::Zero();  ///< Where each stood when homed.
};

struct LinkageAt;

/// Where and under which circumstances an error is asked for: what is known of one
/// reading, none of it a parameter.
struct At {
  RowKind kind = RowKind::kTouch;
  std::optional<ZReading> station{};  ///< At a printer's station.
  bool is_wiped = false;              ///< Its nozzle was, just before.
  /// Commanded tip position [mm], machine axes; for a touch that at the trigger.
  Vec3<double> q_mm = Vec3<double>::Zero();
  /// Sense of the last move of each axis, -1 .. 1 (between while it crosses its gap).
  Vec3<double> dir = Vec3<double>::Zero();
  /// Outward surface normal, or the direction in which a gauge reads. Unit.
  Vec3<double> n = Vec3<double>::Zero();
  /// Steps per mm (0: as drawn) and backlash compensation that the command was given
  /// with.
  Vec3<double> steps_per_mm = Vec3<double>::Zero();
  Vec3<double> compensation_mm = Vec3<double>::Zero();
  double tip_radius_cfg_mm = 0;
  double feed_mm_s = 0;      ///< Along the path; negative for a release.
  double load_n = kUnknown;  ///< Axial load; unknown: the rail's own friction.
  bool on_table = false;     ///< What is touched stands on the table (bed, artefacts).
  std::string_view setup{};  ///< Placement; each has its own offset.

  /// Time in the session [s]; where rows know none, their running number.
  double t_s = 0;
  /// When the homing session began; the first began before anything.
  double homed_at_s = -std::numeric_limits<double>::infinity();
  std::string_view home{};
  const Climate* climate = nullptr;  ///< Temperatures of the session; borrowed.
  /// Travel of each axis since its last reversal, kUnknown where not known.
  Vec3<double> since_rev_mm = Vec3<double>::Constant(kUnknown);
  double probe_angle_deg = 0;  ///< Spindle, counter-clockwise from above.
  /// Tip minus where the axes stand; `q_mm` are the axes.
  Vec3<double> probe_off_mm = Vec3<double>::Zero();
  std::string_view artefact{};  ///< Its id: the feature's word before the dot.
  bool inside = false;          ///< A bore or pocket: a larger one recedes along -n.
  double artefact_turn_deg = 0;
  /// Middle of what was touched of the artefact in this setup, machine axes.
  Vec3<double> artefact_mid_mm = Vec3<double>::Zero();
  double radius_mm = 0;  ///< Of a ball-bar's circle; 0: none.
  /// How far out the outermost touch of a round bed lies; 0: the bed fills the travel.
  double rim_mm = 0;
  /// Where the tip follows the motors by a chain of links; null: axis by axis.
  /// Borrowed.
  const LinkageAt* linkage = nullptr;
  std::optional<ScrewsAt> screws{};  ///< Over a bed on screws.
  /// Where drives move the axes together; then what belongs to a drive has its index:
  /// `steps_per_mm`, `compensation_mm`.
  std::optional<DrivesAt> drives{};

  /// Where the tip's centre (or what a gauge looks at) is by command, machine axes.
  Vec3<double> Tip_mm() const { return q_mm + probe_off_mm; }
};

/// All errors at one place, summed over the effects. Signs as in docs/signs.md.
template <typename T>
struct Errors {
  Vec3<T> steps_per_mm = Vec3<T>::Zero();  ///< True, by drive.
  Vec3<T> motion_mm = Vec3<T>::Zero();     ///< Tip: actual minus commanded.
  /// By drive, full width; acts as -dir * width / 2.
  Vec3<T> lost_motion_mm = Vec3<T>::Zero();
  /// @name Carriages of a delta (+ down), drives that move the axes together
  Vec3<T> motor_mm = Vec3<T>::Zero();              ///< Moved less commanded.
  Vec3<T> motor_lost_motion_mm = Vec3<T>::Zero();  ///< Full width, by motor_dir.
  /// @name Screws under a bed (+ up)
  Vec3<T> screw_mm = Vec3<T>::Zero();              ///< Moved less commanded.
  Vec3<T> screw_lost_motion_mm = Vec3<T>::Zero();  ///< Full width, by their senses.
  /// Where they stand less where they are drawn.
  Eigen::Matrix<T, 2, 3> pivot_off_mm = Eigen::Matrix<T, 2, 3>::Zero();
  /// Of a bed on screws: turning stiffness of what holds it level over the axial
  /// stiffness of one screw's support.
  T held_mm2 = T(0);
  /// Stylus deflection at the trigger for a tip pushed towards + and - of each axis, so
  /// [axis][0] counts where the machine moves in + (normal towards -).
  std::array<std::array<T, 2>, 3> pretravel_mm{};
  /// Deflection at the trigger beyond `pretravel_mm`, for the direction asked for.
  T more_pretravel_mm = T(0);
  T latency_s = T(0);      ///< From the switch to the reported step count.
  T scatter_mm2 = T(0);    ///< Variance of the trigger along n.
  T tip_radius_mm = T(0);  ///< Built.
  T artefact_mm = T(0);    ///< Surface: actual minus nominal, along n.
  /// @name Of a printer's station
  T nozzle_mm = T(0);   ///< The nozzle is longer.
  T ooze_mm = T(0);     ///< Plastic under its tip where it meets the switch.
  T trigger_mm = T(0);  ///< Body over what the knob touches: built less configured.
};

/// What a closed form is given. `q_mm` is where the axes truly stand: the commanded
/// position for the drive's own effects, with the drive's errors added for later
/// stages.
template <typename T>
struct Asked {
  std::span<const T> p;   ///< The effect's values, in file units, as declared.
  std::string_view axis;  ///< As declared: "x", "x+", "C0Y", "" ...
  const Machine& machine;
  const At& at;
  Vec3<T> q_mm;
};

/// One effect with values: on the axis named, in file units, in the order declared.
template <typename T>
struct Valued {
  int effect = 0;      ///< Index in the catalog.
  std::string axis{};  ///< "x", "x+", "C0Y", "" ...
  std::vector<T> values{};
};

/// As scenarios inject them.
using Injected = Valued<double>;

}  // namespace caltwin
