#include "sim/measure/import/cmm_plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

constexpr std::array<const char*, 4> kNeeded = {"measx", "measy", "nomx", "nomy"};
constexpr const char* kForm =
    "a table of holes has a heading with Meas X, Meas Y, Nom X and Nom Y, and a line "
    "of "
    "numbers a hole";
constexpr double kRounding_mm = 0.0021;  // Three figures rounded to 0.001 each.

/// Two-word headings as one: "Meas X" at the place of "Meas".
CsvRecord Headings(const CsvRecord& words) {
  CsvRecord headings;
  for (std::size_t i = 0; i < words.size(); ++i) {
    CsvField heading = words[i];
    const std::string first = PlainWord(heading.text);
    const bool is_first = first == "meas" || first == "nom" || first == "err";
    if (is_first && i + 1 < words.size()) heading.text += words[++i].text;
    heading.text = PlainWord(heading.text);
    headings.push_back(std::move(heading));
  }
  return headings;
}

class PlateReader {
 public:
  PlateReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    const std::size_t heading = FindHeading();
    unit_ = &FindUnit(options.unit.empty() ? "mm" : options.unit,
                      Quantity::kLength,
                      {.file = "--unit"});
    for (std::size_t i = heading + 1; i < lines_.size(); ++i) ReadHole(lines_[i]);
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty()) {
      throw InputError({.file = name_}, "no holes stand below the heading", kForm);
    }
    CheckErrors();
    Explain(options);
    return std::move(imported_);
  }

 private:
  std::size_t FindHeading() {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const CsvRecord headings = Headings(lines_[i].words);
      for (std::size_t j = 0; j < headings.size(); ++j) {
        is_twice_ |= !column_.emplace(headings[j].text, j).second;
      }
      const bool is_it = std::ranges::all_of(
          kNeeded, [&](const char* needed) { return column_.contains(needed); });
      if (is_it) {
        if (is_twice_) {
          throw InputError(PlaceOf(headings[0], name_), "a heading stands here twice");
        }
        num_columns_ = headings.size();
        for (const CsvField& field : headings) {
          if (IsKept(field.text))
            imported_.table.extra_columns.push_back("cmm_" + field.text);
        }
        return i;
      }
      column_.clear();
      is_twice_ = false;
      ReadTitle(lines_[i]);
    }
    throw InputError({.file = name_, .line = 1, .column = 1},
                     "no heading of a table of holes stands here",
                     kForm);
  }

  static bool IsKept(const std::string& heading) {
    return std::ranges::find(kNeeded, heading) == kNeeded.end() && heading != "errx" &&
           heading != "erry";
  }

  // "Plug Plate: 1396A", "PlugPlate 8131".
  void ReadTitle(const TextLine& line) {
    const std::string first = PlainWord(line.words.front().text);
    if (line.words.size() > 1 && (first == "plug" || first == "plugplate")) {
      plate_ = line.words.back().text;
    }
    imported_.table.comments.emplace_back(line.text);
  }

  void ReadHole(const TextLine& line) {
    const CsvRecord& words = line.words;
    if (words.size() != num_columns_) {
      faults_.Add(PlaceOf(words.front(), name_),
                  fmt::format("{} words, where the heading names {} columns",
                              words.size(),
                              num_columns_),
                  kForm);
      return;
    }
    const auto length_mm = [&](const std::string& column) {
      return unit_->convert(
          NumberIn(words[column_.at(column)], column, name_, &faults_));
    };
    std::vector<std::string> kept;
    for (const std::string& extra : imported_.table.extra_columns) {
      kept.push_back(words[column_.at(extra.substr(4))].text);
    }
    for (const int axis : {0, 1}) {
      const std::string letter = axis == 0 ? "x" : "y";
      Row row{.extra = kept, .place = PlaceOf(words.front(), name_)};
      row.cmd_mm[0] = length_mm("nomx");
      row.cmd_mm[1] = length_mm("nomy");
      row.n = {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, 0};
      row.value_mm = length_mm("meas" + letter) - row.cmd_mm[axis];
      row.feature = "plate.hole";
      if (column_.contains("err" + letter)) {
        const double stated_mm = length_mm("err" + letter);
        const double tolerance_mm = unit_->convert(kRounding_mm);
        num_errors_ += 1;
        num_disagree_ += std::abs(stated_mm - row.value_mm) > tolerance_mm;
        num_reversed_ += std::abs(stated_mm) > tolerance_mm &&
                         std::abs(stated_mm + row.value_mm) <= tolerance_mm;
      }
      imported_.table.rows.push_back(std::move(row));
    }
  }

  // The columns of errors must be what the table says of itself.
  void CheckErrors() {
    const Place place{.file = name_, .line = imported_.table.rows.front().place.line};
    if (num_reversed_ * 2 > num_errors_) {
      throw InputError(place,
                       "Err is nominal minus measured in this table: its sign is "
                       "reversed",
                       "value_mm is measured minus nominal. If Meas and Nom were "
                       "swapped in the heading, put that right; else remove the Err "
                       "columns");
    }
    if (num_disagree_ * 2 > num_errors_) {
      throw InputError(
          place,
          fmt::format(
              "Err is not Meas - Nom in {} of {} places", num_disagree_, num_errors_),
          "one of the three is in another unit or of another hole");
    }
    if (num_disagree_ > 0) {
      imported_.warnings.push_back(fmt::format(
          "Err is not Meas - Nom in {} of {} places; Meas and Nom were taken",
          num_disagree_,
          num_errors_));
    }
  }

  void Explain(const ImportOptions& options) {
    const std::string plate = plate_.empty() ? "plate" : plate_;
    const std::string campaign =
        options.campaign.empty() ? "cmm_" + plate : options.campaign;
    std::vector<double> values_mm;
    for (Row& row : imported_.table.rows) {
      row.campaign = campaign;
      row.setup = plate;
      values_mm.push_back(row.value_mm);
    }
    imported_.header.artefacts["plate"] = {.type = "plate"};
    imported_.header.instruments["cmm"] = {
        .kind = "cmm", .resolution_um = UmFromMm(StepOf(values_mm))};
    imported_.header.campaigns[campaign] = {.instrument = "cmm", .plan = "plate"};
    imported_.recognised = {fmt::format("plate {}: {} holes, two rows each",
                                        plate,
                                        imported_.table.rows.size() / 2),
                            "value = measured - nominal"};
    imported_.assumed = {fmt::format("lengths are in {}", unit_->name),
                         "where the machine that drilled was sent is Nom; the sense of "
                         "its last approach "
                         "is not known, so backlash cannot be told"};
  }

  std::string name_;
  std::vector<TextLine> lines_;
  Faults faults_;
  std::map<std::string, std::size_t> column_;
  bool is_twice_ = false;  ///< A heading.
  std::size_t num_columns_ = 0;
  const NamedUnit* unit_ = nullptr;
  std::string plate_;
  Imported imported_;
  int num_errors_ = 0, num_disagree_ = 0, num_reversed_ = 0;
};

}  // namespace

Imported ReadCmmPlate(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options) {
  return PlateReader(text, name).Read(options);
}

}  // namespace caltwin
