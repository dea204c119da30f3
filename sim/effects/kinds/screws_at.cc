#include "sim/effects/kinds/screws_at.h"

#include <algorithm>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

// Where the screws stand by what the row tells of them.
ScrewsAt ScrewsAtOf(const Row& row, const TripleZDrawing& drawing, const At& at) {
  // Columns of their own, else those of the machine's only motors.
  const bool is_own = std::ranges::any_of(row.screw_mm, Known) || at.drives;
  const auto& told_mm = is_own ? row.screw_mm : row.motor_mm;
  const auto& told_dir = is_own ? row.screw_dir : row.motor_dir;
  constexpr double kNone_mm = 0;
  const Vec3<double> tip_mm = at.Tip_mm();
  ScrewsAt here{
      .drawn_mm = drawing.pivots_mm(),
      .weights = ScrewWeights<double>(drawing.pivots_mm(), tip_mm[0], tip_mm[1])};
  const double commanded_mm = Known(row.cmd_mm[2]) ? row.cmd_mm[2] : kNone_mm;
  here.stated_z_mm =
      commanded_mm - (row.kind == RowKind::kTouch ? at.probe_off_mm[2] : 0);
  for (int i = 0; i < kNumScrews; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool is_stated = Known(told_mm[k]);
    here.stated_mm[i] = is_stated ? told_mm[k] : drawing.top_mm - commanded_mm;
    here.motor_dir[i] = Known(told_dir[k]) ? told_dir[k] : -at.dir[2];
  }
  here.off_mm = drawing.top_mm - here.weights.dot(here.stated_mm) - commanded_mm;
  here.is_fixed =
      row.kind == RowKind::kPosition &&
      (row.feature.starts_with("post") || row.campaign.starts_with("fixed_post"));
  return here;
}

}  // namespace

void AddScrews(const Row& row, const Machine& machine, At* at) {
  const auto* const screws = machine.Own<TripleZDrawing>();
  if (screws == nullptr) return;
  at->screws = ScrewsAtOf(row, *screws, *at);
  at->on_table = true;  // Gauges too read how far the bed is.
}

}  // namespace caltwin
