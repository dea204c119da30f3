#include "sim/measure/import/recognise.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "sim/measure/import/bare_grid.h"
#include "sim/measure/import/candle_map.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/drawn_path.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/height_matrix.h"
#include "sim/measure/import/named_heights.h"
#include "sim/measure/import/rotary_table.h"

namespace caltwin {
namespace {

/// What of the lines of a text is looked for.
struct Seen {
  bool is_rows = false, has_console = false, has_settings = false, has_config = false;
};

// Lines that only a console writes, and lines that also stand in a configuration.
Seen Look(const std::string& text) {
  Seen seen;
  bool is_first = true;
  for (const TextLine& line : LinesOf(text)) {
    if (is_first && !line.text.starts_with('#')) {
      is_first = false;
      seen.is_rows = line.text.find("value_mm") != std::string_view::npos &&
                     line.text.find("campaign") != std::string_view::npos;
    }
    const ConsoleLine said = ConsoleLineOf(line.text);
    const std::string& lower = said.lower;
    const auto has = [&](std::string_view words) {
      return lower.find(words) != std::string::npos;
    };
    seen.has_console |=
        ((lower.starts_with("probe at ") || lower.starts_with("probe: at ")) &&
         has("z=")) ||
        lower.starts_with("bed x:") || (has(" of ") && has(": z:")) || has("[prb:") ||
        has("bed probe heights:") || lower.starts_with("stopped at height") ||
        has("bed topography report") || has("g33 auto calibrate") || has("z1-z2=") ||
        has("z2-z1=") || has("delta_analyze") || has("probe: z_offset:") ||
        (has("calibrated ") && has("factors")) ||
        (has("iteration") && has("std dev:")) || has("z-calibration:") ||
        (lower.starts_with("probed ") && has("> ")) ||
        has("average measured backlash") || has(" z_offset: ") ||
        lower.starts_with("[g54:") || lower.starts_with("g92 x0 y0") ||
        has("screws_tilt_calculate") || has("making the following z adjustments") ||
        has("exceed configured limit") || has("leadscrew adjustments made") ||
        has("\"prb\":{") || has("\"sr\":{\"pos") || has("leveling grid") ||
        has("mesh bed level data");
    // grbl: its status, and "$100=250.000".
    seen.has_console |= has("mpos:") || has("wpos:");
    // "$100=640", and as people copy it, "$100    640".
    seen.has_settings |= lower.starts_with("$10") &&
                         lower.find_first_of("0123456789", 4) != std::string::npos &&
                         lower.find_first_of("abcdefghijklmnopqrstuvwxyz") >
                             lower.find_first_of("0123456789", 4);
    const bool is_echo =
        line.text.starts_with("echo:") || Lowered(line.text).starts_with("recv:");
    for (const std::string_view word :
         {"m92", "m665", "m666", "m671", "m208", "m669"}) {
      if (!IsCommand(said, word)) continue;
      seen.has_config = true;
      seen.has_settings |= is_echo;
    }
    seen.has_settings |= IsCommand(said, "m503") || has("steps per unit");
  }
  return seen;
}

// A part of a printer.cfg that another includes: "[probe]" and its keys.
bool IsModule(const std::string& text) {
  int sections = 0, keys = 0, others = 0;
  for (const TextLine& line : LinesOf(text)) {
    if (line.text.starts_with('#') || line.text.starts_with(';')) continue;
    const bool is_section =
        line.text.starts_with('[') && line.text.find(']') != std::string_view::npos;
    const bool is_key = line.text.find_first_of(":=") != std::string_view::npos;
    // What a macro does stands indented below its key.
    const bool is_indented = line.words.front().column > 1;
    sections += is_section ? 1 : 0;
    keys += !is_section && is_key ? 1 : 0;
    others += !is_section && !is_key && !is_indented ? 1 : 0;
  }
  return sections > 0 && keys > 0 && others == 0;
}

// Commands and hardly anything else.
bool IsMacro(const std::string& text) {
  constexpr int kFewest = 3;
  int commands = 0, others = 0;
  for (const TextLine& line : LinesOf(text)) {
    const std::string_view word = line.text;
    if (word.starts_with(';')) continue;
    const bool is_command = word.size() > 1 &&
                            std::string_view("GMTgmt").find(word[0]) != word.npos &&
                            word[1] >= '0' && word[1] <= '9';
    // RepRapFirmware's meta commands.
    constexpr std::array<std::string_view, 11> kMeta = {"if",
                                                        "elif",
                                                        "else",
                                                        "while",
                                                        "break",
                                                        "continue",
                                                        "abort",
                                                        "var",
                                                        "global",
                                                        "set",
                                                        "echo"};
    const std::string first = Lowered(word.substr(0, word.find_first_of(" \t{(")));
    const bool is_meta = std::ranges::find(kMeta, first) != kMeta.end();
    ++(is_command || is_meta ? commands : others);
  }
  return commands >= kFewest && commands >= 4 * others;
}

}  // namespace

std::string KindOfText(const std::string& text, const std::string& name) {
  const std::string lower = Lowered(text);
  const auto has = [&](std::string_view words) {
    return lower.find(words) != std::string::npos;
  };
  const std::string ending =
      Lowered(name.substr(std::min(name.size(), name.rfind('.'))));
  const Seen seen = Look(text);
  if (seen.is_rows) return "rows";
  // A mesh has far more touches than the calibration that it was probed under.
  const bool has_mesh = has("#*# [bed_mesh ") && has("#*# points");
  if (has("#*# [delta_calibrate]") && has("height0") && !has("height0 = -") &&
      !has_mesh)
    return "klipper-delta";
  if (has("#*# [bed_mesh ")) return "klipper-mesh";
  if (has("reprapfirmware height map") || has("xmin,xmax,ymin")) return "rrf-heightmap";
  if (has("<heightmap")) return "xml-heightmap";
  if (has("tgt_data") || ending == ".rtl" || has("fwd1_")) return "iso230-dat";
  if (has("mcu_pos_z") || (has("\"ts\"") && has("\"z\""))) return "klipper-thermal";
  const bool is_plate = has("meas x") && has("nom x");
  if (is_plate || (has("measx") && has("nomx"))) return "cmm-plate";
  if (ending == ".comp" || ending == ".tab") return "screw-table";
  if (!seen.has_console && NoteOfRotaryTable(text)) return "rotary-table";
  if (seen.has_console || seen.has_settings) return "console-log";
  if (CandleMapIn(text)) return "candle-map";
  if (HeightMatrixIn(text)) return "height-matrix";
  if (has("#define") && has("_diag_ac")) return "marlin-config";
  if (has("[stepper_") || has("[printer]") || IsModule(text)) return "printer-cfg";
  if (NoteOfDrawnPath(text)) return "drawn-path";
  if (seen.has_config || IsMacro(text)) return "rrf-config";
  if (!BareGrids(text).empty()) return "console-log";
  if (HasNamedHeights(text)) return "named-heights";
  return "table";
}

}  // namespace caltwin
