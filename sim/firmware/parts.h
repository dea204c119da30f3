#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "sim/firmware/bed_probing.h"
#include "sim/firmware/firmware.h"
#include "sim/firmware/frame.h"
#include "sim/firmware/motion.h"
#include "sim/firmware/words.h"
#include "sim/link/gcode.h"

namespace caltwin {

inline constexpr int kWorkplaces = 9;  // G54 to G59.3
inline constexpr double kDefaultFeed_mm_s = 50;
inline constexpr int kMostLines = 50'000;  // Obeyed because of one line sent.

/// The inside of the firmware. One class, in a file a concern: interpreter.cc (lines,
/// blocks, meta commands), files.cc (macros, storage), moves.cc, bed_probing.cc,
/// settings_commands.cc, reports.cc, object_model.cc.
struct Firmware::Parts {
  using Words = rrf::Words;
  using Value = rrf::Value;
  using Frame = rrf::Frame;

  Parts(const Machine& machine,
        const Settings& settings,
        const FirmwareOptions& options,
        Plant* plant);

  /// @name interpreter.cc
  Reply Execute(std::string_view line);
  Reply ExecuteLine(const GcodeLine& line, Frame* frame);
  Reply ExecuteCommand(const GcodeCommand& command, Frame* frame);
  Reply ExecuteMeta(const GcodeLine& line, Frame* frame);
  /// What names mean to expressions: variables, then the object model.
  rrf::Lookup LookupIn(Frame* frame);
  std::optional<Value> LookUp(const rrf::Path& path, Frame* frame);
  Reply Echo(std::string_view rest, Frame* frame);
  Reply Declare(std::string_view rest, bool is_global, Frame* frame);
  Reply Set(std::string_view rest, Frame* frame);
  /// Settings that live in globals follow them.
  void AdoptGlobals();

  /// @name files.cc
  Reply RunFile(const std::string& path, const std::map<std::string, Value>& params);
  Reply RunMacroLine(std::string_view text, std::size_t* index, Frame* frame);
  /// As after power-up; runs nxt-user-vars.g.
  Reply Start();
  /// Stores text in a file, or behind what it holds.
  void Store(const std::string& path, const std::string& text, bool appends);
  Reply RunMacro(const Words& words);         // M98
  Reply SaveSettings(const Words& words);     // M500
  Reply RestoreSettings(const Words& words);  // M501
  Reply Restart(const Words& words);          // M999

  /// @name moves.cc
  Reply MoveLinear(const GcodeCommand& command, const Words& words);  // G0 G1
  Reply Dwell(const Words& words);                                    // G4
  Reply Home(const Words& words);                                     // G28
  Reply Probe(const GcodeCommand& command, const Words& words);       // G38.2-5
  Reply SetPosition(const Words& words);                              // G92
  Reply SetWorkOffset(const Words& words);                            // G10
  Reply SelectWorkplace(const GcodeCommand& command);                 // G54-G59.3
  Reply WaitForMoves(const Words& words);                             // M400
  Reply EmergencyStop(const Words& words);                            // M112
  Reply MotorsOff(const Words& words);                                // M18 M84
  Vec3<double> Target_mm(const Words& words) const;
  /// Why a move to `target_mm` is refused; empty: it is not.
  std::string_view Refusal(const Words& words, const Vec3<double>& target_mm) const;

  /// @name bed_probing.cc
  Reply ProbeBed(const Words& words);        // G30
  Reply SetDrivers(const Words& words);      // M584
  Reply SetLeadscrews(const Words& words);   // M671
  Reply ReportEndstops(const Words& words);  // M119
  /// Goes down over (x, y) from the dive height, and stays there: the height of the
  /// touch; else why not, empty after an alarm.
  std::optional<double> TouchBed(Vec3<double> over_mm, std::string* why_not);
  Reply AdjustLeadscrews();
  /// Whether all of z's motors can stand there, z at these heights for each.
  bool MayStand(const Vec3<double>& z_mm) const;
  /// Where Z, U and V are to go; why they may not, empty: they may.
  std::string_view SplitTarget(const Words& words, Vec3<double>* to_mm) const;
  void MoveSplit(const Vec3<double>& to_mm);
  void PlaceSplit(const Words& words);  // G92
  bool IsHomed() const;
  Vec3<double> Raised_mm() const;

  /// @name settings_commands.cc
  Reply StepsPerMm(const Words& words);        // M92
  Reply BacklashSettings(const Words& words);  // M425
  Reply SelectTool(const GcodeCommand& command);

  /// @name reports.cc
  Reply ReportPosition(const Words& words);                    // M114
  Reply ReportFirmware(const Words& words);                    // M115
  Reply ReportTemperatures(const Words& words);                // M105
  Reply Say(const GcodeCommand& command, const Words& words);  // M118
  Reply ReportObjectModel(const Words& words);                 // M409

  /// @name object_model.cc
  nlohmann::ordered_json ObjectModel();
  nlohmann::ordered_json AxisModel(Axis axis);
  nlohmann::ordered_json ProbesModel() const;

  /// @name The probe as its wire brings it (options.probe)
  bool HasProbe() const { return options.probe != ProbeInput::kMissing; }
  bool ProbeReads() const {
    if (options.probe != ProbeInput::kWired) return options.probe == ProbeInput::kStuck;
    return plant->ProbeTriggered();
  }
  Watch::Kind WatchOf(Watch::Kind kind) const {
    return options.probe == ProbeInput::kWired ? kind : Watch::Kind::kNothing;
  }

  Vec3<double> offset_mm() const { return workplaces_mm[workplace]; }
  bool is_halted() const { return halted || motion.alarm().has_value(); }

  Machine machine;
  Settings initial_settings;  ///< Before any file was run.
  Settings settings;
  FirmwareOptions options;  ///< Its files are the storage.
  Plant* plant;
  Motion motion;

  bool halted = false;
  bool has_told_alarm = false;
  std::map<std::string, Value> globals{};
  Frame wire{};
  int macro_depth = 0;
  int lines_left = 0;  ///< Of one Execute: an endless loop must end.

  std::array<Vec3<double>, kWorkplaces> workplaces_mm{};
  int workplace = 0;
  bool is_relative = false;
  bool uses_machine_coordinates = false;  ///< G53, until the end of its line.
  bool is_rapid = true;                   ///< The modal command is G0.
  double feed_mm_s = kDefaultFeed_mm_s;
  int tool = -1;
  BedProbing bed{};
};

/// A refusal: "Error: " and the words, which name the command.
Reply Refuse(const std::string& words);
/// Adds `more` behind `reply`.
void Append(Reply more, Reply* reply);

}  // namespace caltwin
