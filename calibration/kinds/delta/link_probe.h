#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/kinds/delta/bench.h"
#include "sim/link/link.h"
#include "sim/machine/kinds/delta/mesh.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// What touches a delta's bed by G-code: M665 and M666 where the settings are not those
/// last sent, G28, then `G30 X Y`, whose answer says the height to a micrometre.
class DeltaLinkProbe {
 public:
  /// @param drawn  against which angles are counted
  /// @param sent  what the firmware has now
  DeltaLinkProbe(Link* link, DeltaModel<double> drawn, DeltaModel<double> sent)
      : link_(link), drawn_(drawn), sent_(sent) {}

  /// For the engines; borrows this.
  DeltaProbe AsProbe();
  /// Sends M665 and M666, unless the firmware has these settings.
  void Set(const DeltaModel<double>& settings);
  /// Sends M421 for every node, and M420 S1.
  void Set(const DeltaMesh& mesh);
  /// Sends a line and takes what is answered. The first line refused is the fault;
  /// nothing is touched after it.
  std::vector<std::string> Say(const std::string& line);

  bool was_out_of_reach() const { return was_out_of_reach_; }
  /// "G28: Error:..." of the first line that was refused.
  const std::optional<std::string>& fault() const { return fault_; }
  /// The same with its kind.
  std::optional<MachineFault> fault_itself() const {
    return fault_ ? std::optional(MachineFault{fault_kind_, *fault_}) : std::nullopt;
  }

 private:
  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm);

  Link* link_;
  DeltaModel<double> drawn_;
  DeltaModel<double> sent_;
  bool is_homed_ = false;
  bool was_out_of_reach_ = false;
  std::optional<std::string> fault_{};
  MachineFault::Kind fault_kind_ = MachineFault::Kind::kRefused;
};

/// Points that cover a disc evenly, the outermost on its rim.
std::vector<Eigen::Vector2d> DiscPoints(int count, double radius_mm);

}  // namespace caltwin
