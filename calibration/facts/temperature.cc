#include "calibration/facts/temperature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

struct Thermometer {
  const char* id = nullptr;
  const char* words = nullptr;
  double Row::*member = nullptr;
};
constexpr std::array kSensors = {
    Thermometer{"frame", "the frame", &Row::temp_frame_c},
    Thermometer{"bed", "the bed", &Row::temp_bed_c},
    Thermometer{"chamber", "the chamber", &Row::temp_chamber_c},
    Thermometer{"nozzle", "the nozzle", &Row::temp_nozzle_c},
    Thermometer{"probe", "the probe or screw", &Row::temp_screw_c},
    Thermometer{"ambient", "the room", &Row::temp_ambient_c}};

/// Readings as a straight line of one or more temperatures.
struct Warmth {
  std::vector<const Thermometer*> sensors{};
  Eigen::VectorXd um_per_k{};    ///< In the order of the sensors.
  Eigen::MatrixXd covariance{};  ///< (um/K)^2.
  double left_mm = HUGE_VAL;     ///< Standard deviation about the line.

  double Sd_um_per_k(Eigen::Index i) const { return std::sqrt(covariance(i, i)); }
  /// Of the first two figures.
  double Correlation() const {
    return covariance(0, 1) / Sd_um_per_k(0) / Sd_um_per_k(1);
  }
};

double SpreadOf_mm(const Rows& rows) {
  double sum_mm = 0, sum_mm2 = 0;
  for (const Row* row : rows) sum_mm += row->value_mm;
  const double mean_mm = sum_mm / static_cast<double>(rows.size());
  for (const Row* row : rows) {
    sum_mm2 += (row->value_mm - mean_mm) * (row->value_mm - mean_mm);
  }
  return std::sqrt(sum_mm2 / static_cast<double>(rows.size() - 1));
}

double RangeOf_k(const Rows& rows, const Thermometer& sensor) {
  double least_c = HUGE_VAL, most_c = -HUGE_VAL;
  for (const Row* row : rows) {
    const double at_c = row->*sensor.member;
    if (!Known(at_c)) return 0;
    least_c = std::min(least_c, at_c);
    most_c = std::max(most_c, at_c);
  }
  return most_c - least_c;
}

bool GoesBothWays(const Rows& rows, const Thermometer& sensor) {
  bool rises = false, falls = false;
  double before_c = kUnknown;
  for (const Row* row : rows) {
    const double at_c = row->*sensor.member;
    rises |= at_c > before_c + 0.5;
    falls |= at_c < before_c - 0.5;
    before_c = at_c;
  }
  return rises && falls;
}

// What is left after a lag or a slower warming goes on from one reading to the next, so
// fewer of them count: sqrt((1 + r) / (1 - r)), r the correlation of neighbours.
double InflationOf(const Eigen::VectorXd& left) {
  constexpr double kMost = 0.98;
  const Eigen::Index pairs = left.size() - 1;
  const double r = std::clamp(
      left.head(pairs).dot(left.tail(pairs)) / left.squaredNorm(), 0.0, kMost);
  return std::sqrt((1 + r) / (1 - r));
}

// Of centred columns; none where the temperatures go exactly together.
std::optional<Warmth> Fit(const Rows& rows,
                          const std::vector<const Thermometer*>& sensors) {
  const auto num_rows = static_cast<Eigen::Index>(rows.size());
  const auto num_sensors = static_cast<Eigen::Index>(sensors.size());
  const double freedom = static_cast<double>(num_rows - num_sensors - 1);
  if (freedom < 1) return std::nullopt;
  Eigen::MatrixXd columns(num_rows, num_sensors);
  Eigen::VectorXd values(num_rows);
  for (Eigen::Index i = 0; i < num_rows; ++i) {
    const Row& row = *rows[static_cast<std::size_t>(i)];
    values[i] = row.value_mm;
    for (Eigen::Index k = 0; k < num_sensors; ++k) {
      columns(i, k) = row.*sensors[static_cast<std::size_t>(k)]->member;
    }
  }
  values.array() -= values.mean();
  columns.rowwise() -= columns.colwise().mean().eval();
  const Cholesky normal(columns.transpose() * columns);
  if (!normal.is_definite()) return std::nullopt;
  const Eigen::VectorXd slopes = normal.Solve(columns.transpose() * values);
  Warmth warmth{.sensors = sensors, .um_per_k = UmFromMm(slopes.eval())};
  const Eigen::VectorXd left = values - columns * slopes;
  warmth.left_mm = left.norm() / std::sqrt(freedom);
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(num_sensors, num_sensors);
  const double left_um = UmFromMm(warmth.left_mm) * InflationOf(left);
  warmth.covariance = left_um * left_um * normal.SolveEach(unit);
  return warmth;
}

// The thermometer that leaves least, and a second one where the rows need it: it leaves
// a fifth less and is five of its own deviations from nothing.
std::optional<Warmth> BestOf(const Rows& rows) {
  constexpr double kLeastRange_k = 3, kMostLeftBySecond = 0.8, kLeastSigmas = 5;
  std::vector<const Thermometer*> useful;
  for (const Thermometer& sensor : kSensors) {
    if (RangeOf_k(rows, sensor) >= kLeastRange_k) useful.push_back(&sensor);
  }
  std::optional<Warmth> one, two;
  for (const Thermometer* sensor : useful) {
    const auto fit = Fit(rows, {sensor});
    if (fit && (!one || fit->left_mm < one->left_mm)) one = fit;
  }
  if (!one) return one;
  for (const Thermometer* sensor : useful) {
    if (sensor == one->sensors[0]) continue;
    const auto fit = Fit(rows, {one->sensors[0], sensor});
    if (fit && (!two || fit->left_mm < two->left_mm)) two = fit;
  }
  const bool is_needed =
      two && two->left_mm < kMostLeftBySecond * one->left_mm &&
      std::abs(two->um_per_k[1]) > kLeastSigmas * two->Sd_um_per_k(1);
  return is_needed ? two : one;
}

std::string OfSensor(const Warmth& warmth, Eigen::Index i) {
  return WithSd(warmth.um_per_k[i], warmth.Sd_um_per_k(i), "um/K");
}

std::string InWords(const Warmth& warmth, const Rows& rows) {
  const Thermometer& first = *warmth.sensors[0];
  if (warmth.sensors.size() == 1) {
    return fmt::format(
        "The reading follows the temperature of {} by {} over {:.3g} K, and leaves {} "
        "um about that line{}. Read at one temperature, or correct by this figure",
        first.words,
        OfSensor(warmth, 0),
        RangeOf_k(rows, first),
        TwoDigits(UmFromMm(warmth.left_mm)),
        GoesBothWays(rows, first)
            ? ", warming and cooling alike: no wear, no loose mount, no drift with time"
            : "; it was only ever warmed (or cooled), so time would explain it as "
              "well");
  }
  const Thermometer& second = *warmth.sensors[1];
  return fmt::format(
      "The reading follows two temperatures: that of {} by {} over {:.3g} K, and that "
      "of {} by {} over {:.3g} K; {} um are left about both. They warmed together, so "
      "what one figure has too much the other has too little (correlation {:.2f}). "
      "Read when both stand still, or correct by both",
      first.words,
      OfSensor(warmth, 0),
      RangeOf_k(rows, first),
      second.words,
      OfSensor(warmth, 1),
      RangeOf_k(rows, second),
      TwoDigits(UmFromMm(warmth.left_mm)),
      warmth.Correlation());
}

}  // namespace

void FactsOfTemperature(const Rows& all, const Repeats& repeats, Facts* facts) {
  constexpr std::size_t kFewest = 6;
  constexpr double kMostLeft = 0.25;
  Rows rows;
  for (const Row* row : all) {
    if (!repeats.outliers.contains(row->row)) rows.push_back(row);
  }
  const Cells cells = CellsOf(rows, kAnyHome | kAnyCampaign);
  if (cells.size() != 1 || rows.size() < kFewest) return;
  const std::optional<Warmth> warmth = BestOf(rows);
  if (!warmth || warmth->left_mm > kMostLeft * SpreadOf_mm(rows)) return;
  // It explains a drift or levels that were told of the same rows.
  std::erase_if(facts->all, [](const Fact& fact) {
    return fact.id == "drift" || fact.id == "jump" || fact.id == "homing_scatter";
  });
  const double slope_um_per_k = warmth->um_per_k[0], sd = warmth->Sd_um_per_k(0);
  Fact fact{.id = "temperature",
            .word = warmth->sensors[0]->id,
            .figures = {{"um_per_k", slope_um_per_k, sd},
                        {"left_um", UmFromMm(warmth->left_mm)}},
            .sigmas = std::abs(slope_um_per_k) / std::max(sd, 1e-15),
            .sentence = InWords(*warmth, rows),
            .is_answer = true};
  if (warmth->sensors.size() == 2) {
    fact.figures.push_back(
        {"second_um_per_k", warmth->um_per_k[1], warmth->Sd_um_per_k(1)});
    fact.figures.push_back({"correlation", warmth->Correlation()});
    fact.also = {warmth->sensors[1]->id};
  }
  facts->all.push_back(std::move(fact));
}

}  // namespace caltwin
