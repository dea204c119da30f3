#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "scenarios/kinds/compare_delta.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {

/// How a program did on one of the machines.
struct OracleScore {
  int machine = 0;  ///< From 1.
  int touches = 0;
  double before_um = 0;  ///< Height of nozzle over bed at unseen points, rms, as drawn.
  double after_um = 0;  ///< With the geometry that the program returned; inf: nonsense.
  double scale_um_per_mm = 0;  ///< By which moves in the plane are too long.
  bool is_worse = false;       ///< Than as drawn, or nonsense.
};

/// Deltas to probe for a program that wants to calibrate them, and a score of what it
/// returns. The machines are RandomDelta's, in order; only touches leave this class.
///
/// One JSON object a line, the answer likewise:
///
///   {"ask": "machine"}             {"machine": 1, "of": 150, "geometry": {...}, ...}
///   {"ask": "probe", "x": , "y": } {"z": }
///   {"ask": "set", "geometry": {}} {"geometry": {...}}   touches are told in it from
///   now on
///   {"ask": "done", "geometry": {}} {"score": {...}}     `machine` is then the next
///
/// `geometry` has endstop_mm [a, b, c], radius_mm, angle_deg [a, b, c], arm_mm;
/// radius_mm and arm_mm may be lists of three. A line that cannot be understood is
/// answered by
/// {"error": "..."}.
class DeltaOracle {
 public:
  DeltaOracle(int machines, std::uint64_t seed);

  std::string Answer(std::string_view line);
  const std::vector<OracleScore>& scores() const { return scores_; }
  int machines() const { return machines_; }
  int errors() const { return errors_; }

 private:
  nlohmann::ordered_json Obey(const nlohmann::json& asked);
  nlohmann::ordered_json Probe(const nlohmann::json& asked);
  nlohmann::ordered_json Done(const nlohmann::json& asked);
  nlohmann::ordered_json Describe() const;
  void Begin();

  int machines_;
  std::uint64_t seed_;
  DeltaCase machine_{};
  std::optional<SimulatedDelta> touched_{};
  DeltaModel<double> settings_{};
  int touches_ = 0;
  int errors_ = 0;
  std::vector<OracleScore> scores_{};
};

/// The verdict over all machines that were scored.
std::string OracleText(const DeltaOracle& oracle, std::uint64_t seed);
nlohmann::ordered_json OracleJson(const DeltaOracle& oracle, std::uint64_t seed);

}  // namespace caltwin
