#include "calibration/kinds/corexy/diagonals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "calibration/estimate/linear_fit.h"
#include "sim/base/units.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr double kFromEnds_mm = 15;
constexpr double kLeadIn_mm = 5;
constexpr double kUnlike_sds = 4;

const DriveMap& DrivesOfBench(Session* session) {
  return *session->bench().machine.kind->drive_map();
}

// Of one gauge, its rounding included.
double GaugeSd_mm(Session* session, const DiagonalOptions& o) {
  const auto& instruments = session->bench().instruments;
  const auto found = instruments.find(o.instrument);
  if (found == instruments.end()) return 0;
  return std::hypot(MmFromUm(found->second.sigma_um),
                    MmFromUm(found->second.resolution_um) / std::sqrt(12.0));
}

// Of what a drive goes, as its gauges read it.
double Sd_mm(Session* session, const DiagonalOptions& o, int drive) {
  const Eigen::Matrix3d& by_axis = DrivesOfBench(session).drives_by_axis;
  const auto k = static_cast<std::size_t>(drive);
  const double step_mm = 1 / session->believed().steps_per_mm[k];
  return std::hypot(by_axis.row(drive).norm() * GaugeSd_mm(session, o),
                    step_mm / std::sqrt(12.0));
}

Expected<Vec3<double>> ReadTip_mm(Session* session, const DiagonalOptions& o) {
  Vec3<double> tip_mm = Vec3<double>::Zero();
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const auto read_mm =
        session->bench().gauge->Read_mm(o.instrument + "." + Name(axis));
    if (!read_mm) return tl::unexpected(read_mm.error());
    tip_mm[Index(axis)] = *read_mm;
  }
  return tip_mm;
}

// Half of the longest way through the middle along that direction [mm].
double Reach_mm(const Machine& machine, const Vec3<double>& along) {
  double reach_mm = 1e9;
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const double part = std::abs(along[Index(axis)]);
    const double room_mm =
        machine.axis(axis).travel_mm() / 2 - kFromEnds_mm - kLeadIn_mm;
    if (part > 0) reach_mm = std::min(reach_mm, room_mm / part);
  }
  return reach_mm;
}

/// What a line of readings says: how far too far it goes, and the play in it.
struct Line {
  double excess = 0, excess_sd = 0;
  double gap_mm = 0, gap_sd_mm = 0;
};

// Goes along `along` (the axes' way for 1 mm of what `reads` sums up of them), and
// back.
Expected<Line> MeasureDiagonals(Session* session,
                                const DiagonalOptions& o,
                                const Vec3<double>& along,
                                const Vec3<double>& reads,
                                double sd_mm) {
  const Machine& machine = session->bench().machine;
  const double reach_mm = Reach_mm(machine, along);
  Vec3<double> middle_mm = machine.kind->Middle_mm(machine);
  middle_mm[2] = session->controller().position_mm()[2];
  const auto go = [&](double by_mm) {
    return session->controller().MoveTo(middle_mm + by_mm * along,
                                        machine.axis(Axis::kX).max_feed_mm_s / 4);
  };
  const int count = 2 * o.repeats * o.positions;
  Eigen::MatrixXd a(count, 3);
  Eigen::VectorXd r(count);
  Eigen::Index row = 0;
  for (int i = 0; i < 2 * o.repeats; ++i) {
    const int sense = i % 2 == 0 ? 1 : -1;
    if (const auto gone = go(-sense * (reach_mm + kLeadIn_mm)); !gone) {
      return tl::unexpected(gone.error());
    }
    for (int k = 0; k < o.positions; ++k) {
      const double told_mm = sense * reach_mm * (2.0 * k / (o.positions - 1) - 1);
      if (const auto gone = go(told_mm); !gone) return tl::unexpected(gone.error());
      const auto tip_mm = ReadTip_mm(session, o);
      if (!tip_mm) return tl::unexpected(tip_mm.error());
      const double beyond_mm = reads.dot(*tip_mm - middle_mm) - told_mm;
      a.row(row) << 1 / sd_mm, told_mm / sd_mm, -sense / (2 * sd_mm);
      r[row++] = beyond_mm / sd_mm;
    }
  }
  const LinearFit fit = SolveLinear(a, r);
  const double wider = std::sqrt(std::max(1.0, fit.chi2_per_dof));
  return Line{.excess = fit.x[1],
              .excess_sd = wider * fit.sd(1),
              .gap_mm = fit.x[2],
              .gap_sd_mm = wider * fit.sd(2)};
}

Expected<Line> MeasureDrive(Session* session, const DiagonalOptions& o, int drive) {
  const DriveMap& drives = DrivesOfBench(session);
  return MeasureDiagonals(session,
                          o,
                          drives.axes_by_drive.col(drive),
                          drives.drives_by_axis.row(drive).transpose(),
                          Sd_mm(session, o, drive));
}

Uncertain Found(double value, double sd) {
  return {.value = value,
          .sd = sd,
          .identifiable = true,
          .budget = {{.input = "readings", .u = sd}}};
}

/// A change that was proposed, and what there was before it.
struct Change {
  Proposal proposal{};
  double before = 0, error_before = 0;
  Uncertain found{};
};

Change StepsChange(Session* session, int drive, const Line& line, bool is_axis) {
  const Axis axis = kAxes[static_cast<std::size_t>(drive)];
  const double before = session->Believed(Setting::kStepsPerMm, axis);
  const double after = before / (1 + line.excess);
  return {
      .proposal = {.setting = Setting::kStepsPerMm,
                   .axis = axis,
                   .after = after,
                   .sd = after * line.excess_sd,
                   .why = fmt::format("{} goes {:+.0f} ppm too far.",
                                      is_axis ? "The axis" : "Along its diagonal it",
                                      line.excess * 1e6)},
      .before = before,
      .error_before = line.excess,
      .found = Found(after, after * line.excess_sd)};
}

Change GapChange(Session* session, int drive, const Line& line) {
  const Axis axis = kAxes[static_cast<std::size_t>(drive)];
  const double before_mm = session->Believed(Setting::kBacklash, axis);
  const double gap_mm = before_mm + line.gap_mm;
  return {.proposal = {.setting = Setting::kBacklash,
                       .axis = axis,
                       .after = std::max(0.0, gap_mm),
                       .sd = line.gap_sd_mm,
                       .why = fmt::format("{:+.4f} mm of play beside the {:.4f} mm "
                                          "compensated.",
                                          line.gap_mm,
                                          before_mm)},
          .before = before_mm,
          .error_before = line.gap_mm,
          .found = Found(gap_mm, line.gap_sd_mm)};
}

std::string NameOfChange(Session* session, const Change& change) {
  return NameOf(change.proposal.setting, change.proposal.axis, &DrivesOfBench(session));
}

// Whether all of them were applied; the first that is not ends it.
Expected<bool> ApplyAll(Session* session, const std::vector<Change>& changes) {
  for (const Change& change : changes) {
    const auto applied = session->Apply(change.proposal);
    if (!applied || !*applied) return applied;
  }
  return true;
}

void SayWhetherUnlike(Session* session, const std::array<Line, 2>& lines) {
  const double apart = lines[0].excess - lines[1].excess;
  const double sd = std::hypot(lines[0].excess_sd, lines[1].excess_sd);
  if (std::abs(apart) < kUnlike_sds * sd) {
    session->Tell(
        "Both diagonals err alike: the belts are alike and the beam is square, "
        "as far as this tells.");
    return;
  }
  session->Tell(fmt::format(
      "One diagonal is {:.0f} +- {:.0f} ppm longer than the other: a belt of "
      "another pitch, or a beam that is {:.2f} mrad off square. Lengths "
      "along diagonals cannot tell which; square the beam first, then run "
      "this again.",
      std::abs(apart) * 1e6,
      sd * 1e6,
      std::abs(apart) * 1e3));
}

Expected<void> VerifyAll(Session* session,
                         const DiagonalOptions& o,
                         const std::vector<Change>& changes) {
  std::array<Line, 2> after{};
  for (int drive = 0; drive < 2; ++drive) {
    const auto line = MeasureDrive(session, o, drive);
    if (!line) return tl::unexpected(line.error());
    after[static_cast<std::size_t>(drive)] = *line;
  }
  for (const Change& change : changes) {
    const Line& line = after[static_cast<std::size_t>(Index(change.proposal.axis))];
    const bool is_gap = change.proposal.setting == Setting::kBacklash;
    const auto kept =
        session->KeepOrRollBack(change.proposal,
                                change.before,
                                {.error_before = change.error_before,
                                 .error_after = is_gap ? line.gap_mm : line.excess,
                                 .sd = is_gap ? line.gap_sd_mm : line.excess_sd});
    if (!kept) return tl::unexpected(kept.error());
    session->Conclude(
        NameOfChange(session, change), is_gap ? "mm" : "1/mm", change.found, *kept);
  }
  return {};
}

// As guides to other machines have it: x by x, y by y, each setting by its own axis.
Expected<void> RunAxisByAxis(Session* session, const DiagonalOptions& o) {
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const auto line = MeasureDiagonals(
        session, o, Unit(axis), Unit(axis), std::max(GaugeSd_mm(session, o), 1e-4));
    if (!line) return tl::unexpected(line.error());
    const Change change = StepsChange(session, Index(axis), *line, /*is_axis=*/true);
    const auto applied = session->Apply(change.proposal);
    if (!applied) return tl::unexpected(applied.error());
    session->Conclude(NameOfChange(session, change), "1/mm", change.found, *applied);
    if (!*applied) session->End(Ending::kRefused);
  }
  return {};
}

}  // namespace

Expected<void> RunDiagonals(Session* session, const DiagonalOptions& o) {
  if (const auto raised = session->probing().Raise(); !raised) return raised;
  if (o.as_published) return RunAxisByAxis(session, o);
  std::array<Line, 2> lines{};
  std::vector<Change> changes;
  for (int drive = 0; drive < 2; ++drive) {
    const auto line = MeasureDrive(session, o, drive);
    if (!line) return tl::unexpected(line.error());
    lines[static_cast<std::size_t>(drive)] = *line;
    changes.push_back(StepsChange(session, drive, *line, /*is_axis=*/false));
    changes.push_back(GapChange(session, drive, *line));
  }
  SayWhetherUnlike(session, lines);
  const auto applied = ApplyAll(session, changes);
  if (!applied) return tl::unexpected(applied.error());
  if (*applied && o.verify) return VerifyAll(session, o, changes);
  if (!*applied && session->rules().apply) session->End(Ending::kRefused);
  for (const Change& change : changes) {
    const bool is_gap = change.proposal.setting == Setting::kBacklash;
    session->Conclude(
        NameOfChange(session, change), is_gap ? "mm" : "1/mm", change.found, *applied);
  }
  return {};
}

namespace {

PreparedProcedure PrepareDiagonals(YamlMap map, const Machine& /*drawing*/) {
  DiagonalOptions o;
  o.as_published = map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
                   "as_published";
  o.positions = static_cast<int>(map.IntegerOr("positions", o.positions, 3, 200));
  o.repeats = static_cast<int>(map.IntegerOr("repeats", o.repeats, 1, 100));
  o.verify = map.FlagOr("verify", true);
  o.instrument = map.WordOr("instrument", "laser", {"laser", "dial"});
  o.rules.apply = map.FlagOr("apply", true);
  o.rules.steps_limit = map.NumberOr("steps_limit", o.rules.steps_limit, {1e-6, 1});
  o.rules.roll_back = map.FlagOr("rollback", !o.as_published);
  map.NoMoreKeys();
  return [o](Bench* bench) {
    Session session(bench,
                    "belt_diagonals",
                    o.as_published ? "as_published" : "corrected",
                    o.rules);
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunDiagonals(&session, o));
  };
}

}  // namespace

constinit const Procedure kBeltDiagonals{
    .name = "belt_diagonals",
    .about =
        "Steps/mm and play of a CoreXY's two belts, each moved along its diagonal.",
    .source =
        "a = x + y, b = x - y (Klipper, kinematics/corexy.py); guides to printers "
        "with a motor an axis for the published variant.",
    .published =
        "Move x by 100 mm, measure, M92 X s * commanded / actual; then y the "
        "same way, M92 Y.",
    .physics =
        "Motor A moves both axes, so what x goes too far says half of each belt, "
        "and M92 X sets one of them: belts of unlike pitch stay as unlike as "
        "they were, or become more so. Along a diagonal only one belt moves.",
    .has_variants = true,
    .prepare = PrepareDiagonals,
    .drives = DrivesAsked::kCoupled};

}  // namespace caltwin
