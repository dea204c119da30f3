#include "sim/measure/import/console_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/bare_grid.h"
#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/candle_map.h"
#include "sim/measure/import/climb.h"
#include "sim/measure/import/console_grid.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/console_settings.h"
#include "sim/measure/import/console_story.h"
#include "sim/measure/import/corner_speed.h"
#include "sim/measure/import/drive_steps.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/grbl_story.h"
#include "sim/measure/import/plain_table.h"
#include "sim/measure/import/pulse_rate.h"
#include "sim/measure/import/reported_move.h"
#include "sim/measure/import/rrf_limit.h"
#include "sim/measure/import/steps_between.h"
#include "sim/measure/import/switch_story.h"
#include "sim/measure/import/text_table.h"
#include "sim/measure/import/touch_offset.h"
#include "sim/measure/import/unmeasured_lines.h"
#include "sim/measure/import/update_between.h"

namespace caltwin {
namespace {

constexpr const char* kSettings = "m503";
constexpr const char* kAxes = "xyz";

/// Whether a line says that the bed or gantry was moved by its own motors.
bool IsLevelling(const ConsoleLine& line) {
  constexpr std::array<std::string_view, 5> kCommands = {
      "g32", "g34", "z_tilt_adjust", "quad_gantry_level", "screws_tilt_calculate"};
  if (line.lower.find("heights:") != std::string::npos) return false;
  return std::ranges::any_of(kCommands,
                             [&](auto word) { return IsCommand(line, word); }) ||
         line.lower.starts_with("making the following z adjustments") ||
         line.lower.starts_with("leadscrew adjustments made");
}

/// A line and the time beside it or on a line of its own before it.
struct TimedLine {
  TextLine line{};
  double t_s = kUnknown;
};

// The first line last, where no time is later than the one before it.
std::vector<TimedLine> InOrderOfTime(std::vector<TextLine> lines) {
  constexpr int kFewest = 3;
  std::vector<TimedLine> timed;
  double alone_s = kUnknown, before_s = kUnknown;
  int falls = 0, rises = 0;
  for (TextLine& line : lines) {
    const ConsoleLine said = ConsoleLineOf(line.text);
    if (said.text.empty() && Known(said.t_s)) {
      alone_s = said.t_s;
      continue;
    }
    const double t_s = Known(said.t_s) ? said.t_s : alone_s;
    if (Known(said.t_s)) alone_s = kUnknown;
    timed.push_back({std::move(line), t_s});
    if (!Known(t_s)) continue;
    if (Known(before_s)) (t_s < before_s ? falls : rises) += t_s == before_s ? 0 : 1;
    before_s = t_s;
  }
  if (falls >= kFewest && rises == 0) std::ranges::reverse(timed);
  return timed;
}

/// What the terminal last said of the heaters.
struct Heaters {
  double nozzle_c = kUnknown, bed_c = kUnknown;

  void Take(const ConsoleLine& line) {
    const auto after = [&](const char* key, double* temp_c) {
      const std::size_t at = line.lower.find(key);
      if (at == std::string::npos) return;
      const auto value = NumberAfter(std::string_view(line.lower).substr(at), key);
      if (value) *temp_c = *value;
    };
    // "T:210.1 /210.0 B:60.0 /60.0", "B:60.1 /60.0 T0:24.9 /0.0"
    if (line.lower.find(" /") == std::string::npos) return;
    after("b:", &bed_c);
    after("t:", &nozzle_c);
    after("t0:", &nozzle_c);
  }
};

// Whether a word stands alone anywhere in a line: "g91" of "g90 g91 x10".
bool HasWord(const ConsoleLine& line, std::string_view word) {
  for (std::size_t at = line.lower.find(word); at != std::string::npos;
       at = line.lower.find(word, at + 1)) {
    const bool begins = at == 0 || line.lower[at - 1] == ' ';
    const std::size_t end = at + word.size();
    if (begins && (end == line.lower.size() || line.lower[end] == ' ')) return true;
  }
  return false;
}

class LogReader {
 public:
  LogReader(const std::string& text, std::string name)
      : text_(text),
        name_(std::move(name)),
        lines_(InOrderOfTime(LinesOf(text))),
        settings_(name_),
        grids_(BareGrids(text)) {}

  Imported Read(const ImportOptions& options) {
    tells_blunders_ = options.tells_blunders;
    for (const TimedLine& line : lines_) ReadLine(line.line, line.t_s);
    grid_.End();
    if (grid_.is_whole()) AddGrid();
    CheckClimb();
    faults_.ThrowIfAny();
    imported_.machine_yaml = settings_.MachineText(&faults_);
    faults_.ThrowIfAny();
    story_.Tell(&imported_);
    grbl_.Tell(&imported_);
    switch_.Tell(&imported_);
    pulses_.Tell(&imported_);
    limit_.Tell(&imported_);
    offset_.Tell(&imported_);
    corner_.Tell(&imported_);
    steps_.Tell(&imported_);
    TellUnmeasuredLines(&imported_);
    update_.Tell(&imported_);
    reported_.Tell(&imported_);
    TellMap();
    const bool has_readings = !imported_.table.rows.empty() ||
                              !switch_.calibrations().empty() ||
                              !imported_.levelling.differences_mm.empty();
    if (!has_readings) ReadTableBelow(options);
    if (is_table_) grbl_.TellIdle(&imported_);
    drive_.Tell(&imported_);
    AddDifferences();
    AddCalibrations();
    if (imported_.table.rows.empty() && imported_.machine_yaml.empty() &&
        imported_.notes.empty()) {
      RefuseEmpty();
    }
    const bool has_steps = settings_.has_steps();
    for (Row& row : imported_.table.rows) {
      if (!options.campaign.empty()) row.campaign = options.campaign + row.campaign;
      // A table may try several settings.
      if (has_steps && row.settings.empty()) row.settings = kSettings;
    }
    if (has_steps && !imported_.table.rows.empty()) {
      imported_.header.settings[kSettings] = settings_.in_force();
    }
    Explain();
    return std::move(imported_);
  }

 private:
  // A table of what was measured, below settings that were pasted.
  void ReadTableBelow(const ImportOptions& options) {
    const std::string found = TableInText(text_);
    const bool is_marked_up = WithoutMarkup(text_) != text_;
    // As ReadPlainTable: where sentences say more than one thing, no table does.
    constexpr long kFewest = 8;
    const std::string sentences = SentencesAsTable(text_);
    const bool are_sentences = std::ranges::count(sentences, ',') >= kFewest;
    if (found.empty() && !is_marked_up && !are_sentences) return;
    const bool is_of_text = is_marked_up || are_sentences;
    try {
      Imported table = ReadPlainTable(is_of_text ? text_ : found, name_, options);
      imported_.table = std::move(table.table);
      imported_.header = std::move(table.header);
      imported_.assumed = std::move(table.assumed);
      imported_.is_deviation = table.is_deviation;
      imported_.notes.insert(
          imported_.notes.end(), table.notes.begin(), table.notes.end());
      is_table_ = true;
    } catch (const InputError&) {
      // No table that says what it holds: the settings alone are told.
    }
  }

  // The map that a sender saved of these touches.
  void TellMap() {
    const auto map = CandleMapIn(text_);
    if (!map) return;
    std::vector<double> touched_mm;
    for (const Row& row : imported_.table.rows) touched_mm.push_back(row.value_mm);
    TellLevelMap(*map, touched_mm, &imported_);
  }

  void ReadLine(const TextLine& line, double t_s) {
    ConsoleLine said = ConsoleLineOf(line.text);
    if (!Known(said.t_s)) said.t_s = t_s;
    if (said.text.empty()) return;
    heaters_.Take(said);
    grbl_.Take(said);
    pulses_.Take(said);
    limit_.Take(said, line.line);
    offset_.Take(said, line.line);
    corner_.Take(said);
    update_.Take(line.text, line.line);
    const std::string lower = Lowered(line.text);
    const bool is_report = lower.find("echo:") != std::string::npos ||
                           lower.find("recv:") != std::string::npos;
    steps_.Take(said, line.line, is_report);
    drive_.Take(said, line.line);
    reported_.Take(said);
    if (grids_.contains(line.line)) {
      grid_.End();
      if (grid_.is_whole()) AddGrid();
      grid_.Begin(line.line);
    }
    const bool begins_anew = grid_.EndsBefore(said);
    if (begins_anew || said.lower == "ok" ||
        said.lower.find("leveling grid") != std::string::npos) {
      grid_.End();
      if (grid_.is_whole()) AddGrid();
      if (begins_anew) grid_.Begin(line.line);
    }
    if (ReadState(said, Here(line)) || grid_.Take(said, line.line) ||
        ReadTouch(line, said)) {
      if (grid_.is_whole()) AddGrid();
      return;
    }
    settings_.Take(said, Here(line), &faults_);
  }

  // What changes how the touches that follow are to be taken.
  bool ReadState(const ConsoleLine& said, const Place& place) {
    if (HasWord(said, "g91")) is_relative_ = true;
    if (HasWord(said, "g90")) is_relative_ = false;
    if (said.lower.find("g38.") != std::string::npos) {
      ReadProbingMove(said);
      return true;
    }
    if (IsCommand(said, "g28") || IsCommand(said, "$h") ||
        (said.lower.starts_with("homing ") && !was_homed_)) {
      was_homed_ = true;
      ++session_;
      ++homings_;
      to_mm_ = {kUnknown, kUnknown, kUnknown};
      story_.Home(place);
    } else if (IsLevelling(said)) {
      ++session_;
      story_.Take(said, place, std::to_string(session_));
    } else if (HasWord(said, "g0") || HasWord(said, "g1") || HasWord(said, "g00") ||
               HasWord(said, "g01")) {
      ReadMove(said);
    } else if (IsCommand(said, "g29")) {
      Begin("g29");
      story_.Level();
      story_.Take(said, place, "");
    } else if (IsCommand(said, "g30")) {
      ReadG30(said);
    } else if (IsCommand(said, "m48")) {
      if (said.lower.find("repeatability") != std::string::npos)
        return true;  // A banner.
      Begin("m48");
      is_in_m48_ = true;
      at_mm_[0] = WordOf(said, 'x').value_or(to_mm_[0]);
      at_mm_[1] = WordOf(said, 'y').value_or(to_mm_[1]);
    } else if (said.lower.starts_with("probe_accuracy at")) {
      BeginAccuracy(said);
    } else if (said.lower.find("tool change") != std::string::npos ||
               HasWord(said, "m6")) {
      tool_ = "t" + std::to_string(++tools_);
    } else if (const auto steps = NumberAfter(said.lower, "microsteps ")) {
      microsteps_ = fmt::format("microsteps_{:g}", *steps);
    } else if (said.lower.size() == 2 && said.lower[0] == 't' && said.lower[1] >= '0' &&
               said.lower[1] <= '9') {
      tool_ = said.lower;
    } else {
      return story_.Take(said, place, std::to_string(session_));
    }
    return true;
  }

  bool ReadTouch(const TextLine& line, const ConsoleLine& said) {
    if (said.lower.starts_with("bed x:")) {
      ReadBed(line, said);
    } else if (IsRepeat(said)) {
      ReadRepeat(line, said);
    } else if (said.lower.find(" z=") != std::string::npos &&
               (said.lower.starts_with("probe at ") ||
                said.lower.starts_with("probe: at ") ||
                said.lower.starts_with("result: at "))) {
      ReadKlipper(line, said);
    } else if (said.lower.starts_with("probe at ") &&
               said.lower.find("z=") == std::string::npos) {
      RefuseTouch(line, "'probe at X,Y is z=Z'");
    } else if (ReadScrew(line, said) || ReadOffset(line, said) ||
               switch_.Take(said, line.line) || ReadProbed(line, said)) {
      return true;
    } else if (said.lower.starts_with("[prb:")) {
      ReadPrb(line, said);
    } else if (const auto touch_mm = TouchOfTinyG(said)) {
      if (kind_ != "prb") Begin("prb");
      GoTo((*touch_mm)[0], (*touch_mm)[1]);
      Add(line, (*touch_mm)[2], said.t_s);
    } else if (said.lower.find("bed probe heights:") != std::string::npos) {
      ReadHeights(line, said);
    } else if (said.lower.starts_with("stopped at height")) {
      const auto z_mm = NumberAfter(said.lower, "height ");
      if (!z_mm) return false;
      if (kind_ != "g30") Begin("g30");
      at_mm_[0] = to_mm_[0];
      at_mm_[1] = to_mm_[1];
      Add(line, *z_mm, said.t_s);
    } else {
      return false;
    }
    return true;
  }

  // An M48 without X and Y, and a G30 of RepRapFirmware, touch where the last move
  // went.
  void ReadMove(const ConsoleLine& said) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value_mm = WordOf(said, kAxes[k]);
      if (!value_mm) continue;
      to_mm_[k] = is_relative_ ? to_mm_[k] + *value_mm : *value_mm;
    }
    story_.Move(to_mm_);
  }

  // Which axis a G38 moves, and in which sense: relative by its sign, else away from
  // where it last touched, downwards along Z.
  void ReadProbingMove(const ConsoleLine& said) {
    const bool is_relative =
        is_relative_ || said.lower.find("g91") != std::string::npos;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value_mm = WordOf(said, kAxes[k]);
      if (!value_mm) continue;
      probed_axis_ = k;
      probed_sense_ = k == 2 || *value_mm < 0 ? -1 : 1;
      if (!is_relative && k != 2 && Known(to_mm_[k])) {
        probed_sense_ = *value_mm < to_mm_[k] ? -1 : 1;
      }
    }
    feed_mm_s_ = kUnknown;
    if (const auto feed = WordOf(said, 'f')) feed_mm_s_ = *feed / SFromMin(1.0);
  }

  void ReadG30(const ConsoleLine& said) {
    if (kind_ != "g30") Begin("g30");
    const auto x_mm = WordOf(said, 'x'), y_mm = WordOf(said, 'y');
    if (!x_mm || !y_mm || !WordOf(said, 'p')) return;
    if (*WordOf(said, 'p') == 0) points_mm_.clear();
    points_mm_.emplace_back(*x_mm, *y_mm);
  }

  void BeginAccuracy(const ConsoleLine& said) {
    Begin("probe_accuracy");
    at_mm_[0] = NumberAfter(said.lower, "x:").value_or(kUnknown);
    at_mm_[1] = NumberAfter(said.lower, "y:").value_or(kUnknown);
    feed_mm_s_ = NumberAfter(said.lower, " speed=").value_or(kUnknown);
    if (feed_mm_s_ < 0) feed_mm_s_ = kUnknown;
  }

  // "2 of 10: z: 0.031"
  static bool IsRepeat(const ConsoleLine& said) {
    const std::size_t of = said.lower.find(" of ");
    return of != std::string::npos && NumberOf(said.lower.substr(0, of)) &&
           said.lower.find("z:", of) != std::string::npos;
  }

  void ReadBed(const TextLine& line, const ConsoleLine& said) {
    const auto x_mm = NumberAfter(said.lower, "x:");
    const auto y_mm = NumberAfter(said.lower, "y:");
    const auto z_mm = NumberAfter(said.lower, "z:");
    if (!x_mm || !y_mm || !z_mm)
      return RefuseTouch(line, "'Bed X: 10.00 Y: 20.00 Z: 0.03'");
    // A talkative M48 says where it stands before it counts.
    if (kind_ == "m48" && is_in_m48_) {
      at_mm_ = {*x_mm, *y_mm};
      return;
    }
    if (kind_.empty() || kind_ == "m48") Begin("g30");
    GoTo(*x_mm, *y_mm);
    Add(line, *z_mm, said.t_s);
  }

  // Where nothing says the place, it is one place all the same.
  void ReadRepeat(const TextLine& line, const ConsoleLine& said) {
    const auto z_mm = NumberAfter(said.lower, "z:");
    if (!z_mm) return RefuseTouch(line, "'2 of 10: z: 0.031'");
    if (kind_ != "m48") Begin("m48");
    const std::size_t of = said.lower.find(" of ");
    const auto all = NumberAfter(said.lower.substr(of), " of ");
    is_in_m48_ = all && NumberOf(said.lower.substr(0, of)) < all;
    Add(line, *z_mm, said.t_s);
  }

  void ReadKlipper(const TextLine& line, const ConsoleLine& said) {
    const std::size_t at = said.lower.find(" at ");
    const std::string after = said.lower.substr(at + 4);
    const std::size_t comma = after.find(',');
    const std::string rest = comma == std::string::npos ? "" : after.substr(comma + 1);
    const auto x_mm = NumberOf(after.substr(0, comma));
    const auto y_mm = NumberOf(rest.substr(0, rest.find(' ')));
    const auto z_mm = NumberAfter(after, "z=");
    if (!x_mm || !y_mm || !z_mm) return RefuseTouch(line, "'probe at X,Y is z=Z'");
    if (kind_ != "probe_accuracy") Begin("probe_accuracy");
    const bool is_bed = said.lower.find("contact") != std::string::npos;
    (is_bed ? has_new_text_ : has_old_text_) = true;
    GoTo(*x_mm, *y_mm);
    Add(line, *z_mm, said.t_s);
    if (is_bed) imported_.table.rows.back().setup += "_nominal";
  }

  // "[PRB:-10.000,5.000,-12.345:1]": the position at the trigger. Along Z it is a
  // height; along X and Y how far from the first touch of that face.
  void ReadPrb(const TextLine& line, const ConsoleLine& said) {
    const auto touch = TouchOfGrbl(said);
    if (!touch) return RefuseTouch(line, "'[PRB:0.000,0.000,-1.234:1]'");
    if (!touch->has_touched) {
      imported_.warnings.push_back(fmt::format(
          "line {}: this probing found nothing (:0) and is left out", line.line));
      return;
    }
    const std::array<double, 3>& at_mm = touch->at_mm;
    if (kind_ != "prb") Begin("prb");
    const std::size_t k = probed_axis_;
    const std::string face =
        fmt::format("{}{}", kAxes[k], probed_sense_ < 0 ? '+' : '-');
    const double zero_mm =
        k == 2 ? 0 : first_mm_.try_emplace(face, at_mm[k]).first->second;
    GoTo(at_mm[0], at_mm[1]);
    Add(line, (at_mm[k] - zero_mm) * -probed_sense_, said.t_s);
    Row& row = imported_.table.rows.back();
    row.cmd_mm = {at_mm[0], at_mm[1], k == 2 ? 0 : at_mm[2]};
    row.cmd_mm[k] = zero_mm;
    row.dir = {kUnknown, kUnknown, kUnknown};
    row.dir[k] = probed_sense_;
    row.n = {0, 0, 0};
    row.n[k] = -probed_sense_;
    row.setup = tool_.empty() ? "table" : "table_" + tool_;
    row.feature = k == 2 ? "table.top" : "work." + face;
  }

  // "G32 bed probe heights: 0.133 0.125, mean 0.129, deviation ...": of the points that
  // G30 Pn named, else several of one place.
  void ReadHeights(const TextLine& line, const ConsoleLine& said) {
    const std::size_t colon = said.lower.find("heights:");
    const std::string list =
        said.lower.substr(colon + 8, said.lower.find(',', colon) - colon - 8);
    std::vector<double> heights_mm;
    for (std::size_t at = list.find_first_not_of(' '); at != std::string::npos;) {
      const std::size_t end = std::min(list.size(), list.find(' ', at));
      const auto height_mm = NumberOf(list.substr(at, end - at));
      if (height_mm) heights_mm.push_back(*height_mm);
      at = list.find_first_not_of(' ', end);
    }
    Begin("heights");
    const bool has_points = points_mm_.size() == heights_mm.size();
    for (std::size_t i = 0; i < heights_mm.size(); ++i) {
      if (has_points) GoTo(points_mm_[i].first, points_mm_[i].second);
      Add(line, heights_mm[i], said.t_s);
    }
    lacks_points_ |= !has_points && heights_mm.size() > 1;
  }

  // "front left screw (base) : x=30.0, y=30.0, z=2.41250 : adjust CW 00:11"
  bool ReadScrew(const TextLine& line, const ConsoleLine& said) {
    const auto x_mm = NumberAfter(said.lower, "x="),
               y_mm = NumberAfter(said.lower, "y="),
               z_mm = NumberAfter(said.lower, "z=");
    if (!x_mm || !y_mm || !z_mm || said.lower.find("screw") == std::string::npos)
      return false;
    if (kind_ != "screws") Begin("screws");
    GoTo(*x_mm, *y_mm);
    Add(line, *z_mm, said.t_s);
    return true;
  }

  // "probed 3/12> 2.401 0.000 0.006", as height maps of sending programs print it.
  bool ReadProbed(const TextLine& line, const ConsoleLine& said) {
    const std::size_t mark = said.lower.find("> ");
    if (!said.lower.starts_with("probed ") || mark == std::string::npos) return false;
    std::vector<double> numbers;
    for (const TextLine& rest :
         LinesOf(std::string_view(said.lower).substr(mark + 2))) {
      for (const CsvField& word : rest.words) {
        if (const auto number = NumberOf(word.text)) numbers.push_back(*number);
      }
    }
    if (numbers.size() != 3) return false;
    if (kind_ != "map") Begin("map");
    GoTo(numbers[0], numbers[1]);
    Add(line, numbers[2], said.t_s);
    return true;
  }

  // What is one kind of reading stands together: the nozzle's, the body's, the probe's.
  void AddCalibrations() {
    constexpr std::array<const char*, 3> kFeatures = {
        "switch.nozzle", "switch.body", "bed.probe"};
    if (switch_.calibrations().empty()) return;
    Begin("z_calibration");
    for (std::size_t k = 0; k < kFeatures.size(); ++k) {
      rep_ = 0;
      for (const SwitchStory::Calibration& one : switch_.calibrations()) {
        const std::array readings_mm = {one.nozzle_mm, one.body_mm, one.probe_mm};
        Add({.text = "", .line = one.line, .words = {{.text = "", .line = one.line}}},
            readings_mm[k],
            kUnknown);
        Row& row = imported_.table.rows.back();
        row.feature = kFeatures[k];
        if (!Known(one.endstop_mm)) continue;
        // Z counts from where it was homed to.
        row.settings = fmt::format("endstop_{:g}", one.endstop_mm);
        imported_.header.settings[row.settings];
      }
    }
    heights_mm_.clear();
  }

  // "probe: z_offset: 3.477" behind a touch: nozzle against probe at that place.
  bool ReadOffset(const TextLine& line, const ConsoleLine& said) {
    const auto offset_mm = NumberAfter(said.lower, "z_offset: ");
    if (!said.lower.starts_with("probe: z_offset:") || !offset_mm ||
        !Known(at_mm_[0])) {
      return false;
    }
    const std::array<double, 2> at_mm = at_mm_;
    Begin("probe_offset");
    at_mm_ = at_mm;
    Add(line, *offset_mm, said.t_s);
    Row& row = imported_.table.rows.back();
    row.feature = "nozzle.offset";
    row.probe_off_mm = {
        story_.probe_offset_mm()[0], story_.probe_offset_mm()[1], kUnknown};
    return true;
  }

  // Differences of two motors, a round each: readings of one thing.
  void AddDifferences() {
    if (imported_.levelling.differences_mm.empty() || !imported_.table.rows.empty())
      return;
    Begin("alignment");
    const TextLine& line = lines_.front().line;
    for (const double difference_mm : imported_.levelling.differences_mm) {
      Add(line, difference_mm, kUnknown);
      imported_.table.rows.back().feature = "beam.left_less_right";
    }
    imported_.has_places = false;
  }

  void AddGrid() {
    Begin("mesh");
    for (const GridHeight& height : grid_.TakeHeights()) {
      GoTo(height.x_mm, height.y_mm);
      imported_.has_places &= height.has_place;
      Add({.text = "",
           .line = height.line,
           .words = {{.text = "", .line = height.line}}},
          height.height_mm,
          kUnknown);
    }
  }

  void Begin(const std::string& kind) {
    CheckClimb();
    const bool is_together = kind == "g30" || kind == "prb" || kind == "heights" ||
                             kind == "screws" || kind == "probe_offset";
    kind_ = kind;
    at_mm_ = {kUnknown, kUnknown};
    rep_ = 0;
    if (is_together && counts_.contains(kind)) return;  // All of them are one campaign.
    ++counts_[kind];
  }

  std::string Campaign() const {
    const int count = counts_.at(kind_);
    const bool is_numbered = kind_ == "probe_accuracy" || count > 1;
    return is_numbered ? fmt::format("{}_{}", kind_, count) : kind_;
  }

  void GoTo(double x_mm, double y_mm) {
    if (x_mm != at_mm_[0] || y_mm != at_mm_[1]) CheckClimb();
    at_mm_ = {x_mm, y_mm};
  }

  void Add(const TextLine& line, double z_mm, double t_s) {
    if (Known(t_s) && !Known(first_s_)) first_s_ = t_s;
    Row row = BedTouchRow(Campaign(), at_mm_[0], at_mm_[1], z_mm, Here(line));
    row.t_s = t_s - first_s_;
    row.rep = ++rep_;
    row.feed_mm_s = feed_mm_s_;
    row.temp_bed_c = heaters_.bed_c;
    row.temp_nozzle_c = heaters_.nozzle_c;
    if (session_ > 0) row.home = std::to_string(session_);
    if (!tool_.empty()) row.setup += "_" + tool_;
    if (heights_mm_.empty()) first_ = row.place;
    heights_mm_.push_back(z_mm);
    was_homed_ = false;
    story_.Touch();
    if (!microsteps_.empty()) row.settings = microsteps_;
    imported_.table.rows.push_back(std::move(row));
  }

  void CheckClimb() {
    const std::string climb = tells_blunders_ ? "" : ClimbText(heights_mm_);
    if (!climb.empty()) faults_.Add(first_, climb, std::string(kClimbHint));
    heights_mm_.clear();
  }

  void RefuseTouch(const TextLine& line, const std::string& as) {
    faults_.Add(Here(line),
                "this line begins like a touch, but its numbers are not all there",
                as);
  }

  [[noreturn]] void RefuseEmpty() const {
    if (grid_.line_without_corners() > 0) {
      throw InputError(
          {.file = name_, .line = grid_.line_without_corners(), .column = 1},
          "a levelling grid does not say where its points lie",
          "G29 V4 prints every touch as 'Bed X: 10.00 Y: 20.00 Z: 0.03', G29 T "
          "of UBL the coordinates of its corners");
    }
    throw InputError({.file = name_, .line = 1, .column = 1},
                     "no touches and no settings stand here",
                     "read are 'probe at X,Y is z=Z' (Klipper), 'Bed X: Y: Z:', 'N of "
                     "M: z: Z' and M503 "
                     "(Marlin), '[PRB:x,y,z:1]' (grbl), 'Stopped at height Z' and 'bed "
                     "probe heights:' "
                     "(RepRapFirmware)");
  }

  void Explain() {
    std::vector<Row>& rows = imported_.table.rows;
    if (is_table_) {
      imported_.recognised.push_back(
          fmt::format("settings, and a table below them: {} readings", rows.size()));
    } else if (!rows.empty()) {
      imported_.recognised.push_back(
          fmt::format("a console log: {} touches, {} homing{}",
                      rows.size(),
                      homings_,
                      homings_ == 1 ? "" : "s"));
      std::vector<double> values_mm;
      for (const Row& row : rows) values_mm.push_back(row.value_mm);
      if (const double step_mm = StepOf(values_mm); step_mm > 0) {
        imported_.recognised.push_back(
            fmt::format("heights come in steps of {:.4g} um", UmFromMm(step_mm)));
      }
      imported_.assumed.emplace_back(
          "z is the height reported at the trigger in mm, + is up; the bed's nominal "
          "height is 0");
      if (homings_ == 0)
        imported_.assumed.emplace_back("no G28 stands here: one homing session");
    }
    if (settings_.has_geometry()) {
      imported_.recognised.emplace_back("a delta's M665 and M666: endstop = H - M666");
      imported_.assumed.emplace_back(
          "X, Y, Z are the towers at 210, 330 and 90 degrees");
    }
    if (has_old_text_ && has_new_text_) {
      imported_.notes.push_back({.kind = FileNote::Kind::kElsewhere,
                                 .what = "firmware",
                                 .sentence = "Nothing moved between the two texts: "
                                             "since 2026 Klipper tells where the bed "
                                             "lies (the probe's x, y and z offsets "
                                             "taken off), before it told the head's "
                                             "place and height at the trigger. Compare "
                                             "them after taking z_offset off the "
                                             "older ones"});
    }
    if (lacks_points_) {
      imported_.warnings.emplace_back(
          "nothing says where these heights were touched: taken as touches of one "
          "place. "
          "The lines 'G30 Pn X Y Z-99999' of bed.g, put before them, say it");
    }
    if (grid_.line_without_corners() > 0 && !rows.empty()) {
      imported_.warnings.push_back(
          fmt::format("line {}: a levelling grid without positions is left out",
                      grid_.line_without_corners()));
    }
  }

  Place Here(const TextLine& line) const { return PlaceOf(line.words.front(), name_); }

  const std::string& text_;
  std::string name_;
  std::vector<TimedLine> lines_;
  Faults faults_;
  Imported imported_;
  ConsoleSettings settings_;
  ConsoleGrid grid_;
  std::set<int> grids_;  ///< Lines at which bare grids begin.
  ConsoleStory story_;
  GrblStory grbl_;
  Heaters heaters_;
  std::map<std::string, int> counts_;  ///< Campaigns of each kind so far.
  std::string kind_, tool_, microsteps_;
  int tools_ = 0;  ///< Changes of tool.
  int homings_ = 0;
  bool was_homed_ = false;  ///< Since the last touch.
  bool tells_blunders_ = false, is_table_ = false;
  bool is_in_m48_ = false;  ///< Between its command and the last of its touches.
  int session_ = 0;         ///< Homings and levellings.
  std::int64_t rep_ = 0;
  double first_s_ = kUnknown, feed_mm_s_ = kUnknown;
  std::array<double, 2> at_mm_{kUnknown, kUnknown};
  std::array<double, 3> to_mm_{kUnknown, kUnknown, kUnknown};  ///< Of the last move.
  bool is_relative_ = false;                                   ///< G91.
  std::vector<std::pair<double, double>> points_mm_;           ///< Of G30 Pn.
  std::map<std::string, double> first_mm_;                     ///< Of each probed face.
  std::size_t probed_axis_ = 2;
  double probed_sense_ = -1;
  bool has_old_text_ = false, has_new_text_ = false, lacks_points_ = false;
  SwitchStory switch_;
  PulseRate pulses_;
  CorrectionLimit limit_;
  TouchOffset offset_;
  CornerSpeed corner_;
  StepsBetween steps_;
  DriveSteps drive_;
  UpdateBetween update_;
  ReportedMove reported_;
  std::vector<double> heights_mm_;
  Place first_;
};

}  // namespace

Imported ReadConsoleLog(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  return LogReader(text, name).Read(options);
}

}  // namespace caltwin
