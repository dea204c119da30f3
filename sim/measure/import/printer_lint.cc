#include "sim/measure/import/printer_lint.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/printer_cfg.h"
#include "sim/measure/import/square_lengths.h"

namespace caltwin {
namespace {

constexpr double kMost = 1e6;

FileNote Setting(const std::string& what,
                 const std::string& sentence,
                 const Place& place) {
  return {.kind = FileNote::Kind::kSetting,
          .what = what,
          .sentence = sentence,
          .place = place};
}

// Drives that are alike in everything else: the towers of a delta, the Z motors.
void AddUnequalSteps(const PrinterCfg& cfg,
                     const std::vector<std::string>& sections,
                     std::vector<FileNote>* notes) {
  constexpr double kAlike = 0.1;
  for (const char* key :
       {"step_distance", "rotation_distance", "microsteps", "gear_ratio"}) {
    std::map<std::string, double> values;
    Faults faults;
    for (const std::string& section : sections) {
      const auto value = cfg.Number(section, key, 1e-9, kMost, &faults);
      if (value) values[section] = *value;
    }
    if (values.size() < 2) continue;
    // The odd one out: the others agree.
    for (const auto& [section, value] : values) {
      std::optional<double> others;
      bool agree = true;
      for (const auto& [other, their] : values) {
        if (other == section) continue;
        agree &= !others || std::abs(their / *others - 1) < kAlike;
        others = their;
      }
      if (!others || !agree || std::abs(value / *others - 1) < kAlike) continue;
      if (values.size() == 2 && section != values.rbegin()->first) continue;
      notes->push_back(Setting(
          key,
          fmt::format(
              "[{}] {} is {:g}, that of its fellows {:g}: it moves {:.3g} times as "
              "many steps as it should. Equal drives have equal values; set it to {:g}",
              section,
              key,
              value,
              *others,
              std::string_view(key) == "microsteps" ? value / *others : *others / value,
              *others),
          PlaceOf(cfg.Find(section, key)->value, cfg.name())));
    }
  }
}

void AddProbeSign(const PrinterCfg& cfg, std::vector<FileNote>* notes) {
  Faults faults;
  for (const char* section : {"probe", "bltouch"}) {
    const auto offset_mm = cfg.Number(section, "z_offset", -kMost, kMost, &faults);
    if (!offset_mm || *offset_mm > -1) continue;
    const bool is_delta = !cfg.Sections("delta_calibrate").empty() ||
                          cfg.Find("stepper_a", "arm_length") != nullptr;
    notes->push_back(Setting(
        "z_offset",
        fmt::format(
            "z_offset is {:g}: it has the wrong sign. It is the height of the nozzle "
            "above the bed where the probe triggers, above 0 for a probe that hangs "
            "lower than the nozzle: {:g}. {}",
            *offset_mm,
            -*offset_mm,
            is_delta ? fmt::format("The saved endstops are too low by twice that, {:g} "
                                   "mm; calibrate again after",
                                   -2 * *offset_mm)
                     : "Correct it, then probe again"),
        PlaceOf(cfg.Find(section, "z_offset")->value, cfg.name())));
  }
}

// With the probe as the switch of Z, both say where the nozzle is when it triggers.
void AddVirtualEndstop(const PrinterCfg& cfg, std::vector<FileNote>* notes) {
  constexpr double kAlike_mm = 0.05;
  Faults faults;
  const auto* pin = cfg.Find("stepper_z", "endstop_pin");
  const auto endstop_mm =
      cfg.Number("stepper_z", "position_endstop", -kMost, kMost, &faults);
  if (pin == nullptr || !endstop_mm ||
      Lowered(pin->value.text).find("z_virtual_endstop") == std::string::npos) {
    return;
  }
  for (const char* section : {"probe", "bltouch"}) {
    const auto offset_mm = cfg.Number(section, "z_offset", -kMost, kMost, &faults);
    if (!offset_mm || std::abs(*offset_mm - *endstop_mm) < kAlike_mm) continue;
    const double off_mm = *offset_mm - *endstop_mm;
    FileNote note = Setting(
        "position_endstop",
        fmt::format(
            "position_endstop is {0:g} and the probe's z_offset {1:g}: with the probe "
            "as "
            "the switch of Z both say how high the nozzle stands when it triggers. "
            "Newer "
            "Klipper takes z_offset and refuses this line; a version that takes this "
            "line has the nozzle {2:g} mm {3} than believed: all of Z is off by a "
            "constant of {2:g} mm, and no layer by a factor, so leave the steps. "
            "Remove "
            "position_endstop, or, where an old version asks for it, set it to {1:g}",
            *endstop_mm,
            *offset_mm,
            std::abs(off_mm),
            off_mm > 0 ? "higher" : "lower"),
        PlaceOf(cfg.Find("stepper_z", "position_endstop")->value, cfg.name()));
    note.fact = "offset";
    note.axis = "z";
    note.word = "zero";
    note.figures = {{"change_um", UmFromMm(off_mm)}};
    notes->push_back(std::move(note));
  }
}

}  // namespace

std::vector<FileNote> NotesOfPrinterCfg(const std::string& text,
                                        const std::string& name) {
  const PrinterCfg cfg(text, name);
  std::vector<FileNote> notes;
  AddUnequalSteps(cfg, {"stepper_a", "stepper_b", "stepper_c"}, &notes);
  AddUnequalSteps(cfg, {"stepper_z", "stepper_z1", "stepper_z2", "stepper_z3"}, &notes);
  AddProbeSign(cfg, &notes);
  AddVirtualEndstop(cfg, &notes);
  return notes;
}

namespace {

// "cube 20x20x20 measured: 20.04 x 19.97 x 40.1"
void AddSizes(const std::string& text, const std::string& name, Imported* imported) {
  for (const TextLine& line : LinesOf(text)) {
    const std::size_t at = line.text.find("measured");
    if (at == std::string_view::npos) continue;
    const auto nominal = NumbersApart(line.text.substr(0, at));
    const auto measured = NumbersApart(line.text.substr(at));
    if (nominal.size() != 3 || measured.size() != 3) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      Row row{.campaign = "sizes", .place = PlaceOf(line.words.front(), name)};
      row.cmd_mm[k] = nominal[k];
      row.n = {0, 0, 0};
      row.n[k] = 1;
      row.value_mm = measured[k] - nominal[k];
      imported->table.rows.push_back(row);
    }
    imported->is_deviation = imported->has_unit = true;
    imported->recognised.emplace_back("sizes of a part beside a configuration");
  }
}

}  // namespace

Imported ReadPrinterCfg(const std::string& text,
                        const std::string& name,
                        const ImportOptions& /*options*/) {
  Imported imported;
  imported.notes = NotesOfPrinterCfg(text, name);
  AddSizes(text, name, &imported);
  if (imported.notes.empty() && imported.table.rows.empty()) {
    throw InputError(
        {.file = name, .line = 1, .column = 1},
        "a configuration without measurements, and nothing in it contradicts "
        "itself",
        "saved calibrations and meshes (#*# lines) are read, and console logs");
  }
  return imported;
}

namespace {

/// A defined number: as it stands, and whether a comma stood for its dot.
struct Defined {
  double value = 0;
  bool has_comma = false;
  Place place{};
};

std::map<std::string, Defined> DefinesIn(const std::string& text,
                                         const std::string& name) {
  std::map<std::string, Defined> defines;
  for (const TextLine& line : LinesOf(text)) {
    if (line.words.size() < 3 || line.words[0].text != "#define") continue;
    std::string word = line.words[2].text;
    const std::size_t comma = word.find(',');
    if (comma != std::string::npos) word[comma] = '.';
    const auto value = NumberOf(word);
    if (!value) continue;
    defines[line.words[1].text] = {
        *value, comma != std::string::npos, PlaceOf(line.words[2], name)};
  }
  return defines;
}

struct Square {
  const char* letters = nullptr;
  std::size_t first = 0, second = 1;
};
constexpr std::array kSquares = {
    Square{"XY", 0, 1}, Square{"XZ", 0, 2}, Square{"YZ", 1, 2}};

void AddSquare(const Square& square,
               const std::map<std::string, Defined>& defines,
               Imported* imported) {
  const std::string letters = square.letters;
  const auto find = [&](const std::string& part) {
    const auto found = defines.find(letters + part);
    return found == defines.end() ? nullptr : &found->second;
  };
  const Defined *ac = find("_DIAG_AC"), *bd = find("_DIAG_BD"), *ad = find("_SIDE_AD");
  const Defined* factor = find("_SKEW_FACTOR");
  if (ac == nullptr || bd == nullptr) return;
  if (factor != nullptr) {
    imported->notes.push_back(Setting(
        letters + "_SKEW_FACTOR",
        fmt::format(
            "{0}_SKEW_FACTOR {1:g} overrides the measured lengths: they have no "
            "effect. Leave the line out",
            letters,
            factor->value),
        factor->place));
  }
  if (ad == nullptr) {
    imported->notes.push_back(
        {.kind = FileNote::Kind::kOpen,
         .what = "skew." + letters,
         .sentence = fmt::format(
             "the skew of {}: the side AD of that square is missing, and the "
             "firmware would "
             "take its default. The diagonals differ by {:.2g} mm; measure that side",
             letters,
             std::abs(ac->value - bd->value))});
    return;
  }
  std::array<double, 3> a{}, b{}, c{}, d{};
  const double side_mm = ad->value;
  b[square.second] = c[square.second] = side_mm;  // A near left, B far left.
  c[square.first] = d[square.first] = side_mm;
  AddLength("square_" + letters, "AD", {a, d}, ad->value, ad->place, imported);
  AddLength("square_" + letters, "AC", {a, c}, ac->value, ac->place, imported);
  AddLength("square_" + letters, "BD", {b, d}, bd->value, bd->place, imported);
}

}  // namespace

Imported ReadMarlinConfig(const std::string& text,
                          const std::string& name,
                          const ImportOptions& /*options*/) {
  const std::map<std::string, Defined> defines = DefinesIn(text, name);
  Imported imported;
  for (const auto& [key, defined] : defines) {
    if (!defined.has_comma) continue;
    imported.notes.push_back(Setting(
        key,
        fmt::format(
            "{} is written with a comma: the compiler reads only what stands before "
            "it. Write {:g}",
            key,
            defined.value),
        defined.place));
  }
  for (const Square& square : kSquares) AddSquare(square, defines, &imported);
  if (imported.table.rows.empty() && imported.notes.empty()) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no lengths of a square stand here",
                     "#define XY_DIAG_AC 141.4, XY_DIAG_BD, XY_SIDE_AD");
  }
  imported.recognised = {
      "lengths of a square in a Configuration.h of Marlin: A to C runs from "
      "front left to rear right"};
  imported.has_unit = true;
  return imported;
}

}  // namespace caltwin
