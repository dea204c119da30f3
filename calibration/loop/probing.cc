#include "calibration/loop/probing.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

constexpr double kStandOff_mm = 5;    // Between tip and face, at best.
constexpr double kScaleDoubt = 0.08;  // Of the way from home: steps/mm unknown.
constexpr double kOverFaces_mm = 8;   // Between tip and the highest artefact.
constexpr double kBackOff_mm = 2;     // After a touch, beside the lead-in.
constexpr double kLeadInPerGap = 12;  // RepRapFirmware spreads over 10 gaps.
constexpr double kShortestLeadIn_mm = 1;
constexpr double kBelowTop_mm = 1;  // Kept clear of the axis's end.

}  // namespace

Probing::Probing(Bench* bench, Controller* controller)
    : bench_(bench), controller_(controller) {}

Expected<void> Probing::Prepare() {
  if (const auto read = controller_->ReadSettings(); !read) return read;
  const auto last = bench_->ledger.settings.find(bench_->ledger.settings_now);
  if (last != bench_->ledger.settings.end()) {
    controller_->Remember(last->second);
  }
  const auto homed = controller_->IsHomed();
  if (!homed) return tl::unexpected(homed.error());
  if (!*homed || bench_->ledger.homings == 0) return Home();
  const auto position_mm = controller_->ReadPosition_mm();
  if (!position_mm) return tl::unexpected(position_mm.error());
  return Raise();
}

Expected<void> Probing::Home() {
  if (const auto homed = controller_->Home(); !homed) return homed;
  ++bench_->ledger.homings;
  return {};
}

double Probing::SafeHeight_mm() const {
  double top_mm = 0;
  for (const Artefact& artefact : bench_->artefacts) {
    top_mm = std::max(top_mm, Top_mm(artefact));
  }
  const AxisDrawing& z = bench_->machine.axis(Axis::kZ);
  const double wanted_mm = top_mm + controller_->settings().tip_radius_mm +
                           kOverFaces_mm + kScaleDoubt * (z.max_mm - top_mm);
  return std::min(wanted_mm, z.max_mm - kBelowTop_mm);
}

double Probing::LeadIn_mm(const Vec3<double>& n) const {
  double longest_mm = kShortestLeadIn_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    if (n[static_cast<int>(i)] == 0) continue;
    const double gap_mm = controller_->settings().backlash_mm[i];
    longest_mm = std::max(longest_mm, kLeadInPerGap * gap_mm + kShortestLeadIn_mm);
  }
  return longest_mm;
}

double Probing::StandOff_mm(const Face& face) const {
  double doubt_mm = 0;
  for (const Axis axis : kAxes) {
    const double from_home_mm =
        std::abs(face.at_mm[Index(axis)] - bench_->machine.axis(axis).home_mm());
    doubt_mm += std::abs(face.n[Index(axis)]) * kScaleDoubt * from_home_mm;
  }
  const double wanted_mm = kStandOff_mm + doubt_mm;
  if (!face.internal) return wanted_mm;
  return std::min(wanted_mm, face.room_mm - controller_->settings().tip_radius_mm);
}

Vec3<double> Probing::Within(Vec3<double> target_mm) const {
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = bench_->machine.axis(axis);
    target_mm[Index(axis)] =
        std::clamp(target_mm[Index(axis)], drawing.min_mm, drawing.max_mm);
  }
  return target_mm;
}

Vec3<double> Probing::Start_mm(const Face& face, double off_mm) const {
  const double radius_mm = controller_->settings().tip_radius_mm;
  return Within(face.at_mm + face.n * (radius_mm + off_mm));
}

Expected<void> Probing::Raise() {
  Vec3<double> up_mm = controller_->position_mm();
  up_mm[2] = std::max(up_mm[2], SafeHeight_mm());
  return controller_->MoveTo(Within(up_mm));
}

Expected<void> Probing::RaiseToTop() {
  Vec3<double> up_mm = controller_->position_mm();
  const double top_mm = bench_->machine.axis(Axis::kZ).max_mm - kBelowTop_mm;
  up_mm[2] = std::max(up_mm[2], top_mm);
  return controller_->MoveTo(Within(up_mm));
}

Expected<void> Probing::GoBefore(const Face& face, double off_mm) {
  if (const auto raised = Raise(); !raised) return raised;
  const Vec3<double> start_mm = Start_mm(face, off_mm);
  Vec3<double> over_mm = start_mm;
  if (face.from_below) {
    over_mm[1] += 2 * bench_->machine.probe.disc_radius_mm;
  }
  over_mm[2] = controller_->position_mm()[2];
  if (const auto moved = controller_->MoveTo(over_mm); !moved) return moved;
  over_mm[2] = start_mm[2];
  if (const auto moved = controller_->MoveTo(over_mm); !moved) return moved;
  return controller_->MoveTo(start_mm);
}

Expected<Touched> Probing::Touch(const Face& face, const TouchPlan& plan) {
  const double lead_in_mm = LeadIn_mm(face.n);
  const double off_mm = StandOff_mm(face);
  const double fast_mm_s = bench_->machine.probe.speeds_mm_s.front();
  const double more_mm = face.internal ? 0 : lead_in_mm;
  if (const auto gone = GoBefore(face, off_mm + more_mm); !gone) {
    return tl::unexpected(gone.error());
  }
  // The search ends as far behind the face as it began before it.
  const Vec3<double> beyond_mm = Within(face.at_mm - face.n * (off_mm + lead_in_mm));
  if (const auto found = controller_->ProbeTowards(beyond_mm, fast_mm_s); !found) {
    return tl::unexpected(found.error());
  }
  Touched touched{.face = face};
  for (int i = 0; i < plan.repeats; ++i) {
    if (const auto done = TouchOnce(face, plan, &touched); !done) {
      return tl::unexpected(done.error());
    }
  }
  const Vec3<double> away_mm =
      Within(controller_->position_mm() + face.n * std::min(off_mm, kStandOff_mm));
  if (const auto gone = controller_->MoveTo(away_mm); !gone) {
    return tl::unexpected(gone.error());
  }
  if (face.from_below) {
    Vec3<double> out_mm = away_mm;
    out_mm[1] += 2 * bench_->machine.probe.disc_radius_mm;
    if (const auto gone = controller_->MoveTo(out_mm); !gone) {
      return tl::unexpected(gone.error());
    }
  }
  if (const auto raised = Raise(); !raised) return tl::unexpected(raised.error());
  return touched;
}

Expected<void> Probing::TouchOnce(const Face& face,
                                  const TouchPlan& plan,
                                  Touched* touched) {
  const double lead_in_mm = LeadIn_mm(face.n);
  const Vec3<double> contact_mm = controller_->position_mm();
  const double back_mm = kBackOff_mm + lead_in_mm;
  const auto backed = controller_->MoveTo(Within(contact_mm + face.n * back_mm));
  if (!backed) return backed;
  const auto led =
      controller_->MoveTo(Within(contact_mm + face.n * (back_mm - lead_in_mm)),
                          bench_->machine.probe.speeds_mm_s.front());
  if (!led) return led;
  const double feed_mm_s =
      plan.feed_mm_s > 0 ? plan.feed_mm_s : bench_->machine.probe.speeds_mm_s.back();
  const Vec3<double> beyond_mm = Within(contact_mm - face.n * kBackOff_mm);
  const auto found = controller_->ProbeTowards(beyond_mm, feed_mm_s);
  if (!found) return found;
  ++touches_;
  Row row = RowOf(face, plan);
  row.rep = static_cast<std::int64_t>(touched->trigger_mm.size()) + 1;
  row.feed_mm_s = feed_mm_s;
  row.settings = SettingsId();
  touched->trigger_mm.push_back(row.value_mm);
  Record(row);
  return plan.release ? ReleaseOnce(face, plan, touched) : Expected<void>{};
}

Expected<void> Probing::ReleaseOnce(const Face& face,
                                    const TouchPlan& plan,
                                    Touched* touched) {
  const double feed_mm_s =
      plan.feed_mm_s > 0 ? plan.feed_mm_s : bench_->machine.probe.speeds_mm_s.back();
  if (plan.push_on_mm > 0) {
    const auto pushed = controller_->MoveTo(
        Within(controller_->position_mm() - face.n * plan.push_on_mm), feed_mm_s);
    if (!pushed) return pushed;
  }
  const Vec3<double> away_mm =
      Within(controller_->position_mm() + face.n * (kBackOff_mm + LeadIn_mm(face.n)));
  const auto left = controller_->ProbeAway(away_mm, feed_mm_s);
  if (!left) return left;
  Row row = RowOf(face, plan);
  row.rep = static_cast<std::int64_t>(touched->trigger_mm.size());
  row.feed_mm_s = feed_mm_s;
  row.settings = SettingsId();
  row.flag = kReleaseFlag;
  touched->release_mm.push_back(row.value_mm);
  Record(row);
  return {};
}

Row Probing::RowOf(const Face& face, const TouchPlan& plan) const {
  const double radius_mm = controller_->settings().tip_radius_mm;
  const Vec3<double>& tip_mm = controller_->position_mm();
  Row row{.campaign = plan.campaign, .kind = RowKind::kTouch};
  row.setup = SetupOf(face);
  row.home = HomeId();
  row.feature = face.feature;
  row.value_mm = (tip_mm - face.at_mm).dot(face.n) - radius_mm;
  double variance_mm2 = 0;
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    row.cmd_mm[static_cast<std::size_t>(i)] = face.at_mm[i];
    row.dir[static_cast<std::size_t>(i)] = controller_->direction()[i];
    row.n[static_cast<std::size_t>(i)] = face.n[i];
    const double sd_mm = TouchSd_mm(Noise(axis));
    variance_mm2 += face.n[i] * face.n[i] * sd_mm * sd_mm;
  }
  row.sigma_mm = std::sqrt(variance_mm2);
  controller_->NoteMotors(&row);
  return row;
}

void Probing::Record(Row row) {
  if (bench_->record != nullptr) {
    row.row = static_cast<std::int64_t>(bench_->record->rows.size()) + 1;
    bench_->record->rows.push_back(row);
  }
  rows_.push_back(std::move(row));
}

TouchNoise Probing::Noise(Axis axis) const {
  const auto probe = bench_->instruments.find("probe");
  const double sigma_um =
      probe == bench_->instruments.end() ? 0 : probe->second.sigma_um;
  const auto i = static_cast<std::size_t>(Index(axis));
  return {.sigma_mm = MmFromUm(sigma_um),
          .step_mm = 1 / controller_->settings().steps_per_mm[i]};
}

std::string Probing::SettingsId() {
  const Settings& now = controller_->settings();
  Ledger& ledger = bench_->ledger;
  for (const auto& [id, known] : ledger.settings) {
    const bool same = known.steps_per_mm == now.steps_per_mm &&
                      known.backlash_mm == now.backlash_mm &&
                      known.probe_deflection_mm == now.probe_deflection_mm &&
                      known.tip_radius_mm == now.tip_radius_mm;
    if (same) return ledger.settings_now = id;
  }
  ledger.settings_now = fmt::format("s{}", ledger.settings.size() + 1);
  ledger.settings[ledger.settings_now] = now;
  return ledger.settings_now;
}

std::string Probing::HomeId() const {
  return fmt::format("h{}", bench_->ledger.homings);
}

std::string Probing::SetupOf(const Face& face) const {
  const bool is_block = std::ranges::any_of(bench_->artefacts, [&](const Artefact& a) {
    const bool stands =
        a.type == ArtefactType::kBlock123 || a.type == ArtefactType::kWeb;
    return stands && a.id == face.artefact;
  });
  const bool looks_up = face.n[2] > 0.5;
  // What stands on the table is as high as its certificate says, however it was turned.
  if (looks_up && (is_block || face.artefact == "bed")) return "table";
  return SetupId(face.artefact);
}

std::string Probing::SetupId(const std::string& artefact) const {
  const auto placed = bench_->ledger.placements.find(artefact);
  const int times = placed == bench_->ledger.placements.end() ? 0 : placed->second;
  return times == 0 ? artefact : fmt::format("{}-{}", artefact, times + 1);
}

}  // namespace caltwin
