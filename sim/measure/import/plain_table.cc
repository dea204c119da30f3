#include "sim/measure/import/plain_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

enum class Part {
  kNone,
  kAxis,
  kPosition,
  kCommanded,
  kActual,
  kDeviation,
  kHeight,
  kSense,
  kRun,
  kFeed,
  kTemperature,
  kTime,
  kSetup,
  kSteps,
  kHome
};

struct PartWords {
  Part part = Part::kNone;
  std::vector<std::string_view> words{};
};

// The first part one of whose words stands in a heading.
const std::vector<PartWords>& AllWords() {
  static const std::vector<PartWords> kAll = {
      {Part::kFeed, {"feed", "feedrate", "speed", "f"}},
      {Part::kHome, {"home", "homing"}},
      {Part::kSteps, {"steps", "step", "microsteps"}},
      {Part::kSense, {"dir", "direction", "sense", "approach", "moving"}},
      {Part::kTemperature,
       {"pinda",
        "temp",
        "temperature",
        "bed",
        "nozzle",
        "frame",
        "chamber",
        "ambient",
        "room",
        "screw"}},
      {Part::kDeviation,
       {"error", "err", "deviation", "dev", "diff", "difference", "off", "delta"}},
      {Part::kActual,
       {"actual",   "measured", "measure",   "meas",      "reading",  "read",
        "reads",    "moved",    "real",      "got",       "calliper", "caliper",
        "calipers", "gauge",    "indicator", "dial",      "dro",      "laser",
        "observed", "seen",     "result",    "travelled", "printed",  "ruler",
        "scale",    "is",       "cut",       "display",   "came"}},
      {Part::kCommanded,
       {"commanded", "command",    "cmd",    "target",    "nominal", "set",
        "setpoint",  "expected",   "told",   "requested", "ideal",   "design",
        "designed",  "programmed", "size",   "model",     "asked",   "jog",
        "gcode",     "drawing",    "should", "ideal",     "wanted"}},
      {Part::kHeight,
       {"height",
        "z",
        "probe",
        "probed",
        "trigger",
        "offset",
        "gap",
        "feeler",
        "clearance"}},
      {Part::kRun,
       {"run",
        "rep",
        "repeat",
        "repetition",
        "trial",
        "sample",
        "no",
        "n",
        "nr",
        "touch",
        "try",
        "pass"}},
      {Part::kTime, {"time", "t", "min", "minutes", "s", "sec", "seconds", "minute"}},
      {Part::kPosition, {"position", "pos", "distance", "travel", "length", "at"}},
      {Part::kAxis, {"axis"}},
      {Part::kSetup,
       {"setup", "part", "place", "line", "piece", "feature", "calibration"}}};
  return kAll;
}

constexpr std::array<std::string_view, 8> kSides = {
    "outside", "outer", "external", "boss", "inside", "inner", "internal", "hole"};

std::vector<std::string> TokensOf(const std::string& heading) {
  std::vector<std::string> tokens;
  std::string token;
  for (const char c : heading + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      token += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!token.empty()) {
      tokens.push_back(std::move(token));
      token.clear();
    }
  }
  return tokens;
}

/// A column and what it is.
struct TableColumn {
  std::size_t index = 0;
  Part part = Part::kNone;
  int axis = -1;  ///< Where the heading has a letter x, y or z.
  const NamedUnit* unit = nullptr;
  double Row::*temperature = nullptr;
  std::string side{};  ///< "outside", "inside": a wall measured by that column.
};

Quantity QuantityOf(Part part) {
  switch (part) {
    case Part::kFeed:
      return Quantity::kFeed;
    case Part::kTemperature:
      return Quantity::kTemperature;
    case Part::kTime:
      return Quantity::kTime;
    case Part::kPosition:
    case Part::kCommanded:
    case Part::kActual:
    case Part::kDeviation:
    case Part::kHeight:
      return Quantity::kLength;
    default:
      return Quantity::kPlain;
  }
}

double Row::*TemperatureOf(const std::vector<std::string>& tokens) {
  for (const std::string& token : tokens) {
    if (token == "bed") return &Row::temp_bed_c;
    if (token == "nozzle") return &Row::temp_nozzle_c;
    if (token == "chamber") return &Row::temp_chamber_c;
    // A probe follows its own temperature as a screw does (probe_temperature).
    if (token == "screw" || token == "pinda" || token == "probe")
      return &Row::temp_screw_c;
    if (token == "ambient" || token == "room") return &Row::temp_ambient_c;
  }
  return &Row::temp_frame_c;
}

TableColumn ColumnOf(const CsvField& heading, std::size_t index) {
  const std::vector<std::string> tokens = TokensOf(heading.text);
  TableColumn column{.index = index};
  const auto has = [&](std::string_view word) {
    return std::ranges::find(tokens, word) != tokens.end();
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (has(std::string(1, "xyz"[axis]))) column.axis = axis;
  }
  // "bed" is a temperature only beside a word or unit of one.
  const bool is_hot = has("temp") || has("temperature") || has("c") || has("degc") ||
                      (has("t") && tokens.size() > 1);
  for (const PartWords& words : AllWords()) {
    const bool is_meant = words.part == Part::kTemperature ? is_hot
                          : words.part == Part::kSteps     ? has("mm")
                                                           : true;
    if (column.part == Part::kNone && is_meant &&
        std::ranges::any_of(words.words, has)) {
      column.part = words.part;
    }
  }
  if (column.part == Part::kTemperature) column.temperature = TemperatureOf(tokens);
  // "height in the model" is a Z size.
  if (column.axis < 0 && has("height") && column.part != Part::kHeight) column.axis = 2;
  if (column.part == Part::kNone && column.axis >= 0) column.part = Part::kPosition;
  column.unit = UnitInHeading(heading.text, QuantityOf(column.part));
  // "off (mm), correction on": in brackets before the end.
  const std::size_t close = heading.text.rfind(')');
  if (column.unit == nullptr && close != std::string::npos) {
    column.unit =
        UnitInHeading(heading.text.substr(0, close + 1), QuantityOf(column.part));
  }
  return column;
}

class TableReader {
 public:
  TableReader(const std::string& text, std::string name, const ImportOptions& options)
      : name_(std::move(name)),
        options_(options),
        sheet_(ReadSpreadsheet(WithoutMarkup(text), name_)) {}

  Imported Read() {
    for (std::size_t i = 0; i < sheet_.headings.size(); ++i) {
      columns_.push_back(ColumnOf(sheet_.headings[i], i));
    }
    TakeReadColumns();
    if (HasHeights()) {
      ReadHeights();
    } else if (!ReadMoves()) {
      LookAtDifference();
      if (imported_.notes.empty()) ThrowWithColumns();
    }
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty() && imported_.notes.empty()) ThrowWithColumns();
    for (Row& row : imported_.table.rows) {
      if (!options_.campaign.empty()) row.campaign = options_.campaign;
    }
    imported_.recognised.insert(imported_.recognised.begin(),
                                fmt::format("a table of {} lines: {} readings",
                                            sheet_.records.size(),
                                            imported_.table.rows.size()));
    if (takes_mm_)
      imported_.assumed.emplace_back("lengths are in mm: nothing says otherwise");
    imported_.has_unit = true;
    return std::move(imported_);
  }

 private:
  std::vector<TableColumn> Of(Part part, int axis = -1) const {
    std::vector<TableColumn> found;
    for (const TableColumn& column : columns_) {
      if (column.part == part && (axis < 0 || column.axis == axis))
        found.push_back(column);
    }
    return found;
  }

  std::optional<TableColumn> FirstOf(Part part, int axis = -1) const {
    const auto found = Of(part, axis);
    return found.empty() ? std::nullopt : std::optional(found.front());
  }

  // Beside a column of nominal sizes, plain columns "x", "Y (mm)" and "outside" are
  // what was read.
  void TakeReadColumns() {
    const bool has_nominal =
        std::ranges::any_of(columns_, [](const TableColumn& column) {
          return column.part == Part::kCommanded && column.axis < 0;
        });
    const bool has_read = FirstOf(Part::kActual) || FirstOf(Part::kDeviation);
    if (!has_nominal || has_read) return;
    for (TableColumn& column : columns_) {
      const auto tokens = TokensOf(sheet_.headings[column.index].text);
      for (const std::string& token : tokens) {
        if (std::ranges::find(kSides, token) != kSides.end()) column.side = token;
      }
      const bool is_letter = column.axis >= 0 && (column.part == Part::kPosition ||
                                                  column.part == Part::kHeight);
      if (is_letter || !column.side.empty()) column.part = Part::kActual;
    }
  }

  // A place along an axis: the plain column of its letter.
  std::optional<TableColumn> PlaceOn(int axis) const {
    return FirstOf(Part::kPosition, axis);
  }

  std::optional<TableColumn> HeightColumn() const {
    const auto height = FirstOf(Part::kHeight);
    return height ? height : PlaceOn(2);
  }

  // x, y and a height, or heights alone with what else changed.
  bool HasHeights() const {
    const bool has_moves = FirstOf(Part::kCommanded) || FirstOf(Part::kActual);
    if (has_moves || !HeightColumn()) return false;
    const bool has_place = PlaceOn(0) && PlaceOn(1);
    return has_place || (!PlaceOn(0) && !PlaceOn(1));
  }

  std::optional<double> NumberAt(const CsvRecord& record, const TableColumn& column) {
    const CsvField& field = record[column.index];
    if (field.text.empty()) return std::nullopt;
    std::string word = field.text;
    if (word.starts_with('+')) word.erase(0, 1);
    const auto value = NumberOf(word, sheet_.decimal);
    if (!value) {
      faults_.Add(PlaceOf(field, name_),
                  fmt::format("'{}' is no number", field.text),
                  "an unknown value is an empty field");
      return std::nullopt;
    }
    if (column.unit != nullptr) return column.unit->convert(*value);
    takes_mm_ |= QuantityOf(column.part) == Quantity::kLength;
    return *value;
  }

  // What a line says beside its readings.
  void TakeState(const CsvRecord& record, Row* row) {
    for (const TableColumn& column : columns_) {
      if (column.part == Part::kTemperature) {
        if (const auto value = NumberAt(record, column))
          row->*column.temperature = *value;
      } else if (column.part == Part::kFeed) {
        const auto feed = NumberAt(record, column);
        // A feed without a unit is G-code's.
        if (feed)
          row->feed_mm_s = column.unit != nullptr ? *feed : *feed / SFromMin(1.0);
        takes_feed_ |= column.unit == nullptr;
      } else if (column.part == Part::kTime) {
        if (const auto t_s = NumberAt(record, column)) {
          const bool is_min =
              TokensOf(sheet_.headings[column.index].text).front() == "min" ||
              PlainWord(sheet_.headings[column.index].text).starts_with("minute");
          row->t_s = column.unit == nullptr && is_min ? SFromMin(*t_s) : *t_s;
        }
      } else if (column.part == Part::kRun) {
        const auto run = NumberOf(record[column.index].text);
        if (run && *run == std::round(*run) && std::abs(*run) < 1e9) {
          row->rep = static_cast<std::int64_t>(*run);
        }
      }
    }
  }

  // What a line was called; walls outside and inside are measured apart.
  void TakeLabel(const CsvRecord& record, Row* row) {
    std::string label;
    for (const TableColumn& column : columns_) {
      if (column.part == Part::kHome) row->home = record[column.index].text;
      if (column.part != Part::kSetup) continue;
      label += (label.empty() ? "" : " ") + record[column.index].text;
    }
    if (label.empty()) return;
    if (imported_.table.extra_columns.empty()) {
      imported_.table.extra_columns.emplace_back("label");
    }
    row->extra = {label};
    for (const std::string& token : TokensOf(label)) {
      if (std::ranges::find(kSides, token) != kSides.end()) row->setup = token;
    }
  }

  void ReadHeights() {
    const TableColumn height = *HeightColumn();
    const auto words = TokensOf(sheet_.headings[height.index].text);
    const bool is_gap = std::ranges::any_of(words, [](const std::string& word) {
      return word == "gap" || word == "feeler" || word == "clearance";
    });
    const auto x = PlaceOn(0), y = PlaceOn(1);
    for (const CsvRecord& record : sheet_.records) {
      const auto value = NumberAt(record, height);
      if (!value) continue;
      Row row{.campaign = "heights",
              .kind = RowKind::kTouch,
              .setup = "bed",
              .place = PlaceOf(record.front(), name_)};
      const auto at = [&](const std::optional<TableColumn>& column) {
        return column ? NumberAt(record, *column).value_or(kUnknown) : kUnknown;
      };
      row.cmd_mm = {at(x), at(y), 0};
      row.dir[2] = -1;
      row.n = {0, 0, 1};
      row.feature = "bed.top";
      // A gap under the nozzle is the larger, the lower the bed.
      row.value_mm = is_gap ? -*value : *value;
      TakeState(record, &row);
      imported_.table.rows.push_back(std::move(row));
    }
    imported_.assumed.emplace_back(
        is_gap
            ? "each line is a gap between nozzle and bed: the bed's height is minus it"
            : "each line is a touch from above; its height is the bed's, + is up, "
              "nominal 0");
    if (takes_feed_)
      imported_.assumed.emplace_back("feeds are in mm/min, as in G-code");
  }

  // 1 or -1 of "+", "fwd", "up", "-1" ...; kUnknown of anything else.
  double SenseIn(const CsvRecord& record) const {
    const auto column = FirstOf(Part::kSense);
    if (!column) return kUnknown;
    const std::string word = PlainWord(record[column->index].text);
    constexpr std::array<std::string_view, 9> kPlus = {
        "+", "1", "+1", "fwd", "forward", "pos", "positive", "up", "right"};
    constexpr std::array<std::string_view, 10> kMinus = {"-",
                                                         "-1",
                                                         "rev",
                                                         "reverse",
                                                         "back",
                                                         "backward",
                                                         "neg",
                                                         "negative",
                                                         "down",
                                                         "left"};
    for (const std::string_view plus : kPlus) {
      if (word == plus || (word.size() == 2 && word[1] == '+')) return 1;
    }
    for (const std::string_view minus : kMinus) {
      if (word == minus || (word.size() == 2 && word[1] == '-')) return -1;
    }
    return kUnknown;
  }

  int AxisIn(const CsvRecord& record) {
    const auto column = FirstOf(Part::kAxis);
    if (column) {
      const std::string word = PlainWord(record[column->index].text);
      if (!word.empty() && word[0] >= 'x' && word[0] <= 'z') return word[0] - 'x';
      faults_.Add(PlaceOf(record[column->index], name_),
                  fmt::format("'{}' is no axis", record[column->index].text),
                  "x, y or z");
    }
    if (!options_.axis.empty()) {
      return PlainWord(options_.axis) == "y"   ? 1
             : PlainWord(options_.axis) == "z" ? 2
                                               : 0;
    }
    takes_x_ |= !column.has_value();
    return 0;
  }

  // Commanded against read, a pair of columns an axis; several read columns are runs.
  bool ReadMoves() {
    std::set<int> letters;
    for (const TableColumn& column : columns_) {
      const bool is_read =
          column.part == Part::kActual || column.part == Part::kDeviation;
      if (is_read && column.axis >= 0) letters.insert(column.axis);
    }
    bool is_any = false;
    if (letters.empty()) return ReadPair(-1);
    for (const int letter : letters) is_any |= ReadPair(letter);
    return is_any;
  }

  bool ReadPair(int letter) {
    auto commanded = FirstOf(Part::kCommanded, letter);
    if (!commanded) commanded = FirstOf(Part::kPosition, letter);
    if (!commanded && letter >= 0) commanded = FirstOf(Part::kCommanded);
    if (!commanded && letter >= 0) commanded = FirstOf(Part::kPosition);
    const std::vector<TableColumn> actual = Of(Part::kActual, letter);
    const std::vector<TableColumn> deviation = Of(Part::kDeviation, letter);
    if (actual.empty() && deviation.empty()) return false;
    // One place come upon from both sides: a dial against it, no command beside it.
    if (!commanded && !FirstOf(Part::kSense) && !FirstOf(Part::kHome)) return false;
    LookAtDifference();
    const bool is_actual =
        !actual.empty() && !(commanded && AreDeviations(*commanded, actual));
    const bool is_dial = !actual.empty() && !is_actual;
    const bool has_series = !is_actual && deviation.size() > 1;
    for (const TableColumn& column : is_actual || is_dial ? actual : deviation) {
      series_ = has_series ? sheet_.headings[column.index].text : "";
      RequireUnit(column, is_actual || is_dial);
      for (const CsvRecord& record : sheet_.records)
        AddMove(record, commanded, column, letter, is_actual);
    }
    imported_.is_deviation = is_actual;
    imported_.assumed.emplace_back(
        is_actual ? "value = read - commanded"
        : is_dial ? "the gauge was set to nought at each target: it reads what "
                    "is off there"
                  : "the deviation is read minus commanded");
    if (takes_x_)
      imported_.assumed.emplace_back("the axis is x: nothing names it (--axis)");
    return true;
  }

  // Where an error is the difference of what was believed of an artefact and what it
  // is.
  void LookAtDifference() {
    constexpr double kAlike = 0.1;
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < sheet_.headings.size(); ++i) {
      const bool is_number =
          std::ranges::all_of(sheet_.records, [&](const CsvRecord& record) {
            return NumberOf(record[i].text, sheet_.decimal).has_value();
          });
      if (is_number) numbers.push_back(i);
    }
    if (numbers.size() < 3 || sheet_.records.size() < 4 || !imported_.notes.empty())
      return;
    const auto at = [&](const CsvRecord& record, std::size_t i) {
      return *NumberOf(record[i].text, sheet_.decimal);
    };
    for (const std::size_t a : numbers) {
      for (const std::size_t b : numbers) {
        for (const std::size_t c : numbers) {
          if (a == b || b == c || a == c) continue;
          double left = 0, size = 0, least = HUGE_VAL, most = -HUGE_VAL, apart = 0;
          for (const CsvRecord& record : sheet_.records) {
            const double error = at(record, c), by = at(record, a) - at(record, b);
            left += std::pow(error - by, 2);
            size += error * error;
            least = std::min(least, error);
            most = std::max(most, error);
            apart = std::max(apart, std::abs(at(record, b)));
          }
          const bool is_small = most - least < 0.2 * apart;
          if (size == 0 || most == least || left > kAlike * kAlike * size || !is_small)
            continue;
          imported_.notes.push_back(
              {.kind = FileNote::Kind::kElsewhere,
               .what = "gauge",
               .sentence = fmt::format("'{}' is '{}' less '{}' in every line: what is "
                                       "believed of the block or "
                                       "plate is wrong, and the machine does what it "
                                       "is told. Enter the measured "
                                       "size",
                                       sheet_.headings[c].text,
                                       sheet_.headings[a].text,
                                       sheet_.headings[b].text)});
          return;
        }
      }
    }
  }

  // A dial that is set to nought at every target reads what is off, not where it is.
  bool AreDeviations(const TableColumn& commanded,
                     const std::vector<TableColumn>& read) {
    constexpr double kSmall = 0.05;
    double least_mm = HUGE_VAL, most_mm = 0;
    for (const CsvRecord& record : sheet_.records) {
      const auto at_mm = NumberAt(record, commanded);
      if (at_mm) least_mm = std::min(least_mm, std::abs(*at_mm));
      for (const TableColumn& column : read) {
        const auto value_mm = NumberAt(record, column);
        if (value_mm) most_mm = std::max(most_mm, std::abs(*value_mm));
      }
    }
    return most_mm < kSmall * least_mm;
  }

  // A position's unit is that of the command, a deviation's may be any.
  void RequireUnit(const TableColumn& column, bool is_actual) {
    if (is_actual || column.unit != nullptr || !options_.unit.empty()) return;
    faults_.Add(PlaceOf(sheet_.headings[column.index], name_),
                fmt::format("nothing says the unit of '{}'",
                            sheet_.headings[column.index].text),
                "say it: --unit mm, um or inch");
  }

  // Whether a heading speaks of a move, whose reading began at 0, and not of a size.
  bool IsMove(const TableColumn& commanded) const {
    constexpr std::array<std::string_view, 9> kWords = {"told",
                                                        "commanded",
                                                        "command",
                                                        "cmd",
                                                        "jog",
                                                        "requested",
                                                        "asked",
                                                        "gcode",
                                                        "move"};
    const auto tokens = TokensOf(sheet_.headings[commanded.index].text);
    return std::ranges::any_of(tokens, [&](const std::string& token) {
      return std::ranges::find(kWords, token) != kWords.end();
    });
  }

  void AddMove(const CsvRecord& record,
               const std::optional<TableColumn>& commanded,
               const TableColumn& read,
               int letter,
               bool is_actual) {
    const auto at_mm = commanded ? NumberAt(record, *commanded) : std::optional(0.0);
    TableColumn column = read;
    if (column.unit == nullptr && !options_.unit.empty()) {
      column.unit = &FindUnit(options_.unit, Quantity::kLength, {.file = "--unit"});
    }
    const auto value = NumberAt(record, column);
    if (!at_mm || !value) return;
    const auto axis = static_cast<std::size_t>(letter >= 0 ? letter : AxisIn(record));
    Row row{.campaign = series_.empty() ? "moves" : series_,
            .place = PlaceOf(record.front(), name_)};
    row.cmd_mm[axis] = *at_mm;
    for (int other = 0; other < 3 && letter >= 0; ++other) {
      const auto also = FirstOf(Part::kCommanded, other);
      if (other == letter || !also) continue;
      row.cmd_mm[static_cast<std::size_t>(other)] =
          NumberAt(record, *also).value_or(kUnknown);
    }
    row.dir[axis] = SenseIn(record);
    row.n = {0, 0, 0};
    row.n[axis] = 1;
    row.value_mm = is_actual ? *value - *at_mm : *value;
    if (!read.side.empty()) row.setup = read.side;
    if (commanded && is_actual && IsMove(*commanded)) row.flag = "move";
    TakeState(record, &row);
    TakeLabel(record, &row);
    TakeSteps(record, axis, &row);
    imported_.table.rows.push_back(std::move(row));
  }

  // Steps/mm that were set, where the table tries several.
  void TakeSteps(const CsvRecord& record, std::size_t axis, Row* row) {
    const auto column = FirstOf(Part::kSteps);
    if (!column) return;
    const auto steps = NumberOf(record[column->index].text, sheet_.decimal);
    if (!steps || *steps <= 0) return;
    row->settings = record[column->index].text;
    imported_.header.settings[row->settings].steps_per_mm[std::string(1, "xyz"[axis])] =
        *steps;
  }

  [[noreturn]] void ThrowWithColumns() const {
    std::vector<std::string> columns;
    const std::size_t num = sheet_.records.front().size();
    for (std::size_t i = 0; i < num; ++i) {
      columns.push_back(
          sheet_.headings.empty()
              ? fmt::format("{} ({} ...)", i + 1, sheet_.records.front()[i].text)
              : fmt::format("{} '{}'", i + 1, sheet_.headings[i].text));
    }
    throw InputError(
        {.file = name_},
        fmt::format("which column is which? Found: {}", fmt::join(columns, ", ")),
        "headings that are understood: commanded, measured; axis, target, actual; x, "
        "y, "
        "height; target, error um. Or say it: caltwin import csv FILE --map "
        "'cmd_x_mm=1[mm],value_mm=2[um]' (a position in place of a deviation: "
        "actual_mm=2[mm])");
  }

  std::string name_;
  const ImportOptions& options_;
  Spreadsheet sheet_;
  std::vector<TableColumn> columns_{};
  Faults faults_{};
  Imported imported_{};
  std::string
      series_{};  ///< Heading of the column that is read, where there are several.
  bool takes_mm_ = false, takes_x_ = false, takes_feed_ = false;
};

}  // namespace

Imported ReadPlainTable(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  return TableReader(text, name, options).Read();
}

}  // namespace caltwin
