#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibration/estimate/observability.h"
#include "calibration/loop/session.h"

namespace caltwin {

/// The Jacobian of a measuring plan, row by row: what each kind of reading says of the
/// unknowns, so that a procedure can tell before it runs what it will be able to tell.
///
/// Signs as in the measured rows. Of a touch along the normal n on axis a:
///   d value = q n_a / s d(s) + n_a d(placement) - d(pre-travel) - d(backlash) / 2
///             - v d(latency) + d(tip)
/// and of a release, moving out: + d(backlash) / 2 + d(hysteresis) + v d(latency).
class PlanModel {
 public:
  explicit PlanModel(Session* session) : session_(session) {}

  /// `count` touches of one face whose place belongs to `setup`.
  void AddTouch(const Face& face, int count, const std::string& setup);
  void AddRelease(const Face& face, int count, const std::string& setup, double v_mm_s);
  /// As AddTouch, at a feed that matters.
  void AddTouchAt(const Face& face, int count, const std::string& setup, double v_mm_s);
  /// A dial or laser reads the place of `axis`, come to in `sense`, up to its zero.
  void AddReading(Axis axis, double q_mm, int sense, double sd_mm);
  /// Something known from elsewhere.
  void AddKnown(const std::string& name, double sd);

  ObservabilityReport Report() const;

 private:
  using Terms = std::map<std::string, double>;
  void AddRow(const Terms& terms, double sd);
  Terms TouchTerms(const Face& face, const std::string& setup) const;
  double Sd_mm(const Face& face, int count) const;

  Session* session_;
  std::vector<Terms> rows_{};  ///< Already divided by their standard deviation.
};

/// "It tells a and b; of c and d only c + d / 2; ..." for a person before a run.
std::string InWords(const ObservabilityReport& report);

}  // namespace caltwin
