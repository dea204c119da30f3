#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/emulated_controller.h"
#include "sim/firmware/plant.h"
#include "sim/link/gcode.h"
#include "sim/machine/kinds/delta/mesh.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// What Marlin keeps of a delta: one radius, one rod length with a trim a tower, the
/// height of the homed nozzle, and how far each carriage backs off from its endstop to
/// get there (M666, none above 0).
///
///   endstop_i = H - M666_i,  arm_i = L + trim_i,  angle_i = drawn + trim_i
DeltaModel<double> AsMarlinHasIt(const DeltaModel<double>& settings);

/// A controller that understands Marlin's dialect as far as a delta's calibration needs
/// it: G0 G1 G28 G30 G33 G90 G91 M92 M105 M114 M115 M119 M400 M420 M421 M500-M503 M665
/// M666 M851; what printing needs besides (M104, M106 ...) changes nothing. Anything
/// else is answered as Marlin does, `echo:Unknown command: "..."`, but G2, G3, G20 and
/// G92 X Y Z, without which later moves would go elsewhere, are refused. Touches are
/// not lifted by the mesh.
class MarlinDelta final : public EmulatedController {
 public:
  /// Answers G33: its words in, the lines that it prints; settings in place.
  using AutoCalibration = std::function<std::vector<std::string>(
      const GcodeCommand& words, DeltaModel<double>* settings)>;

  /// Told of every touch: the settings in force, and the travel of the carriages at the
  /// trigger, whole steps [mm].
  using Witness = std::function<void(const DeltaModel<double>& settings,
                                     const Vec3<double>& counted_mm)>;

  /// @param steps_per_mm  of the towers
  /// @param plant  a delta's: steps are of travel down from the endstops; borrowed
  MarlinDelta(const DeltaModel<double>& drawn,
              const DeltaModel<double>& settings,
              const std::array<double, 3>& steps_per_mm,
              Plant* plant,
              AutoCalibration g33);

  void SetWitness(Witness witness) { witness_ = std::move(witness); }
  /// Goes straight down at (x, y) as `settings` say until the probe triggers, G33's
  /// way: the motors' travels there, whole steps [mm]. nullopt: out of reach, or no
  /// bed.
  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm);

  Reply Execute(std::string_view line) override;

  const DeltaModel<double>& settings() const { return settings_; }
  int touches() const { return touches_; }
  double machine_time_s() const override { return time_s_; }
  /// M851: of the probe's tip from the nozzle.
  const Vec3<double>& probe_offset_mm() const { return probe_offset_mm_; }
  /// M421 and M420: in force; without nodes where it is switched off.
  DeltaMesh mesh() const { return is_levelling_ ? mesh_ : DeltaMesh{}; }
  /// Of the square that the mesh covers.
  void SetMeshRadius_mm(double radius_mm) { mesh_.radius_mm = radius_mm; }

 private:
  void Take(const DeltaModel<double>& settings);
  Reply Obey(const GcodeCommand& command);
  Reply Keep(int code);  ///< M500 to M502.
  /// Of commands that only tell, or that nothing here minds; else nullopt.
  std::optional<Reply> Tell(const GcodeCommand& command) const;
  Reply Switches() const;  ///< M119.
  /// The motors for a place of the nozzle, in steps.
  Motors StepsAt(const DeltaModel<double>& settings,
                 const Vec3<double>& nozzle_mm) const;
  /// A straight move of the nozzle, or as much of it as comes before the probe
  /// triggers.
  Outcome Go(const DeltaModel<double>& settings,
             const Vec3<double>& from_mm,
             const Vec3<double>& to_mm,
             double feed_mm_s,
             Watch::Kind until = Watch::Kind::kNothing);
  Reply Home();
  Reply Probe(const GcodeCommand& command);
  Reply Move(const GcodeCommand& command);
  Reply Position() const;
  Reply SetGeometry(const GcodeCommand& command);
  Reply SetEndstops(const GcodeCommand& command);
  Reply SetProbeOffset(const GcodeCommand& command);
  Reply SetMeshPoint(const GcodeCommand& command);
  Reply SwitchMesh(const GcodeCommand& command);
  Reply Report() const;
  std::vector<std::string> GeometryLines() const;

  DeltaModel<double> drawn_;
  DeltaModel<double> settings_;
  DeltaModel<double> stored_;  ///< As M500 kept them.
  double height_mm_ = 0;       ///< H: of the homed nozzle, the lowest endstop.
  std::array<double, 3> steps_per_mm_;
  Plant* plant_;
  AutoCalibration g33_;
  Witness witness_{};
  Motors steps_ = Motors::Zero(kNumTowers);  ///< Where the motors were told to be.
  bool is_homed_ = false;
  bool is_relative_ = false;  ///< G91.
  Vec3<double> at_mm_ = Vec3<double>::Zero();
  Vec3<double> probe_offset_mm_ = Vec3<double>::Zero();
  static constexpr double kAtEnd_mm = 1e-6;  ///< So near a carriage is at its endstop.
  static constexpr int kMeshNodes = 7;
  DeltaMesh mesh_{
      .nodes = kMeshNodes,
      .height_mm = std::vector<double>(std::size_t{kMeshNodes} * kMeshNodes, 0)};
  bool is_levelling_ = false;
  double time_s_ = 0;
  int touches_ = 0;
};

}  // namespace caltwin
