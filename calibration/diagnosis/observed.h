#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/effects/catalog.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// The part of the baseline that rows do not depend on linearly: where it is taken.
struct BaselinePoint {
  /// Lost motion of each axis beyond the model's.
  Vec3<double> gap_mm = Vec3<double>::Zero();
  /// Pre-travel along each axis; kUnknown: the model's own.
  Vec3<double> pretravel_mm = Vec3<double>::Constant(kUnknown);
  /// How far the build is turned against its drawing (DiagnosedKind::TurnSds), in the
  /// units of that; empty: not at all.
  std::vector<double> turns{};
};

/// Measured rows made ready for diagnosis: the circumstances of each, what the model at
/// hand predicts, and what is left. Rows keep the order of the file.
///
/// Copies share the rows. Everything is in mm unless a name says otherwise.
class Observed {
 public:
  /// @param effects  what the model already holds beside the drawing (an extension's)
  /// Throws InputError where a row has no direction.
  Observed(RowTable table,
           DataHeader header,
           Machine machine,
           std::vector<Injected> effects);

  /// The same rows under a model that also holds `more`.
  Observed With(const std::vector<Injected>& more) const;

  /// The same rows with their baseline about `point`, touches taken where a fitted
  /// model says that they trigger, `left_mm` being reading less fit. Taken where they
  /// were read, their own noise would move them, and every shape along n would be seen
  /// to explain it. What was read while an axis still crossed its gap has the sense
  /// that is left of it there (-1 .. 1).
  Observed AtFitted(const Eigen::VectorXd& left_mm, const BaselinePoint& point) const;
  /// Touches taken at their nominal points: what the first fit starts from.
  Observed AtNominal() const;

  Eigen::Index num_rows() const { return residual_mm_.size(); }
  const Row& row(Eigen::Index i) const {
    return table_->rows[static_cast<std::size_t>(i)];
  }
  const At& at(Eigen::Index i) const { return at_[static_cast<std::size_t>(i)]; }
  const RowTable& table() const { return *table_; }
  const DataHeader& header() const { return *header_; }
  const Machine& machine() const { return machine_; }
  const std::vector<Injected>& effects() const { return effects_; }
  bool has_times() const { return surroundings_->has_times(); }
  const Climate& climate() const { return surroundings_->climate(); }

  /// Reading less prediction.
  const Eigen::VectorXd& residual_mm() const { return residual_mm_; }
  /// Campaign of each row, as an index into campaigns().
  const std::vector<int>& campaign_of() const { return campaign_of_; }
  const std::vector<std::string>& campaigns() const { return campaigns_; }

  /// +1 for gauges, -1 for touches: how a motion along n shows in the value. 0 for a
  /// gap under a nozzle: its calibration has taken out how far the head is off.
  double MotionSign(Eigen::Index i) const {
    if (at(i).station == ZReading::kGapUnderNozzle) return 0;
    return at(i).kind == RowKind::kTouch ? -1 : 1;
  }

  /// What one more effect, small, would add to every row [mm].
  Eigen::VectorXd Change_mm(const Injected& effect) const;

  /// The stated standard uncertainty of a row: its own, else its instrument's; NaN
  /// where nobody said.
  double StatedSigma_mm(Eigen::Index i) const;

  /// How far the build is turned where the baseline is taken (DiagnosedKind::TurnSds).
  const std::vector<double>& turns() const { return turns_; }

  /// Pre-travel along each axis that the baseline is linear about.
  const Vec3<double>& pretravel_mm() const { return pretravel_mm_; }

  /// What the rows reach of positions and times, for the forms of one axis.
  Extent ExtentOf() const;

 private:
  void Linearise();
  std::vector<double> drawn_turns() const;

  std::shared_ptr<const RowTable> table_;
  std::shared_ptr<const DataHeader> header_;
  std::shared_ptr<const Surroundings> surroundings_;
  Machine machine_;
  std::vector<Injected> effects_;
  std::vector<Injected> model_{};  ///< effects_, and the baseline's point.
  Vec3<double> pretravel_mm_ = Vec3<double>::Zero();
  std::vector<double> turns_{};
  std::shared_ptr<const void> placed_{};  ///< What `at_` points into.
  std::vector<At> at_{};
  std::vector<Vec3<double>> dir_{};        ///< As the rows say.
  std::vector<Vec3<double>> true_q_mm_{};  ///< Where the axes stand, drive errors in.
  Eigen::VectorXd residual_mm_{};
  std::vector<int> campaign_of_{};
  std::vector<std::string> campaigns_{};
};

}  // namespace caltwin
