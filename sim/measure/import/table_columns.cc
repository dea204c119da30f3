#include "sim/measure/import/table_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "sim/measure/import/table_parts.h"

namespace caltwin {
namespace {

struct PartWords {
  Part part = Part::kNone;
  std::string_view words{};  ///< Parted by blanks.
};

// The first part one of whose words stands in a heading.
constexpr std::array kAllWords = {
    PartWords{Part::kFeed, "feed feedrate speed f"},
    PartWords{Part::kHome, "home homing"},
    PartWords{Part::kSteps, "steps step microsteps"},
    PartWords{Part::kSense, "dir direction sense approach moving"},
    PartWords{Part::kTemperature,
              "pinda temp temperature bed nozzle frame chamber ambient room screw"},
    PartWords{Part::kDeviation,
              "error err deviation dev diff difference off delta short"},
    PartWords{Part::kActual,
              "actual measured measure meas reading read reads moved real got calliper "
              "caliper calipers gauge indicator dial dro laser observed seen result "
              "travelled went printed ruler engraved milled enlev removed ist gemessen "
              "mesure says burned made obtained achieved actually scale is cut display "
              "came machined"},
    PartWords{
        Part::kCommanded,
        "commanded command cmd target nominal set setpoint expected told "
        "requested ideal design designed programmed size model asked jog avance "
        "consigne soll vorgabe gcode drawing should drawn wanted desired intended "
        "ordered nom theory theoretical sent cad file nc slicer"},
    PartWords{Part::kHeight,
              "height z probe probed trigger offset gap feeler clearance"},
    PartWords{
        Part::kRun,
        "run rep repeat repetition trial sample no n nr touch try pass pecks lifts "
        "cycles laps loops"},
    PartWords{Part::kTime, "time t min minutes s sec seconds minute"},
    PartWords{Part::kPosition, "position pos distance travel length at"},
    PartWords{Part::kAxis, "axis"},
    PartWords{Part::kSetup,
              "setup part place line piece feature calibration instrument"}};

// Whether one of `tokens` stands among `words`.
bool HasAny(std::string_view words, const std::vector<std::string>& tokens) {
  const std::string parted = fmt::format(" {} ", words);
  return std::ranges::any_of(tokens, [&](const std::string& token) {
    return parted.find(fmt::format(" {} ", token)) != std::string::npos;
  });
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

// "$100", "$101" or "$102", grbl's steps/mm; empty: none of them stands there.
std::string StepsSetting(const std::string& heading) {
  const std::size_t at = heading.find("$10");
  const bool is_there = at != std::string::npos && at + 3 < heading.size() &&
                        heading[at + 3] >= '0' && heading[at + 3] <= '2';
  return is_there ? heading.substr(at, 4) : "";
}

// "too high by", "too short": what is off, and which way. 0: nothing of the sort.
double SignOfExcess(const std::vector<std::string>& tokens) {
  constexpr std::string_view kMore =
      "high long large big far wide thick tall deep much";
  constexpr std::string_view kLess = "low short small narrow thin little";
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const bool is_too = i > 0 && tokens[i - 1] == "too";
    if (is_too && HasAny(kMore, {tokens[i]})) return 1;
    if ((is_too && HasAny(kLess, {tokens[i]})) || tokens[i] == "short") return -1;
  }
  return 0;
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
  for (const PartWords& words : kAllWords) {
    const bool is_meant = words.part == Part::kTemperature ? is_hot
                          : words.part == Part::kSteps
                              ? has("mm") || !StepsSetting(heading.text).empty()
                              : true;
    if (column.part == Part::kNone && is_meant && HasAny(words.words, tokens)) {
      column.part = words.part;
    }
  }
  if (!StepsSetting(heading.text).empty()) column.part = Part::kSteps;
  if (const double sign = SignOfExcess(tokens); sign != 0) {
    column.part = Part::kDeviation;
    column.sign = sign;
  }
  // "went wrong": whether it did.
  if (has("wrong")) column.part = Part::kNone;
  // "dial at Z0": read there.
  for (int axis = 0; axis < 3; ++axis) {
    if (column.axis < 0 && has(std::string(1, "xyz"[axis]) + "0")) column.axis = axis;
  }
  if (column.part == Part::kTemperature) column.temperature = TemperatureOf(tokens);
  // "across" and "up" of what was drawn.
  constexpr std::size_t kFewWords = 1;
  if (column.axis < 0 && tokens.size() <= kFewWords) {
    if (has("across") || has("width") || has("wide") || has("horizontal"))
      column.axis = 0;
    if (has("up") || has("vertical") || has("depth")) column.axis = 1;
  }
  // "too high by": off along Z.
  if (column.axis < 0 && column.part == Part::kDeviation && (has("high") || has("low")))
    column.axis = 2;
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

// Columns "forward" and "backward" are the same readings in either sense.
void TakeSenses(const Spreadsheet& sheet, std::vector<TableColumn>* columns) {
  constexpr std::string_view kPlus = "forward forwards fwd plus positive";
  constexpr std::string_view kMinus =
      "backward backwards bwd back reverse rev return returning minus negative";
  const auto is_read = [&](const TableColumn& column) {
    const bool may_be = column.part == Part::kNone || column.part == Part::kActual ||
                        column.part == Part::kDeviation;
    return may_be && AreNumbers(sheet, column.index);
  };
  const auto has = [&](const TableColumn& column, std::string_view words) {
    const std::vector<std::string> tokens = TokensOf(sheet.headings[column.index].text);
    const bool says_both = HasAny(kPlus, tokens) && HasAny(kMinus, tokens);
    return is_read(column) && HasAny(words, tokens) && !says_both &&
           !HasAny("tol tolerance limit", tokens);
  };
  const bool has_both =
      std::ranges::any_of(*columns,
                          [&](const auto& each) { return has(each, kPlus); }) &&
      std::ranges::any_of(*columns,
                          [&](const auto& each) { return has(each, kMinus); });
  // Beside a column that was read, what nothing names is something else.
  const bool has_other = std::ranges::any_of(*columns, [&](const TableColumn& each) {
    const bool is_named = each.part == Part::kActual || each.part == Part::kDeviation;
    return is_named && !has(each, kPlus) && !has(each, kMinus);
  });
  if (!has_both || has_other) return;
  for (TableColumn& column : *columns) {
    if (has(column, kPlus)) column.sense = 1;
    if (has(column, kMinus)) column.sense = -1;
    if (!Known(column.sense) || column.part != Part::kNone) continue;
    column.part = Part::kActual;
    column.unit =
        UnitInHeading(sheet.headings[column.index].text, QuantityOf(Part::kActual));
  }
}

// "mark run 1": where a run's number stands in the heading, what stands below was read
// in it.
void TakeRuns(const Spreadsheet& sheet, std::vector<TableColumn>* columns) {
  for (TableColumn& column : *columns) {
    if (column.part != Part::kRun || !AreNumbers(sheet, column.index)) continue;
    const std::vector<std::string> tokens = TokensOf(sheet.headings[column.index].text);
    const bool is_numbered =
        tokens.size() > 1 && std::ranges::any_of(tokens, [](const std::string& token) {
          return token.find_first_not_of("0123456789") == std::string::npos;
        });
    const std::vector<double> numbers = NumbersOf(sheet, column.index);
    const bool are_counts = std::ranges::all_of(
        numbers, [](double number) { return number == std::round(number); });
    if (is_numbered && !are_counts) column.part = Part::kNone;
  }
}

// Beside what is off, of several columns that may have been told the one of most
// different numbers; the others say what was set meanwhile.
void PartStates(const Spreadsheet& sheet, std::vector<TableColumn>* columns) {
  const auto different = [&](const TableColumn& column) {
    std::vector<double> numbers = NumbersOf(sheet, column.index);
    std::ranges::sort(numbers);
    const auto repeated = std::ranges::unique(numbers);
    return std::distance(numbers.begin(), repeated.begin());
  };
  const auto is_told = [&](const TableColumn& column) {
    return column.part == Part::kCommanded && AreNumbers(sheet, column.index);
  };
  const bool is_off = std::ranges::any_of(*columns, [](const TableColumn& column) {
    return column.part == Part::kDeviation;
  });
  if (!is_off || std::ranges::count_if(*columns, is_told) < 2) return;
  std::ptrdiff_t most = 0;
  for (const TableColumn& column : *columns) {
    if (is_told(column)) most = std::max(most, different(column));
  }
  constexpr std::ptrdiff_t kMostStates = 4;
  for (TableColumn& column : *columns) {
    const bool is_state =
        is_told(column) && different(column) < most && different(column) <= kMostStates;
    if (is_state) column.part = Part::kSetup;
  }
}

// Of several columns that may have been told, the one that what was read is nearest to;
// a pitch or a number of turns beside it is a state.
void KeepNearestCommand(const Spreadsheet& sheet, std::vector<TableColumn>* columns) {
  const auto is_plain = [&](const TableColumn& column) {
    return column.part == Part::kCommanded && column.axis < 0 &&
           AreNumbers(sheet, column.index);
  };
  const auto read = std::ranges::find(*columns, Part::kActual, &TableColumn::part);
  if (read == columns->end()) return PartStates(sheet, columns);
  if (!AreNumbers(sheet, read->index) ||
      std::ranges::count_if(*columns, is_plain) < 2) {
    return;
  }
  const std::vector<double> was_read = NumbersOf(sheet, read->index);
  TableColumn* nearest = nullptr;
  double least = HUGE_VAL;
  for (TableColumn& column : *columns) {
    if (!is_plain(column)) continue;
    const std::vector<double> told = NumbersOf(sheet, column.index);
    double sum = 0;
    for (std::size_t i = 0; i < std::min(told.size(), was_read.size()); ++i) {
      sum += std::abs(told[i] - was_read[i]);
    }
    if (sum < least) nearest = &column;
    least = std::min(least, sum);
  }
  for (TableColumn& column : *columns) {
    if (is_plain(column) && &column != nearest) column.part = Part::kNone;
  }
}

}  // namespace

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

std::string InstrumentIn(const std::string& label) {
  constexpr std::array<std::string_view, 13> kInstruments = {"laser",
                                                             "interferometer",
                                                             "dial",
                                                             "indicator",
                                                             "calliper",
                                                             "caliper",
                                                             "calipers",
                                                             "micrometer",
                                                             "dro",
                                                             "scale",
                                                             "ruler",
                                                             "probe",
                                                             "ballbar"};
  for (const std::string& token : TokensOf(label)) {
    if (std::ranges::find(kInstruments, token) != kInstruments.end()) return token;
  }
  return "";
}

bool IsSideWord(const std::string& token) {
  constexpr std::array<std::string_view, 8> kSides = {
      "outside", "outer", "external", "boss", "inside", "inner", "internal", "hole"};
  return std::ranges::find(kSides, token) != kSides.end();
}

std::vector<TableColumn> ColumnsOf(const Spreadsheet& sheet,
                                   std::vector<std::string>* taken) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < sheet.records.front().size(); ++i) {
    columns.push_back(sheet.headings.empty() ? TableColumn{.index = i}
                                             : ColumnOf(sheet.headings[i], i));
  }
  for (TableColumn& column : columns) {
    // "File": names of files, where no numbers stand there.
    const bool may_be_name =
        column.part == Part::kCommanded && !AreNumbers(sheet, column.index) &&
        HasAny("file nc", TokensOf(sheet.headings[column.index].text));
    if (may_be_name) column.part = Part::kNone;
  }
  if (!sheet.headings.empty()) {
    TakeSenses(sheet, &columns);
    TakeRuns(sheet, &columns);
  }
  TakePartsByNumbers(sheet, &columns, taken);
  KeepNearestCommand(sheet, &columns);
  return columns;
}

}  // namespace caltwin
