#pragma once

#include <string>
#include <vector>

#include "calibration/kinds/delta/g33_tune.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

struct G33Options;

/// What G33 prints, line by line in Marlin's form.
class G33Trace {
 public:
  explicit G33Trace(const G33Options& options) : options_(options) {}

  void Begin(double radius_mm, const DeltaModel<double>& settings);
  void Results(const G33Heights& heights_mm);
  void Iteration(int iterations,
                 double deviation_mm,
                 const DeltaModel<double>& settings);
  void End(bool rolls_back, double least_mm, const DeltaModel<double>& settings);
  void EndDryRun(double deviation_mm);
  void ProbeFailed();

  const std::vector<std::string>& lines() const { return lines_; }

 private:
  void Settings(const DeltaModel<double>& settings);

  const G33Options& options_;
  std::vector<std::string> lines_{};
};

}  // namespace caltwin
