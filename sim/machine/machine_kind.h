#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/machine/drive_map.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What may stand after the dot of an effect's name on one kind of machine.
struct KindEffect {
  std::string_view effect;
  std::span<const std::string_view> axes;
};

/// A drive as the header of a data file states it.
struct DrawnDrive {
  std::string name{};  ///< "x", "a", "z1" ...
  double lead_mm = 0;  ///< Of a belt its pulley's circumference.
  bool is_belt = false;
  double full_steps_per_rev = 0;
};

/// Where a machine's tip stands once it is homed, in which sense each axis came there,
/// and how far it is taken to have come.
struct Homed {
  Vec3<double> q_mm = Vec3<double>::Zero();
  Vec3<double> sense = Vec3<double>::Zero();
  Vec3<double> since_rev_mm = Vec3<double>::Zero();
  std::optional<Vec3<double>> motor_sense{};  ///< Of motors that are no axes.
};

/// Why a machine cannot stand somewhere, and what to do about it.
struct OutOfReach {
  std::string text{}, hint{};
};

/// One kind of machine: what its file says, what its axes and motors do when told to go
/// somewhere, and which effects it has. Without state, one object a kind; the list is
/// sim/machine/kinds/kinds.cc. What is not overridden is as on a cartesian machine.
class MachineKind {
 public:
  MachineKind() = default;
  MachineKind(const MachineKind&) = delete;
  MachineKind& operator=(const MachineKind&) = delete;
  virtual ~MachineKind() = default;

  /// The word of `kinematics:` in files.
  virtual std::string_view name() const = 0;
  /// What such a machine is, and which commands know it.
  virtual std::string_view about() const = 0;
  /// Behind what holds there alone: " on a delta".
  virtual std::string_view where() const { return ""; }
  /// Whether it has a tip that measures and goes to places; single motors have none.
  virtual bool has_tip() const { return true; }
  /// Whether each axis has a drive of its own, so that what a motor does wrong shows
  /// along it.
  virtual bool axes_are_drives() const { return false; }
  /// Whether x, y and z have travels, senses and steps/mm of their own.
  virtual bool moves_along_axes() const { return true; }
  /// Where its drives move the axes together; null: each axis has a drive of its own,
  /// or they are moved by no linear map.
  virtual const DriveMap* drive_map() const { return nullptr; }
  /// The kinds as which its campaigns are planned; empty: as its own.
  virtual std::span<const std::string_view> plans_as() const { return {}; }
  /// Its motors that are no axes, in the order of a row's motor_ columns.
  virtual std::span<const std::string_view> motors() const { return {}; }
  /// Whether its nozzle is what touches; else a probe with a ball does.
  virtual bool touches_with_nozzle() const { return true; }
  /// Whether its bed stands on screws, each with a motor.
  virtual bool bed_is_on_screws() const { return false; }
  /// How many motors carry z, each with a switch of its own.
  int num_z_motors() const { return bed_is_on_screws() ? 3 : 1; }
  /// The effects that it has; empty: all that a cartesian machine has.
  virtual std::span<const KindEffect> effects() const { return {}; }
  /// Whether it has what effects() does not name as a cartesian machine does.
  virtual bool has_other_effects() const { return effects().empty(); }

  /// How far the tip hangs below what may lean: a delta's joints. 0: nothing may.
  virtual double TipBelowJoints_mm(const Machine& machine) const;

  /// @name Its file, in the order in which it is read
  /// What only this kind has, into Machine::own.
  virtual void ReadDrawing(YamlMap* map, Machine* machine) const;
  virtual void ReadAxes(YamlMap* map, Machine* machine) const;
  /// The probe where the file says nothing.
  virtual ProbeDrawing ProbeAsDrawn() const { return {}; }
  virtual void ReadSettings(YamlMap* map, Machine* machine) const;

  /// @name Where it goes, as far as commands say
  virtual std::vector<DrawnDrive> Drives(const Machine& machine) const;
  virtual Homed AtHome(const Machine& machine) const;
  /// The middle of its work space [mm].
  virtual Vec3<double> Middle_mm(const Machine& machine) const;
  /// nullopt: it can stand there.
  virtual std::optional<OutOfReach> WhyNotAt(const Machine& machine,
                                             const Vec3<double>& q_mm) const;
  /// What its motors that are no axes are told for this pose, `raised_mm` beyond what
  /// it takes; nullopt: it has none.
  virtual std::optional<Vec3<double>> Motors_mm(const Machine& machine,
                                                const Vec3<double>& q_mm,
                                                const Vec3<double>& raised_mm) const;
  /// What the screws under its bed are told for this pose, where the motors above are
  /// others; nullopt: they are not, or it has none.
  virtual std::optional<Vec3<double>> Screws_mm(const Machine& machine,
                                                const Vec3<double>& q_mm,
                                                const Vec3<double>& raised_mm) const;
  /// The sense of each of them at the end of a straight move: -1, 0 (still) or 1.
  virtual std::optional<Vec3<double>> MotorSenses(const Machine& machine,
                                                  const Vec3<double>& from_mm,
                                                  const Vec3<double>& to_mm) const;
};

/// A motion below this is none [mm].
inline constexpr double kStill_mm = 1e-9;

/// Reads one axis over `drawing`, which holds for what the map leaves out.
/// `needs_lead`: the file must give its lead.
AxisDrawing ReadAxis(Axis axis, YamlMap map, AxisDrawing drawing, bool needs_lead);

}  // namespace caltwin
