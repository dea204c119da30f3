#include "sim/measure/import/plain_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/square_lengths.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/table_derived.h"
#include "sim/measure/import/table_notes.h"
#include "sim/measure/import/table_remarks.h"
#include "sim/measure/import/unit.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

class TableReader {
 public:
  TableReader(const std::string& text, std::string name, const ImportOptions& options)
      : name_(std::move(name)),
        options_(options),
        sheet_(ReadSpreadsheet(WithoutMarkup(text), name_, PlaceCells::kParted)) {
    PartCells(&sheet_);
    for (const std::string& found : {DropDerived(&sheet_), PartSenses(&sheet_)}) {
      if (!found.empty()) imported_.assumed.push_back(found);
    }
    are_states_ = FirstHeading() == "nominal" && !imported_.assumed.empty();
  }

  /// What stands around the table, and in its remarks.
  void TakeRemarks(const std::string& text) { remarks_ = RemarksIn(text); }

  Imported Read() {
    columns_ = ColumnsOf(sheet_, &imported_.assumed);
    if (ReadSquares(sheet_, name_, &imported_)) {
      // Its rows stand there.
    } else if (HasBoth()) {
      ReadBoth();
    } else if (HasHeights()) {
      ReadHeights(*HeightColumn(), "heights");
    } else if (!ReadMoves()) {
      AddDifferences(sheet_, &imported_);
      if (imported_.notes.empty()) ThrowWithColumns();
    }
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty() && imported_.notes.empty()) ThrowWithColumns();
    if (imported_.table.rows.empty()) imported_.table.extra_columns.clear();
    for (Row& row : imported_.table.rows) {
      if (!options_.campaign.empty()) row.campaign = options_.campaign;
      // A line may have no label.
      row.extra.resize(imported_.table.extra_columns.size());
    }
    NameInstruments();
    imported_.recognised.insert(imported_.recognised.begin(),
                                fmt::format("a table of {} lines: {} readings",
                                            sheet_.records.size(),
                                            imported_.table.rows.size()));
    if (takes_mm_)
      imported_.assumed.emplace_back("lengths are in mm: nothing says otherwise");
    if (takes_inches_)
      imported_.assumed.emplace_back("lengths are in inches, as the text says");
    if (takes_steps_)
      imported_.assumed.push_back(
          fmt::format("readings count steps of {:.4g} um, as the text says",
                      UmFromMm(remarks_.step_mm)));
    imported_.has_unit = true;
    return std::move(imported_);
  }

 private:
  std::string FirstHeading() const {
    return sheet_.headings.empty() ? "" : sheet_.headings.front().text;
  }

  std::vector<TableColumn> Of(Part part, int axis = -1) const {
    std::vector<TableColumn> found;
    for (const TableColumn& column : columns_) {
      if (column.part == part && (axis < 0 || column.axis == axis))
        found.push_back(column);
    }
    return found;
  }

  std::string HeadingOf(const TableColumn& column) const {
    return sheet_.headings.empty() ? "" : sheet_.headings[column.index].text;
  }

  std::optional<TableColumn> FirstOf(Part part, int axis = -1) const {
    const auto found = Of(part, axis);
    return found.empty() ? std::nullopt : std::optional(found.front());
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
    std::optional<double> value = NumberOf(word, sheet_.decimal);
    if (!value) {
      faults_.Add(PlaceOf(field, name_),
                  fmt::format("'{}' is no number", field.text),
                  "an unknown value is an empty field");
    } else if (column.unit != nullptr) {
      value = column.unit->convert(*value);
    } else if (QuantityOf(column.part) == Quantity::kLength) {
      const bool is_counted = IsCounted(column);
      if (is_counted) *value *= remarks_.step_mm;
      if (!is_counted && remarks_.are_in_inches) value = MmFromInch(*value);
      (is_counted               ? takes_steps_
       : remarks_.are_in_inches ? takes_inches_
                                : takes_mm_) = true;
    }
    return value;
  }

  // Whether a column of readings counts steps: whole numbers all through.
  bool IsCounted(const TableColumn& column) {
    const bool is_read = column.part == Part::kActual ||
                         column.part == Part::kDeviation ||
                         column.part == Part::kHeight;
    if (!(remarks_.step_mm > 0) || !is_read) return false;
    const auto [known, is_new] = are_whole_.try_emplace(column.index, false);
    if (is_new) {
      known->second = std::ranges::all_of(
          NumbersOf(sheet_, column.index),
          [](double number) { return number == std::round(number); });
    }
    return known->second;
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
          const bool is_min = HeadingOf(column).starts_with("min") ||
                              PlainWord(HeadingOf(column)).starts_with("minute");
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
      if (IsSideWord(token)) row->setup = token;
    }
  }

  // A probe and another gauge at the same places.
  bool HasBoth() const {
    return FirstOf(Part::kHeight) && FirstOf(Part::kActual) && PlaceOn(0) &&
           PlaceOn(1) && !FirstOf(Part::kCommanded);
  }

  void ReadBoth() {
    for (const Part part : {Part::kHeight, Part::kActual}) {
      const TableColumn column = *FirstOf(part);
      ReadHeights(column, "gauge_" + PlainWord(HeadingOf(column)));
    }
  }

  // What tells the lines of a table of heights apart, where each word stands at three
  // lines or more and there are two to four words; the reading's campaign then.
  std::optional<TableColumn> Groups() const {
    constexpr std::size_t kMost = 4;
    constexpr int kFewest = 3;
    for (const TableColumn& column : Of(Part::kSetup)) {
      std::map<std::string, int> words;
      for (const CsvRecord& record : sheet_.records) ++words[record[column.index].text];
      const bool are_groups = words.size() > 1 && words.size() <= kMost &&
                              std::ranges::all_of(words, [](const auto& word) {
                                return word.second >= kFewest;
                              });
      if (are_groups) return column;
    }
    return std::nullopt;
  }

  void ReadHeights(const TableColumn& height, const std::string& campaign) {
    const auto words = TokensOf(HeadingOf(height));
    const bool is_gap = std::ranges::any_of(words, [](const std::string& word) {
      return word == "gap" || word == "feeler" || word == "clearance";
    });
    const auto x = PlaceOn(0), y = PlaceOn(1), groups = Groups();
    for (const CsvRecord& record : sheet_.records) {
      const auto value = NumberAt(record, height);
      if (!value) continue;
      Row row{.campaign = groups ? PlainWord(record[groups->index].text) : campaign,
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
    if (!column && GoesUpAndDown()) return 2;
    takes_x_ |= !column.has_value();
    return 0;
  }

  // Senses that only a height has.
  bool GoesUpAndDown() const {
    const auto sense = FirstOf(Part::kSense);
    return sense && std::ranges::all_of(sheet_.records, [&](const CsvRecord& record) {
             const std::string word = PlainWord(record[sense->index].text);
             return word == "up" || word == "down";
           });
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

  // "X real (told X10)": what was told stands in the heading; kUnknown of others.
  double ToldIn(const TableColumn& column) const {
    constexpr std::array<std::string_view, 3> kWords = {"told", "commanded", "set"};
    const std::vector<std::string> tokens = TokensOf(HeadingOf(column));
    for (std::size_t i = 1; i < tokens.size(); ++i) {
      std::string number = tokens[i];
      if (std::ranges::find(kWords, tokens[i - 1]) == kWords.end()) continue;
      if (number[0] >= 'x' && number[0] <= 'z') number.erase(0, 1);
      if (const auto told = NumberOf(number)) return *told;
    }
    return kUnknown;
  }

  // One column a line of places: read along its letter, at what the other columns say.
  bool ReadLines(int letter) {
    const std::vector<TableColumn> read = Of(Part::kActual, letter);
    const bool are_lines =
        !read.empty() && std::ranges::all_of(read, [&](const auto& each) {
          return Known(ToldIn(each));
        });
    if (!are_lines || letter < 0) return false;
    const auto axis = static_cast<std::size_t>(letter);
    for (const TableColumn& column : read) {
      for (const CsvRecord& record : sheet_.records) {
        const auto value = NumberAt(record, column);
        if (!value) continue;
        Row row{.campaign = fmt::format("line_{:g}", ToldIn(column)),
                .place = PlaceOf(record.front(), name_)};
        for (int other = 0; other < 3; ++other) {
          const auto place = PlaceOn(other);
          if (other != letter && place)
            row.cmd_mm[static_cast<std::size_t>(other)] =
                NumberAt(record, *place).value_or(kUnknown);
        }
        row.cmd_mm[axis] = ToldIn(column);
        row.n = {0, 0, 0};
        row.n[axis] = 1;
        row.value_mm = *value - row.cmd_mm[axis];
        TakeState(record, &row);
        TakeLabel(record, &row);
        imported_.table.rows.push_back(std::move(row));
      }
    }
    imported_.is_deviation = true;
    imported_.assumed.emplace_back(
        "value = read - told, as the headings have it, a line of places a column");
    return true;
  }

  bool ReadPair(int letter) {
    if (ReadLines(letter)) return true;
    auto commanded = FirstOf(Part::kCommanded, letter);
    if (!commanded) commanded = FirstOf(Part::kPosition, letter);
    if (!commanded && letter >= 0) commanded = FirstOf(Part::kCommanded);
    if (!commanded && letter >= 0) commanded = FirstOf(Part::kPosition);
    const std::vector<TableColumn> actual = Of(Part::kActual, letter);
    const std::vector<TableColumn> deviation = Of(Part::kDeviation, letter);
    if (actual.empty() && deviation.empty()) return false;
    AddDifferences(sheet_, &imported_);
    // An artefact that is not what it is believed to be: nothing of the machine is
    // read.
    const bool lacks_unit =
        actual.empty() && deviation.front().unit == nullptr && options_.unit.empty();
    const bool is_artefact =
        !imported_.notes.empty() && imported_.notes.front().what != "firmware";
    if (is_artefact && (!commanded || lacks_unit)) return false;
    if (!commanded && actual.size() == 2 && deviation.empty() && letter < 0) {
      ReadSides(actual[0], actual[1]);
      return true;
    }
    if (!commanded) {
      imported_.assumed.emplace_back(
          "all readings are of one place: no command stands beside them");
    }
    const bool is_actual =
        commanded && !actual.empty() && !AreDeviations(*commanded, actual);
    const bool is_dial = !actual.empty() && !is_actual;
    const std::vector<TableColumn>& read = is_actual || is_dial ? actual : deviation;
    const bool are_senses = std::ranges::all_of(
        read, [](const TableColumn& column) { return Known(column.sense); });
    const bool has_series = read.size() > 1 && !are_senses &&
                            (!is_actual || are_states_ || AreInstruments(read));
    for (const TableColumn& column : read) {
      series_ = has_series ? HeadingOf(column) : "";
      RequireUnit(column, is_actual || is_dial);
      for (const CsvRecord& record : sheet_.records)
        AddMove(record, commanded, column, letter, is_actual);
    }
    if (is_dial && remarks_.define_lost_motion && !FirstOf(Part::kSense))
      PartLostMotion();
    imported_.is_deviation = is_actual;
    imported_.assumed.emplace_back(
        is_actual ? "value = read - commanded"
        : is_dial ? "the gauge was set to nought at each target: it reads what "
                    "is off there"
        : read.front().sign < 0
            ? fmt::format("'{}' is commanded minus read", HeadingOf(read.front()))
            : "the deviation is read minus commanded");
    if (takes_x_)
      imported_.assumed.emplace_back("the axis is x: nothing names it (--axis)");
    return true;
  }

  // Each reading is how far a place come upon from + lies from the same come upon from
  // -, which is 0.
  void PartLostMotion() {
    std::vector<Row> both;
    for (Row& row : imported_.table.rows) {
      const auto axis =
          static_cast<std::size_t>(std::ranges::find(row.n, 1.0) - row.n.begin());
      Row other = row;
      other.dir[axis] = 1;
      other.value_mm = 0;
      row.dir[axis] = -1;
      row.flag = other.flag = kLostMotionFlag;
      both.push_back(std::move(other));
      both.push_back(std::move(row));
    }
    imported_.table.rows = std::move(both);
    imported_.assumed.emplace_back(
        "each reading is lost motion, as the text says: what lies between the same "
        "place "
        "come upon from + and from -");
  }

  // Two sides measured at once: how far the second is from the first.
  void ReadSides(const TableColumn& first, const TableColumn& second) {
    for (const CsvRecord& record : sheet_.records) {
      const auto one = NumberAt(record, first), other = NumberAt(record, second);
      if (!one || !other) continue;
      Row row{.campaign = "sides", .place = PlaceOf(record.front(), name_)};
      const auto axis = static_cast<std::size_t>(AxisIn(record));
      row.cmd_mm[axis] = 0;
      row.n = {0, 0, 0};
      row.n[axis] = 1;
      row.value_mm = *other - *one;
      TakeState(record, &row);
      TakeLabel(record, &row);
      row.flag = kSidesFlag;
      imported_.table.rows.push_back(std::move(row));
    }
    imported_.is_deviation = true;
    imported_.assumed.push_back(
        fmt::format("value = '{}' less '{}'", HeadingOf(second), HeadingOf(first)));
  }

  // A dial that is set to nought at every target reads what is off, not where it is:
  // small against the targets, and hardly growing from one to the next.
  bool AreDeviations(const TableColumn& commanded,
                     const std::vector<TableColumn>& read) {
    constexpr double kSmall = 0.05;
    std::vector<double> told_mm, read_mm;
    for (const CsvRecord& record : sheet_.records) {
      if (const auto at_mm = NumberAt(record, commanded)) told_mm.push_back(*at_mm);
      for (const TableColumn& column : read) {
        if (const auto value_mm = NumberAt(record, column))
          read_mm.push_back(*value_mm);
      }
    }
    if (told_mm.empty() || read_mm.empty()) return false;
    const auto [least_told_mm, most_told_mm] = std::ranges::minmax(told_mm);
    const auto [least_read_mm, most_read_mm] = std::ranges::minmax(read_mm);
    const double farthest_mm =
        std::max(std::abs(least_told_mm), std::abs(most_told_mm));
    const double largest_mm = std::max(std::abs(least_read_mm), std::abs(most_read_mm));
    const bool is_small = largest_mm < kSmall * farthest_mm;
    // Of one target, or of a table of positions counted from elsewhere.
    const double nearest_mm =
        std::ranges::min(told_mm, {}, [](double mm) { return std::abs(mm); });
    const bool is_far = largest_mm < kSmall * std::abs(nearest_mm);
    const bool is_level =
        most_read_mm - least_read_mm < kSmall * (most_told_mm - least_told_mm);
    // Sizes in inches beside millimetres are small as well, and all by one factor.
    constexpr double kOfInches = 0.02;
    const bool is_level_and_slight =
        is_level &&
        (most_read_mm - least_read_mm < kOfInches * (most_told_mm - least_told_mm) ||
         least_read_mm * most_read_mm <= 0);
    return (is_small && (is_level_and_slight || is_far)) ||
           AreLevelByAxis(commanded, read);
  }

  // A dial that reads about the same however far the axis was sent: of each axis, what
  // was read grows by less than a twentieth of what was told.
  bool AreLevelByAxis(const TableColumn& commanded,
                      const std::vector<TableColumn>& read) {
    constexpr double kSmall = 0.05;
    const auto axis = FirstOf(Part::kAxis);
    if (!axis) return false;
    std::map<std::string, std::vector<std::array<double, 2>>> by_axis;
    for (const CsvRecord& record : sheet_.records) {
      const auto told_mm = NumberAt(record, commanded);
      for (const TableColumn& column : read) {
        const auto read_mm = NumberAt(record, column);
        if (told_mm && read_mm)
          by_axis[PlainWord(record[axis->index].text)].push_back({*told_mm, *read_mm});
      }
    }
    double told2 = 0, both = 0;
    for (const auto& [name, pairs] : by_axis) {
      std::array<double, 2> mean{};
      for (const auto& pair : pairs) {
        for (std::size_t k = 0; k < 2; ++k)
          mean[k] += pair[k] / static_cast<double>(pairs.size());
      }
      for (const auto& pair : pairs) {
        told2 += std::pow(pair[0] - mean[0], 2);
        both += (pair[0] - mean[0]) * (pair[1] - mean[1]);
      }
    }
    return told2 > 0 && std::abs(both) < kSmall * told2;
  }

  // Whether each column was read off an instrument of its own.
  bool AreInstruments(const std::vector<TableColumn>& read) const {
    std::set<std::string> instruments;
    for (const TableColumn& column : read) {
      const std::string instrument = InstrumentIn(HeadingOf(column));
      if (instrument.empty() || !instruments.insert(instrument).second) return false;
    }
    return true;
  }

  // Campaigns that have each an instrument in their names.
  void NameInstruments() {
    std::map<std::string, std::string> instruments;
    for (const Row& row : imported_.table.rows) {
      instruments[row.campaign] = InstrumentIn(row.campaign);
    }
    const bool are_named =
        instruments.size() > 1 && std::ranges::none_of(instruments, [](const auto& of) {
          return of.second.empty();
        });
    if (!are_named) return;
    for (const auto& [campaign, instrument] : instruments) {
      imported_.header.instruments[instrument].kind = instrument;
      imported_.header.campaigns[campaign].instrument = instrument;
    }
  }

  // A position's unit is that of the command, a deviation's may be any.
  void RequireUnit(const TableColumn& column, bool is_actual) {
    if (is_actual || column.unit != nullptr || !options_.unit.empty()) return;
    faults_.Add(PlaceOf(sheet_.headings[column.index], name_),
                fmt::format("nothing says the unit of '{}'", HeadingOf(column)),
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
    const auto tokens = TokensOf(HeadingOf(commanded));
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
    const auto groups = Groups();
    Row row{.campaign = !series_.empty() ? series_
                        : groups         ? PlainWord(record[groups->index].text)
                                         : "moves",
            .place = PlaceOf(record.front(), name_)};
    row.cmd_mm[axis] = *at_mm;
    if (remarks_.is_homed && !commanded)
      row.home = fmt::format("{}", record.front().line);
    for (int other = 0; other < 3 && letter >= 0; ++other) {
      const auto also = FirstOf(Part::kCommanded, other);
      if (other == letter || !also) continue;
      row.cmd_mm[static_cast<std::size_t>(other)] =
          NumberAt(record, *also).value_or(kUnknown);
    }
    row.dir[axis] = Known(read.sense) ? read.sense : SenseIn(record);
    row.n = {0, 0, 0};
    row.n[axis] = 1;
    row.value_mm = is_actual ? *value - *at_mm : read.sign * *value;
    if (!read.side.empty()) row.setup = read.side;
    if (commanded && is_actual && IsMove(*commanded)) row.flag = kMoveFlag;
    if (are_states_ && remarks_.are_distances) row.flag = kDistanceFlag;
    if (const auto event = FirstOf(Part::kEvent)) {
      const std::string word = PlainWord(record[event->index].text);
      if (word.starts_with('y') || word == "true")
        row.flag = std::string(kAfterFlag) + PlainWord(HeadingOf(*event));
    }
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
    if (!steps) return;
    constexpr Bounds kBounds = SettingsInForce::kSteps_per_mm;
    if (!kBounds.Contains(*steps)) {
      faults_.Add(PlaceOf(record[column->index], name_),
                  fmt::format("{:.9g} steps/mm is outside {:g} .. {:g}",
                              *steps,
                              kBounds.min,
                              kBounds.max));
      return;
    }
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
  std::map<std::size_t, bool> are_whole_{};  ///< By column: whole numbers alone.
  TableRemarks remarks_{};
  bool takes_mm_ = false, takes_x_ = false, takes_feed_ = false, takes_steps_ = false;
  bool takes_inches_ = false;
  bool are_states_ = false;  ///< Each column is the machine in another state.
};

}  // namespace

Imported ReadOneTable(const std::string& table,
                      const std::string& around,
                      const std::string& name,
                      const ImportOptions& options) {
  TableReader reader(table, name, options);
  reader.TakeRemarks(around);
  return reader.Read();
}

}  // namespace caltwin
