#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/effects/catalog.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

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

  /// The same rows, touches taken where a fitted model says that they trigger,
  /// `left_mm` being reading less fit. Taken where they were read, their own noise
  /// would move them, and every shape along n would be seen to explain it.
  Observed AtFitted(const Eigen::VectorXd& left_mm) const;
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

  /// +1 for gauges, -1 for touches: how a motion along n shows in the value.
  double MotionSign(Eigen::Index i) const {
    return at(i).kind == RowKind::kTouch ? -1 : 1;
  }

  /// What one more effect, small, would add to every row [mm].
  Eigen::VectorXd Change_mm(const Injected& effect) const;

  /// The stated standard uncertainty of a row: its own, else its instrument's; NaN
  /// where nobody said.
  double StatedSigma_mm(Eigen::Index i) const;

  /// What the rows reach of positions and times, for the forms of one axis.
  Extent ExtentOf() const;

 private:
  void Linearise();

  std::shared_ptr<const RowTable> table_;
  std::shared_ptr<const DataHeader> header_;
  std::shared_ptr<const Surroundings> surroundings_;
  Machine machine_;
  std::vector<Injected> effects_;
  std::vector<At> at_{};
  std::vector<Vec3<double>> true_q_mm_{};  ///< Where the axes stand, drive errors in.
  Eigen::VectorXd residual_mm_{};
  std::vector<int> campaign_of_{};
  std::vector<std::string> campaigns_{};
};

}  // namespace caltwin
