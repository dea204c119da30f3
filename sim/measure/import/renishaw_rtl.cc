#include <map>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/positioning.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

/// One line of `Run Target Data:`.
struct Deviation {
  int run = 0;
  std::size_t target = 0;  ///< From 0.
  double value = 0;        ///< In the file's unit.
  Place place{};
};

struct Rtl {
  std::vector<double> targets_mm{};
  std::vector<Deviation> deviations{};
  std::string axis{};  ///< As the operator wrote it.
};

class RtlReader {
 public:
  RtlReader(const std::string& text, std::string name, Faults* faults)
      : name_(std::move(name)), faults_(faults), lines_(LinesOf(text)) {}

  Rtl Read() {
    Part part = Part::kOther;
    for (const TextLine& line : lines_) {
      if (line.text.starts_with("Targets :") || line.text == "Targets:") {
        part = Part::kTargets;
      } else if (line.text.starts_with("Run Target Data:")) {
        part = Part::kDeviations;
      } else if (line.text.find(':') != std::string_view::npos) {
        part = Part::kOther;
        ReadAxis(line);
      } else if (part == Part::kTargets) {
        for (const CsvField& word : line.words) {
          rtl_.targets_mm.push_back(NumberIn(word, "a target", name_, faults_));
        }
      } else if (part == Part::kDeviations) {
        ReadDeviation(line);
      }
    }
    return std::move(rtl_);
  }

 private:
  enum class Part { kOther, kTargets, kDeviations };

  void ReadAxis(const TextLine& line) {
    constexpr std::string_view kKey = "Axis:";
    if (!line.text.starts_with(kKey)) return;
    const std::string axis = PlainWord(line.text.substr(kKey.size()));
    if (axis == "x" || axis == "y" || axis == "z") rtl_.axis = axis;
  }

  void ReadDeviation(const TextLine& line) {
    const CsvRecord& words = line.words;
    if (words.size() != 3) {
      faults_->Add(PlaceOf(words[0], name_),
                   fmt::format("{} words stand here", words.size()),
                   "under 'Run Target Data:' a line is: run, target number, deviation");
      return;
    }
    const double run = NumberIn(words[0], "the run", name_, faults_);
    const double target = NumberIn(words[1], "the target's number", name_, faults_);
    const double value = NumberIn(words[2], "the deviation", name_, faults_);
    const double count = static_cast<double>(rtl_.targets_mm.size());
    if (!(run >= 1 && run <= 1e6) || !(target >= 1 && target <= count)) {
      faults_->Add(
          PlaceOf(words[0], name_),
          fmt::format("run {:g}, target {:g}: there is no such target", run, target),
          fmt::format("{} targets are listed above", rtl_.targets_mm.size()));
      return;
    }
    rtl_.deviations.push_back({.run = static_cast<int>(run),
                               .target = static_cast<std::size_t>(target) - 1,
                               .value = value,
                               .place = PlaceOf(words[0], name_)});
  }

  std::string name_;
  Faults* faults_;
  std::vector<TextLine> lines_;
  Rtl rtl_;
};

/// The sense in which a run visits its targets; kUnknown where it visits but one.
double SenseOf(const Rtl& rtl, int run) {
  double first_mm = kUnknown;
  double sense = kUnknown;
  for (const Deviation& deviation : rtl.deviations) {
    if (deviation.run != run) continue;
    const double target_mm = rtl.targets_mm[deviation.target];
    if (!Known(first_mm)) first_mm = target_mm;
    if (target_mm != first_mm && !Known(sense)) sense = target_mm > first_mm ? 1 : -1;
  }
  return sense;
}

}  // namespace

Imported ReadRenishawRtl(const std::string& text,
                         const std::string& name,
                         const ImportOptions& options) {
  Faults faults;
  const Rtl rtl = RtlReader(text, name, &faults).Read();
  faults.ThrowIfAny();
  if (rtl.deviations.empty()) {
    throw InputError({.file = name}, "no readings stand under 'Run Target Data:'");
  }
  const Place& first = rtl.deviations.front().place;
  if (options.unit.empty()) {
    throw InputError(
        first,
        "this format does not say the unit of its deviations",
        "say it: --unit um or --unit mm (what the laser's display showed)");
  }
  const NamedUnit& unit = FindUnit(options.unit, Quantity::kLength, {.file = "--unit"});
  std::map<int, double> senses;
  std::vector<PositionReading> readings;
  for (const Deviation& deviation : rtl.deviations) {
    if (!senses.contains(deviation.run)) {
      senses[deviation.run] = SenseOf(rtl, deviation.run);
    }
    readings.push_back({.run = deviation.run,
                        .sense = senses[deviation.run],
                        .target_mm = rtl.targets_mm[deviation.target],
                        .value_mm = unit.convert(deviation.value),
                        .place = deviation.place});
  }
  std::vector<std::string> assumed = {
      "targets are in mm; a deviation is laser minus machine, actual minus commanded",
      "the sense of a run is that in which it lists its targets"};
  const std::string axis = AxisOr(rtl.axis, options, &assumed);
  Imported imported = PositioningRows(readings, axis, options);
  imported.assumed = std::move(assumed);
  imported.recognised = {fmt::format("Renishaw .rtl: {} targets, {} runs, axis {}",
                                     rtl.targets_mm.size(),
                                     senses.size(),
                                     axis)};
  return imported;
}

}  // namespace caltwin
