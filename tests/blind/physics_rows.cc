#include "tests/blind/physics_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "tests/blind/table.h"

namespace blind {
namespace {

constexpr double kLongAgo_mm = 1000;

/// One row of a table of text, by the names of its columns.
class TextRow {
 public:
  TextRow(const TextTable& table, std::size_t row) : table_(table), row_(row) {}

  std::string Text(const std::string& name) const {
    const int column = table_.Column(name);
    return column < 0 ? "" : table_.rows[row_][static_cast<std::size_t>(column)];
  }
  double Number(const std::string& name, double otherwise = 0) const {
    const std::string text = Text(name);
    return text.empty() ? otherwise : std::stod(text);
  }
  /// Of columns PREFIX_x_SUFFIX.
  Vector3 Three(const std::string& prefix,
                const std::string& suffix,
                double otherwise = 0) const {
    return {Number(prefix + "x" + suffix, otherwise),
            Number(prefix + "y" + suffix, otherwise),
            Number(prefix + "z" + suffix, otherwise)};
  }

 private:
  const TextTable& table_;
  std::size_t row_;
};

Kind KindOf(const std::string& word) {
  return word == "touch"    ? Kind::kTouch
         : word == "radial" ? Kind::kRadial
                            : Kind::kPosition;
}

Stop StopOf(const TextRow& row) {
  Stop stop;
  stop.campaign = row.Text("campaign");
  stop.kind = KindOf(row.Text("kind"));
  stop.setup = row.Text("setup");
  stop.feature = row.Text("feature");
  stop.rep = static_cast<int>(row.Number("rep", 1));
  stop.at_mm = row.Three("cmd_", "_mm");
  stop.n = row.Three("n", "");
  stop.feed_mm_s = row.Number("feed_mm_s", 2);
  stop.load_n = row.Number("load_n", -1);
  stop.turn_deg = row.Number("artefact_turn_deg");
  stop.spindle_deg = row.Number("probe_angle_deg");
  stop.offset_mm = row.Three("probe_off_", "_mm");
  return stop;
}

Reading ReadingOf(const TextRow& row, const Stop& stop) {
  constexpr double kRadPerDeg = std::numbers::pi / 180;
  Reading reading{.stop = &stop};
  Instant& at = reading.instant;
  at.kind = stop.kind;
  at.t_s = row.Number("t_s");
  at.home = static_cast<int>(row.Number("home", 1)) - 1;
  at.q_mm = stop.at_mm;
  reading.dir = row.Three("dir_", "");
  at.dir = reading.dir;
  at.since_rev_mm = row.Three("since_rev_", "_mm", kLongAgo_mm);
  at.feed_mm_s = stop.feed_mm_s;
  at.n = stop.n;
  at.spindle_rad = stop.spindle_deg * kRadPerDeg;
  at.offset_mm = stop.offset_mm;
  at.artefact = stop.feature.substr(0, stop.feature.find('.'));
  at.turn_rad = stop.turn_deg * kRadPerDeg;
  at.point_mm = stop.at_mm;
  at.on_circle = stop.kind == Kind::kRadial;
  return reading;
}

/// Where each setup stands: in the middle of what is touched there.
void PlaceSetups(Plan* plan) {
  constexpr double kFar = std::numeric_limits<double>::max();
  std::map<std::string, std::pair<Vector3, Vector3>> spans;
  for (const Stop& stop : plan->stops) {
    auto& [low, high] =
        spans
            .try_emplace(
                stop.setup, Vector3{kFar, kFar, kFar}, Vector3{-kFar, -kFar, -kFar})
            .first->second;
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], stop.at_mm[i]);
      high[i] = std::max(high[i], stop.at_mm[i]);
    }
    const bool is_touched = stop.kind == Kind::kTouch;
    Placement& placement = plan->placements[stop.setup];
    placement.artefact = stop.feature.substr(0, stop.feature.find('.'));
    placement.on_table = is_touched;
    const bool is_round = placement.artefact == "ring" || stop.kind == Kind::kRadial;
    placement.offset_sd_mm = is_round ? 0.02 : is_touched ? 0.1 : 0.05;
    placement.turn_sd_rad = is_touched ? 1e-3 : 0;
  }
  for (auto& [setup, placement] : plan->placements) {
    const auto& [low, high] = spans.at(setup);
    placement.center_mm = 0.5 * (low + high);
    placement.center_mm[2] = 0;
  }
}

/// The section `artefacts` of a header as `caltwin simulate` writes it.
std::map<std::string, Certificate> CertificatesOf(const std::string& header) {
  std::map<std::string, Certificate> certificates;
  std::istringstream lines(header);
  bool is_there = false;
  std::string id;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t indent = line.find_first_not_of(' ');
    const std::size_t colon = line.find(':');
    if (indent == std::string::npos || colon == std::string::npos) continue;
    const std::string key = line.substr(indent, colon - indent);
    const std::string said = line.substr(std::min(line.size(), colon + 2));
    if (indent == 0) is_there = key == "artefacts";
    if (!is_there || indent == 0) continue;
    if (indent == 2) id = key;
    Certificate& certificate = certificates[id];
    if (key == "type") certificate.type = said;
    if (key == "u_um") certificate.u_um = std::stod(said);
    if (key != "sizes_mm") continue;
    std::istringstream numbers(said);
    for (char mark = 0; numbers >> mark && mark != ']';) {
      double size_mm = 0;
      if (numbers >> size_mm) certificate.sizes_mm.push_back(size_mm);
    }
  }
  return certificates;
}

}  // namespace

void SetValue(double value_mm, const Drawing& drawing, Reading* reading) {
  reading->value_mm = value_mm;
  const Stop& stop = *reading->stop;
  if (stop.kind != Kind::kTouch) return;
  Instant& at = reading->instant;
  const double before_mm = reading->trigger_mm;
  reading->trigger_mm = value_mm;
  at.q_mm =
      stop.at_mm + (drawing.tip_radius_cfg_mm + value_mm) * stop.n - stop.offset_mm;
  // The rows tell the commanded travel; what ends further out has travelled less.
  for (std::size_t i = 0; i < 3; ++i) {
    at.since_rev_mm[i] -= (value_mm - before_mm) * std::abs(stop.n[i]);
  }
}

void ReadRun(const RunFiles& files, Case* made) {
  const TextTable table = ParseTable(files.rows);
  if (table.rows.empty()) throw std::runtime_error("a run without rows");
  made->times_s.clear();
  made->temps_c.clear();
  made->readings.clear();
  made->plan.stops.clear();
  made->plan.placements.clear();
  made->plan.artefacts = CertificatesOf(files.header);
  Random random(made->request.seed, "thermometers");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    made->plan.stops.push_back(StopOf({table, i}));
  }
  PlaceSetups(&made->plan);
  const char* const thermometers[] = {"screw", "frame", "bed", "chamber", "ambient"};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const TextRow row(table, i);
    Reading reading = ReadingOf(row, made->plan.stops[i]);
    const std::size_t main = std::abs(reading.instant.n[0]) > 0.7   ? 0
                             : std::abs(reading.instant.n[1]) > 0.7 ? 1
                                                                    : 2;
    const double load_n = reading.stop->load_n;
    reading.instant.load_n = load_n < 0 ? made->drawing.axes[main].friction_n : load_n;
    SetValue(row.Number("value_mm"), made->drawing, &reading);
    made->times_s.push_back(reading.instant.t_s);
    made->readings.push_back(reading);
    auto& temps_c = made->temps_c.emplace_back();
    for (std::size_t k = 0; k < temps_c.size(); ++k) {
      const std::string name = std::string("temp_") + thermometers[k] + "_c";
      temps_c[k] = row.Number(name, 20) + 0.03 * random.Normal();
    }
  }
}

std::vector<double> ValuesOf(const RunFiles& files) {
  const TextTable table = ParseTable(files.rows);
  std::vector<double> values_mm;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    values_mm.push_back(TextRow(table, i).Number("value_mm"));
  }
  return values_mm;
}

}  // namespace blind
