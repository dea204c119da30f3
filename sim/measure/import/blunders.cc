#include "sim/measure/import/blunders.h"

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/climb.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kLargestAdjustment_mm = 1000;
constexpr double kDeepestHeight_mm = -1;  // Below: no probe triggers there.

/// Looks for one kind of blunder in a line; keeps what it must remember.
class Seeker {
 public:
  /// Either may be null.
  Seeker(std::string name, Faults* faults, std::vector<FileNote>* notes)
      : name_(std::move(name)), faults_(faults), notes_(notes) {}

  /// Where the same measures gave sane arms elsewhere in the text, it was the software.
  void End() {
    if (!has_sane_arms_ || is_entered_anew_ || notes_ == nullptr) return;
    for (const std::size_t i : runaways_) {
      FileNote& note = (*notes_)[i];
      note.what = "firmware";
      note.sentence =
          note.sentence.substr(0, note.sentence.find(" What was entered")) +
          " The same measures gave arms that can be elsewhere in this file, "
          "so what was entered is right: the software that fitted it here "
          "is at fault. Use the other result, and update this one";
    }
  }

  void Look(const TextLine& line) {
    if (line.words.front().text == "DELTA_ANALYZE") LookAtLists(line);
    LookAtClimb(line);
    LookAtAdjustment(line);
    LookAtHeight(line);
    LookAtDeviation(line);
    LookAtArms(line);
  }

 private:
  // `reason`: of FileNote::what; empty: only a refusal.
  void Add(const TextLine& line,
           const std::string& text,
           const std::string& hint,
           const std::string& reason) {
    const Place place{.file = name_, .line = line.line, .column = line.words[0].column};
    if (faults_ != nullptr) faults_->Add(place, text, hint);
    if (notes_ == nullptr || reason.empty()) return;
    const bool is_setting = reason == "z_offset";
    notes_->push_back(
        {.kind = is_setting ? FileNote::Kind::kSetting : FileNote::Kind::kElsewhere,
         .what = reason,
         .sentence = fmt::format("line {}: {}; {}", line.line, text, hint),
         .place = place});
  }

  void LookAtLists(const TextLine& line) {
    for (const CsvField& word : line.words) {
      const std::size_t equals = word.text.find('=');
      if (equals == std::string::npos) continue;
      const std::string key = word.text.substr(0, equals);
      const std::string list = word.text.substr(equals + 1);
      is_entered_anew_ |= !keys_.insert(key).second;
      if (list.find(',') == std::string::npos) continue;
      const auto [first, is_new] = name_of_list_.emplace(list, key);
      if (is_new || first->second == key) continue;
      Add(line,
          fmt::format("{} repeats the list of {}", key, first->second),
          "two measurements of different things do not agree in every figure: the list "
          "was pasted twice. Enter what was measured",
          "file");
    }
  }

  void LookAtClimb(const TextLine& line) {
    if (line.words.size() < 3 || line.words[0].text != "z" ||
        line.words[1].text != "=") {
      return;
    }
    std::vector<double> heights_mm;
    for (std::size_t i = 2; i < line.words.size(); ++i) {
      const auto value = NumberOf(line.words[i].text);
      if (!value) return;
      heights_mm.push_back(*value);
    }
    const std::string climb = ClimbText(heights_mm);
    if (!climb.empty()) Add(line, climb, std::string(kClimbHint), "");
  }

  void LookAtAdjustment(const TextLine& line) {
    for (std::size_t i = 0; i + 2 < line.words.size(); ++i) {
      if (!line.words[i].text.starts_with("stepper_") ||
          line.words[i + 1].text != "=") {
        continue;
      }
      const auto adjustment_mm = NumberOf(line.words[i + 2].text);
      if (!adjustment_mm || std::abs(*adjustment_mm) < kLargestAdjustment_mm) continue;
      Add(line,
          fmt::format(
              "{} is to be moved by {:.0f} mm", line.words[i].text, *adjustment_mm),
          "the probed points do not tell how the screws stand: they lie on one line "
          "with, or beside, the pivots. Probe points spread in x and y",
          "firmware");
    }
  }

  void LookAtHeight(const TextLine& line) {
    if (line.words.size() != 4 || line.words[0].text != "#*#" ||
        line.words[2].text != "=" || has_height_) {
      return;
    }
    const std::string& key = line.words[1].text;
    const bool is_height = key.starts_with("height") && key.size() > 6 &&
                           key.find_first_not_of("0123456789", 6) == std::string::npos;
    const auto height_mm = NumberOf(line.words[3].text);
    if (!is_height || !height_mm || *height_mm > kDeepestHeight_mm) return;
    has_height_ = true;
    Add(line,
        fmt::format(
            "{} = {:g} mm: the probe would trigger below the bed", key, *height_mm),
        "z_offset has the wrong sign: it is the height of the nozzle above the bed at "
        "the trigger, above 0 for a probe that hangs lower than the nozzle. Correct "
        "it, "
        "probe again",
        "z_offset");
  }

  // "stepper_a: position_endstop: 130.8 angle: 300.3 arm_length: 1620.1", three lines.
  void LookAtArms(const TextLine& line) {
    constexpr double kMostApart = 1.15;
    constexpr std::size_t kTowers = 3;
    if (line.text.find("stepper_a:") != std::string_view::npos) arms_mm_.clear();
    const bool is_tower = line.text.find("stepper_") != std::string_view::npos;
    for (std::size_t i = 0; is_tower && i + 1 < line.words.size(); ++i) {
      const std::string& key = line.words[i].text;
      if (key != "arm:" && key != "arm_length:") continue;
      if (const auto arm_mm = NumberOf(line.words[i + 1].text))
        arms_mm_.push_back(*arm_mm);
    }
    if (arms_mm_.size() != kTowers) return;
    const auto [least, most] = std::ranges::minmax(arms_mm_);
    arms_mm_.clear();
    const bool is_sane = !(most > kMostApart * std::abs(least));
    has_sane_arms_ |= is_sane;
    if (is_sane) return;
    if (notes_ != nullptr) runaways_.push_back(notes_->size());
    Add(line,
        fmt::format("the arms are fitted to be {:.0f} to {:.0f} mm long", least, most),
        "no printer's arms differ so: the fit ran away, and none of its numbers is the "
        "machine's. Do not save it. What was entered for it is wrong (one list in "
        "place "
        "of another, a wrong unit), or the software that fitted it",
        "file");
  }

  void LookAtDeviation(const TextLine& line) {
    constexpr std::string_view kName = "std dev:";
    const std::size_t at = line.text.find(kName);
    if (at == std::string_view::npos) return;
    std::string_view rest = line.text.substr(at + kName.size());
    rest = rest.substr(0, rest.find_first_of(" \t"));
    const auto deviation_mm = NumberOf(rest);
    if (!deviation_mm || *deviation_mm >= 0) return;
    Add(line,
        fmt::format("a standard deviation of {:g} mm", *deviation_mm),
        "below 0 it is an overflow of the firmware's arithmetic: its calibration ran "
        "away, and the geometry it prints beside it is worth nothing. Begin again from "
        "the drawing's figures",
        "firmware");
  }

  std::string name_;
  Faults* faults_;
  std::vector<FileNote>* notes_;
  std::map<std::string, std::string> name_of_list_;
  bool has_height_ = false;
  std::vector<double> arms_mm_{};
  /// @name Several fits of one set of measures
  std::set<std::string> keys_{};  ///< Of what was entered.
  bool is_entered_anew_ = false;
  bool has_sane_arms_ = false;
  std::vector<std::size_t> runaways_{};  ///< Notes of fits that ran away.
};

}  // namespace

void RefuseBlunders(const std::string& text, const std::string& name) {
  Faults faults;
  Seeker seeker(name, &faults, nullptr);
  for (const TextLine& line : LinesOf(text)) seeker.Look(line);
  faults.ThrowIfAny();
}

std::vector<FileNote> BlundersIn(const std::string& text, const std::string& name) {
  std::vector<FileNote> notes;
  Seeker seeker(name, nullptr, &notes);
  for (const TextLine& line : LinesOf(text)) seeker.Look(line);
  seeker.End();
  return notes;
}

}  // namespace caltwin
