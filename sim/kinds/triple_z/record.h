#pragma once

#include <span>
#include <string>

#include "sim/firmware/bed_probing.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Rows of a triple-Z printer's touches, and what explains them (`--record`): each
/// touch of the bed as its firmware counted it, nominal height 0, with what every screw
/// was told. Rows of one step of a scenario are one campaign, of one G28 one `home`.
class TripleZRecord {
 public:
  /// @param sigma_mm  of the trigger, as stated
  TripleZRecord(const Machine& machine, double sigma_mm);

  void Add(const std::string& campaign, std::span<const ProbedPoint> touches);

  const DataHeader& header() const { return header_; }
  const RowTable& rows() const { return rows_; }

 private:
  std::string IdOf(const ProbedPoint& touch);

  const Machine& machine_;
  DataHeader header_{};
  RowTable rows_{};
};

}  // namespace caltwin
