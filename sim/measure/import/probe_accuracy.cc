#include "sim/measure/import/probe_accuracy.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/climb.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

class LogReader {
 public:
  LogReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    for (const TextLine& line : lines_) ReadLine(line);
    Finish();
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty()) {
      throw InputError({.file = name_, .line = 1, .column = 1},
                       "no touches stand here",
                       "a touch is 'probe at X,Y is z=Z' (Klipper) or 'N of M: z: Z' "
                       "(Marlin M48)");
    }
    for (Row& row : imported_.table.rows) {
      if (!options.campaign.empty()) row.campaign = options.campaign + row.campaign;
    }
    std::vector<double> values_mm;
    for (const Row& row : imported_.table.rows) values_mm.push_back(row.value_mm);
    imported_.recognised = {fmt::format("a probing log: {} touches in {} {}",
                                        imported_.table.rows.size(),
                                        num_batches_,
                                        num_batches_ == 1 ? "batch" : "batches")};
    if (const double step_mm = StepOf(values_mm); step_mm > 0) {
      imported_.recognised.push_back(
          fmt::format("readings come in steps of {:.4g} um", UmFromMm(step_mm)));
    }
    imported_.assumed = {
        "z is the height reported at the trigger in mm, + is up; the bed's nominal "
        "height is 0",
        "batches share neither home nor settings, and nothing about noise"};
    return std::move(imported_);
  }

 private:
  void ReadLine(const TextLine& line) {
    const bool is_klipper = line.text.starts_with("PROBE_ACCURACY at");
    if (is_klipper || line.text.starts_with("M48")) {
      Begin();
      const auto x_mm = NumberAfter(line.text, is_klipper ? "X:" : " X");
      const auto y_mm = NumberAfter(line.text, is_klipper ? "Y:" : " Y");
      x_mm_ = x_mm.value_or(kUnknown);
      y_mm_ = y_mm.value_or(kUnknown);
      feed_mm_s_ = NumberAfter(line.text, " speed=").value_or(kUnknown);
      if (feed_mm_s_ < 0) feed_mm_s_ = kUnknown;
      return;
    }
    constexpr std::string_view kProbe = "probe at ";
    const std::size_t at = line.text.find(kProbe);
    if (at != std::string_view::npos && !line.text.starts_with('#')) {
      ReadKlipper(line, line.text.substr(0, at), line.text.substr(at + kProbe.size()));
    } else if (line.words.size() >= 4 && line.words[1].text == "of" &&
               NumberOf(line.words[0].text)) {
      ReadMarlin(line);
    }
  }

  void ReadKlipper(const TextLine& line,
                   std::string_view before,
                   std::string_view after) {
    const std::size_t comma = after.find(',');
    const std::string_view rest =
        comma == std::string_view::npos ? "" : after.substr(comma + 1);
    const auto x_mm = NumberOf(after.substr(0, comma));
    const auto y_mm = NumberOf(rest.substr(0, rest.find(' ')));
    const auto z_mm = NumberAfter(after, "z=");
    if (!x_mm || !y_mm || !z_mm) return Refuse(line);
    if (num_batches_ == 0) Begin();
    if (x_mm.value() != x_mm_ || y_mm.value() != y_mm_) CheckClimb();
    x_mm_ = x_mm.value();
    y_mm_ = y_mm.value();
    const auto time_s = ClockTime_s(before.substr(0, before.find(' ')));
    Add(line, *z_mm, time_s.value_or(kUnknown));
  }

  void ReadMarlin(const TextLine& line) {
    const auto z_mm = NumberAfter(line.text, "z:");
    if (!z_mm) return Refuse(line);
    if (num_batches_ == 0) Begin();
    if (!Known(x_mm_) || !Known(y_mm_)) {
      faults_.Add(PlaceOf(line.words.front(), name_),
                  "nothing before this touch of M48 says where it lies",
                  "'M48 P10 X100 Y80': its X and Y");
      return;
    }
    Add(line, *z_mm, kUnknown);
  }

  void Refuse(const TextLine& line) {
    faults_.Add(PlaceOf(line.words.front(), name_),
                "this line begins like a touch, but its numbers are not all there",
                "'probe at X,Y is z=Z' or 'N of M: z: Z'");
  }

  void Add(const TextLine& line, double z_mm, double time_s) {
    Row row = BedTouchRow(fmt::format("probe_accuracy_{}", num_batches_),
                          x_mm_,
                          y_mm_,
                          z_mm,
                          PlaceOf(line.words.front(), name_));
    row.rep = ++rep_;
    row.t_s = time_s;
    row.feed_mm_s = feed_mm_s_;
    if (heights_mm_.empty()) first_ = row.place;
    heights_mm_.push_back(z_mm);
    imported_.table.rows.push_back(std::move(row));
  }

  void Begin() {
    CheckClimb();
    ++num_batches_;
    rep_ = 0;
    x_mm_ = y_mm_ = feed_mm_s_ = kUnknown;
  }

  void Finish() { CheckClimb(); }

  void CheckClimb() {
    const std::string climb = ClimbText(heights_mm_);
    if (!climb.empty()) faults_.Add(first_, climb, std::string(kClimbHint));
    heights_mm_.clear();
  }

  std::string name_;
  std::vector<TextLine> lines_;
  Faults faults_;
  Imported imported_;
  int num_batches_ = 0;
  std::int64_t rep_ = 0;
  double x_mm_ = kUnknown, y_mm_ = kUnknown, feed_mm_s_ = kUnknown;
  std::vector<double> heights_mm_;
  Place first_;
};

}  // namespace

Imported ReadProbeAccuracy(const std::string& text,
                           const std::string& name,
                           const ImportOptions& options) {
  return LogReader(text, name).Read(options);
}

}  // namespace caltwin
