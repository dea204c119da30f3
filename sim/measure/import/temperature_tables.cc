#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// Every run over the same temperatures.
struct Tables {
  double reference_c = kUnknown;
  std::vector<double> temp_c{};
  std::vector<std::vector<double>> run_um{};
};

/// Which fields hold what.
struct Heading {
  std::size_t num = 0, temp = 0, um = 0;
};

std::vector<std::string> FieldsOf(std::string_view line) {
  constexpr std::string_view kBetween = ",; \t";
  // "[DELTA:6]": a remark behind the fields.
  line = line.substr(0, line.find('['));
  std::vector<std::string> fields;
  for (std::size_t at = line.find_first_not_of(kBetween); at != line.npos;) {
    const std::size_t end = std::min(line.size(), line.find_first_of(kBetween, at));
    fields.emplace_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBetween, end);
  }
  return fields;
}

std::optional<Heading> HeadingOf(const std::vector<std::string>& fields) {
  Heading heading{.num = fields.size(), .temp = fields.size(), .um = fields.size()};
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (fields[k].starts_with("temp")) heading.temp = k;
    if (fields[k] == "um" || fields[k] == "offset(um)") heading.um = k;
  }
  const bool is_whole = heading.temp < heading.num && heading.um < heading.num;
  return is_whole ? std::optional(heading) : std::nullopt;
}

// Runs end where the temperature falls back.
Tables TablesOf(const std::string& text) {
  Tables tables;
  std::optional<Heading> heading;
  std::vector<std::vector<double>> temps_c;
  for (const TextLine& line : LinesOf(text)) {
    const auto fields = FieldsOf(Lowered(line.text));
    if (const auto found = HeadingOf(fields)) {
      heading = found;
      continue;
    }
    if (!heading || fields.size() != heading->num) continue;
    const auto temp_c = NumberOf(fields[heading->temp]);
    const auto um = NumberOf(fields[heading->um]);
    if (!temp_c || !um) continue;
    if (fields[0].starts_with("n/a")) {
      tables.reference_c = *temp_c;
      continue;
    }
    if (temps_c.empty() || *temp_c <= temps_c.back().back()) {
      temps_c.emplace_back();
      tables.run_um.emplace_back();
    }
    temps_c.back().push_back(*temp_c);
    tables.run_um.back().push_back(*um);
  }
  if (temps_c.empty()) return {};
  tables.temp_c = temps_c.front();
  const bool are_alike = std::ranges::all_of(
      temps_c, [&](const auto& one) { return one == temps_c.front(); });
  return are_alike ? tables : Tables{};
}

double SpreadOf(const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

std::vector<double> AtTemperature(const Tables& tables, std::size_t k) {
  std::vector<double> values_um;
  for (const auto& run : tables.run_um) values_um.push_back(run[k]);
  return values_um;
}

// How much of the variance between runs is one constant for each whole run.
double ShareOfConstant(const Tables& tables) {
  const auto num_temps = static_cast<double>(tables.temp_c.size());
  const auto num_runs = static_cast<double>(tables.run_um.size());
  std::vector<double> means_um(tables.temp_c.size()), shifts_um(tables.run_um.size());
  for (std::size_t k = 0; k < means_um.size(); ++k)
    for (const double um : AtTemperature(tables, k)) means_um[k] += um / num_runs;
  double all = 0, left = 0;
  for (std::size_t r = 0; r < shifts_um.size(); ++r) {
    for (std::size_t k = 0; k < means_um.size(); ++k)
      shifts_um[r] += (tables.run_um[r][k] - means_um[k]) / num_temps;
    for (std::size_t k = 0; k < means_um.size(); ++k) {
      const double off_um = tables.run_um[r][k] - means_um[k];
      all += off_um * off_um;
      left += std::pow(off_um - shifts_um[r], 2);
    }
  }
  return all > 0 ? 1 - left / all : 0;
}

std::string SentenceOf(const Tables& tables) {
  constexpr double kMostly = 0.7;
  const std::size_t last = tables.temp_c.size() - 1;
  const double share = ShareOfConstant(tables);
  std::vector<double> rises_um;
  for (const auto& run : tables.run_um) rises_um.push_back(run[last] - run[0]);
  const std::string runs = fmt::format(
      "The runs do not agree on how far the probe drifts: at {:g} C they say {:+g} um, "
      "at {:g} C {:+g} um. ",
      tables.temp_c[last],
      fmt::join(AtTemperature(tables, last), ", "),
      tables.temp_c[0],
      fmt::join(AtTemperature(tables, 0), ", "));
  const std::string from =
      Known(tables.reference_c)
          ? fmt::format(" between the reference at {:g} C and {:g} C",
                        tables.reference_c,
                        tables.temp_c[0])
          : std::string(" before the first temperature");
  const std::string what =
      share > kMostly
          ? fmt::format(
                "{:.0f} % of the difference is one constant for a whole run, that "
                "comes "
                "in{}: the reference does not repeat. The rise from {:g} to {:g} C is "
                "{:g} um. ",
                100 * share,
                from,
                tables.temp_c[0],
                tables.temp_c[last],
                fmt::join(rises_um, ", "))
          : fmt::format(
                "No constant explains it ({:.0f} %): the shape itself does not "
                "repeat. ",
                100 * share);
  return runs + what +
         "Not soaked through, a bed that still moves and a first touch that reads "
         "otherwise all do that. Take no one table, and no mean of them, for the "
         "probe's drift";
}

}  // namespace

std::optional<Imported> TemperatureTablesIn(const std::string& text) {
  constexpr std::size_t kFewest = 3;
  constexpr double kApart_um = 20;
  const Tables tables = TablesOf(text);
  if (tables.run_um.size() < 2 || tables.temp_c.size() < kFewest) return std::nullopt;
  double most_um = 0;
  for (std::size_t k = 0; k < tables.temp_c.size(); ++k)
    most_um = std::max(most_um, SpreadOf(AtTemperature(tables, k)));
  if (most_um < kApart_um) return std::nullopt;
  Imported imported =
      ToldOf(fmt::format("{} runs of a correction over temperature, {:g} to "
                         "{:g} C",
                         tables.run_um.size(),
                         tables.temp_c.front(),
                         tables.temp_c.back()),
             "how far the probe drifts with temperature, and why its reference "
             "does not repeat",
             "probe",
             "hold the reference's temperature for ten minutes and touch the "
             "same place ten times, with homing between: that tells whether "
             "the reference repeats");
  imported.notes.push_back({.kind = FileNote::Kind::kFact,
                            .sentence = SentenceOf(tables),
                            .fact = "contradiction",
                            .axis = "z",
                            .word = "runs",
                            .figures = {{"spread_um", most_um}}});
  return imported;
}

}  // namespace caltwin
