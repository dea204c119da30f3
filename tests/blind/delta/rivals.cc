#include "tests/blind/delta/rivals.h"

#include <cmath>
#include <functional>

namespace blind {
namespace {

Column ColumnOf(const std::vector<DeltaStop>& stops,
                double sigma_mm,
                const std::function<double(const DeltaStop&)>& reads_um) {
  Column column;
  for (const DeltaStop& stop : stops) {
    column.push_back(1e-3 * reads_um(stop) * stop.n.z() / sigma_mm);
  }
  return column;
}

DeltaRival GrowthWithTime(const std::vector<DeltaStop>& stops, double sigma_mm) {
  constexpr int kForms = 12;
  constexpr double kShortest_s = 60, kRatio = 1.6;  // To three hours.
  DeltaRival rival{.name = "growth with time"};
  for (int i = 0; i < kForms; ++i) {
    const double tau_s = kShortest_s * std::pow(kRatio, i);
    rival.forms.push_back(ColumnOf(stops, sigma_mm, [&](const DeltaStop& stop) {
      return (stop.is_touch ? -1 : 1) * (1 - std::exp(-stop.t_s / tau_s));
    }));
  }
  return rival;
}

DeltaRival WarmProbe(const std::vector<DeltaStop>& stops, double sigma_mm) {
  DeltaRival rival{.name = "warm probe"};
  for (const auto sensor :
       {&DeltaStop::frame_k, &DeltaStop::bed_k, &DeltaStop::screw_k}) {
    rival.forms.push_back(ColumnOf(stops, sigma_mm, [&](const DeltaStop& stop) {
      return stop.is_touch ? -(stop.*sensor) : 0.0;
    }));
  }
  return rival;
}

}  // namespace

std::vector<DeltaRival> DeltaRivals(const std::vector<DeltaStop>& stops,
                                    double sigma_mm) {
  return {GrowthWithTime(stops, sigma_mm), WarmProbe(stops, sigma_mm)};
}

}  // namespace blind
