#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/positioning.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

constexpr int kMostIndex = 100'000;

/// `KEY[i]=value` or `KEY[i,j]=value`; j is 0 where it is not written.
struct Entry {
  std::string_view key{};
  int position = 0;
  int run = 0;
  CsvField value{};
};

class EcmcReader {
 public:
  EcmcReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    for (const TextLine& line : lines_) ReadLine(line);
    CheckWhole();
    faults_.ThrowIfAny();
    std::vector<std::string> assumed = {
        "forward readings of a run come before its backward ones; the file has no "
        "times"};
    const std::string axis = AxisOr(axis_, options, &assumed);
    const NamedUnit& unit =
        FindUnit(options.unit.empty() ? unit_ : options.unit, Quantity::kLength, {});
    Imported imported = PositioningRows(Readings(unit), axis, options);
    imported.assumed = std::move(assumed);
    imported.recognised = {
        fmt::format("ecmc ISO 230-2 data: {} positions, {} runs, {}",
                    targets_.size(),
                    num_runs_,
                    backward_.empty() ? "forward only" : "both directions"),
        fmt::format("axis {}{}, unit {}",
                    axis,
                    axis_.empty() ? "" : fmt::format(" (from TGT_SET_PV)"),
                    unit.name),
        "value = REF_DATA - TGT_DATA, actual minus commanded"};
    return imported;
  }

 private:
  using Cells = std::map<std::pair<int, int>, CsvField>;

  void ReadLine(const TextLine& line) {
    const std::size_t equals = line.text.find('=');
    if (line.text.starts_with('#') || equals == std::string_view::npos) return;
    const std::string_view key = line.text.substr(0, equals);
    const CsvField value{
        .text = std::string(line.text.substr(equals + 1)),
        .line = line.line,
        .column = line.words.front().column + static_cast<int>(equals) + 1};
    if (key == "UNIT") unit_ = value.text;
    if (key == "TGT_SET_PV") axis_ = AxisIn(value.text);
    if (key.starts_with("TGT_DATA[")) Keep(key, value, 1, &targets_);
    if (key.starts_with("REF_DATA_FWD[")) Keep(key, value, 2, &forward_);
    if (key.starts_with("REF_DATA_BWD[")) Keep(key, value, 2, &backward_);
  }

  // "TARGET_DU:X-PosCmd" names X; "IOC_TEST:Axis1-PosSet" names none.
  static std::string AxisIn(std::string_view channel) {
    channel.remove_prefix(std::min(channel.size(), channel.rfind(':') + 1));
    if (channel.size() < 2 || channel[1] != '-') return "";
    const std::string letter = PlainWord(channel.substr(0, 1));
    return letter == "x" || letter == "y" || letter == "z" ? letter : "";
  }

  void Keep(std::string_view key, const CsvField& value, int indices, Cells* cells) {
    std::string_view inside = key.substr(key.find('[') + 1);
    if (!inside.ends_with(']')) return Refuse(value, key);
    inside.remove_suffix(1);
    const std::size_t comma = inside.find(',');
    if ((comma != std::string_view::npos) != (indices == 2)) return Refuse(value, key);
    const auto position = NumberOf(inside.substr(0, comma));
    const auto run = indices == 2 ? NumberOf(inside.substr(comma + 1)) : 0;
    const auto is_index = [](double i) {
      return i >= 0 && i <= kMostIndex && i == static_cast<int>(i);
    };
    if (!position || !run || !is_index(*position) || !is_index(*run)) {
      return Refuse(value, key);
    }
    const bool is_new =
        cells
            ->emplace(std::pair(static_cast<int>(*position), static_cast<int>(*run)),
                      value)
            .second;
    if (!is_new) {
      faults_.Add(PlaceOf(value, name_), fmt::format("{} stands here twice", key));
    }
  }

  void Refuse(const CsvField& value, std::string_view key) {
    faults_.Add(PlaceOf(value, name_),
                fmt::format("'{}' is no index of this format", key),
                "it is TGT_DATA[position], REF_DATA_FWD[position,run] or "
                "REF_DATA_BWD[position,run], each from 1");
  }

  // Every run has every position: a reading missing in between is named.
  void CheckWhole() {
    if (forward_.empty() && backward_.empty() && faults_.empty()) {
      throw InputError({.file = name_},
                       "there are targets here, but no REF_DATA_FWD or REF_DATA_BWD");
    }
    for (const Cells* cells : {&forward_, &backward_}) {
      for (const auto& [index, value] : *cells) {
        num_runs_ = std::max(num_runs_, index.second);
        if (targets_.contains({index.first, 0})) continue;
        faults_.Add(PlaceOf(value, name_),
                    fmt::format("position {} has no TGT_DATA", index.first));
      }
    }
  }

  std::vector<PositionReading> Readings(const NamedUnit& unit) {
    std::vector<PositionReading> readings;
    std::set<int> runs;
    for (const auto& [index, value] : forward_) runs.insert(index.second);
    for (const auto& [index, value] : backward_) runs.insert(index.second);
    for (const int run : runs) {
      const auto add = [&](const Cells& cells, int position, double sense) {
        const auto cell = cells.find({position, run});
        if (cell == cells.end()) return;
        const CsvField& target = targets_.at({position, 0});
        const double target_mm = Length_mm(target, unit);
        readings.push_back({.run = run,
                            .sense = sense,
                            .target_mm = target_mm,
                            .value_mm = Length_mm(cell->second, unit) - target_mm,
                            .place = PlaceOf(cell->second, name_)});
      };
      const bool is_up = Length_mm(targets_.begin()->second, unit) <=
                         Length_mm(targets_.rbegin()->second, unit);
      const double forward = is_up ? 1 : -1;
      for (const auto& [index, value] : targets_) add(forward_, index.first, forward);
      for (auto target = targets_.rbegin(); target != targets_.rend(); ++target) {
        add(backward_, target->first.first, -forward);
      }
    }
    faults_.ThrowIfAny();
    return readings;
  }

  double Length_mm(const CsvField& field, const NamedUnit& unit) {
    return unit.convert(NumberIn(field, "a position", name_, &faults_));
  }

  std::string name_;
  std::vector<TextLine> lines_;
  Faults faults_;
  std::string unit_ = "mm";
  std::string axis_{};
  int num_runs_ = 0;
  Cells targets_, forward_, backward_;
};

}  // namespace

Imported ReadEcmcIso230(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  return EcmcReader(text, name).Read(options);
}

}  // namespace caltwin
