#include "calibration/kinds/triple_z/procedures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/doing.h"
#include "calibration/kinds/triple_z/troubles.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

// Tries the screws and foretells what rounds do; false: not to go on.
bool Foretell(TripleZPrinter* printer,
              const TripleZOptions& o,
              const Pivots<double>& believed_mm,
              Doing* doing) {
  const auto stands = TryScrews(printer, o, doing);
  if (!stands) return false;
  const TripleZBench& bench = printer->bench();
  const ScrewResponse response =
      FitScrewResponse(*stands, bench.drawn_mm, bench.sigma_mm, bench.is_sigma_stated);
  if (!response.is_told) {
    doing->Refuse(fmt::format(
        "nothing was levelled: screws raised one by one by {} mm do not show where "
        "they "
        "stand beside the scatter of the touches, so nobody knows what levelling would "
        "do. Raise them more (test_mm), or touch more points (grid)",
        o.test_mm));
    return false;
  }
  doing->SayAll(WordsOfResponse(response, bench.drawn_mm));
  doing->done().response = response;
  const LevellingFactor factor = FactorOf(response, believed_mm);
  doing->done().predicted_factor = factor.value;
  doing->Say(WordsOfGain(factor));
  if (factor.converges()) return true;
  doing->Refuse(factor.diverges()
                    ? "nothing was levelled: run pivots_and_wiring first"
                    : "nothing was levelled: run pivots_and_wiring first, or raise the "
                      "screws more (test_mm) or touch more points (grid) to know it");
  return false;
}

// The tilt of one plane over that of another.
double Steeper(const BedPlane& after, const BedPlane& before) {
  constexpr double kLevel = 1e-12;
  return std::hypot(after.a(), after.b()) /
         std::max(std::hypot(before.a(), before.b()), kLevel);
}

constexpr double kStillTilted = 0.1;  // Of the tilt before: somebody asks why.

// As published the list; corrected what the screws did, where it tells.
void SayStillTilted(const TripleZPrinter& printer,
                    const TripleZOptions& o,
                    const Vec3<double>& raised_mm,
                    const BedPlane& before,
                    const BedPlane& after,
                    Doing* doing) {
  const std::string why =
      o.is_as_published ? "" : WhyNotLevel(raised_mm, before, after, printer.bench());
  if (!why.empty()) {
    doing->Say({"still tilted after the corrections: " + why, Message::Kind::kCause});
    return;
  }
  constexpr double kPublished = 0.5;
  if (Steeper(after, before) < kPublished) return;
  doing->Say(
      "the bed is still tilted after the corrections: look whether each motor is "
      "plugged where it belongs and M671 says where its screw stands "
      "(pivots_and_wiring tells both), and whether every screw moves");
}

// Raises the screws as the plane asks, and touches again.
struct Round {
  Vec3<double> raise_mm = Vec3<double>::Zero();
  LevelReport before{}, after{};
  BedPlane plane{};  ///< After it.
};

std::optional<Round> LevelOnce(TripleZPrinter* printer,
                               const TripleZOptions& o,
                               const BedPlane& plane,
                               const LevelReport& before,
                               Doing* doing) {
  Round round{.before = before};
  round.raise_mm =
      ScrewOffsets_mm(plane, printer->bench().drawn_mm, o.reference_mm, o.rule);
  if (!IsSmallEnough(round.raise_mm, o, doing)) return std::nullopt;
  if (!doing->Did(printer->Raise(round.raise_mm))) return std::nullopt;
  std::vector<BedTouch> touches;
  const auto again = ProbePlane(printer, o, doing, &touches);
  if (!again) return std::nullopt;
  round.plane = *again;
  round.after = ReportLevel(touches, o.reference_mm);
  return round;
}

}  // namespace

TripleZResult RunPlaneTilt(TripleZPrinter* printer, const TripleZOptions& options) {
  Doing doing("plane_tilt", options, printer);
  std::vector<BedTouch> touches;
  const auto plane = ProbePlane(printer, options, &doing, &touches);
  if (plane) {
    const LevelReport report = ReportLevel(touches, options.reference_mm);
    doing.done().level = report;
    doing.Say(WordsOfLevel(report));
    doing.Step("bed_tilt.slope_x_mrad",
               0,
               MradFromRad(plane->a()),
               Verdict::kMeasured,
               "told by the plane's slope");
    doing.Step("bed_tilt.slope_y_mrad",
               0,
               MradFromRad(plane->b()),
               Verdict::kMeasured,
               "told by the plane's slope");
    HoldOut(printer, options, *plane, &doing);
    if (!plane->is_told()) {
      doing.Confess("points on one line tell one slope",
                    AlongBoth("bed_tilt.slope_x_mrad", "bed_tilt.slope_y_mrad"));
    }
  }
  return doing.Take();
}

TripleZResult RunBedTilt(TripleZPrinter* printer, const TripleZOptions& options) {
  const bool iterates = options.iterates;
  Doing doing(iterates ? "bed_tilt_iterated" : "bed_tilt", options, printer);
  if (iterates && !options.is_as_published &&
      !Foretell(printer, options, printer->bench().drawn_mm, &doing)) {
    return doing.Take();
  }
  std::vector<BedTouch> touches;
  auto plane = ProbePlane(printer, options, &doing, &touches);
  if (!plane || !plane->is_told()) return doing.Take();
  LevelReport report = ReportLevel(touches, options.reference_mm);
  doing.done().level = report;
  for (int i = 1; i <= options.rounds; ++i) {
    if (iterates && report.mean_mm < options.target_mm) break;
    const Vec3<double> before_mm = printer->raised_mm();
    const auto round = LevelOnce(printer, options, *plane, report, &doing);
    if (!round) break;
    // As the bed stands: whether it is flatter, wherever level.
    const double steeper = Steeper(round->plane, *plane);
    doing.done().steeper.push_back(steeper);
    doing.Say(
        fmt::format("round {}: raised {:+.4f} {:+.4f} {:+.4f} mm, tilt times {:.3f}",
                    i,
                    round->raise_mm[0],
                    round->raise_mm[1],
                    round->raise_mm[2],
                    steeper));
    if (steeper > kStillTilted && round->before.mean_mm > options.target_mm) {
      SayStillTilted(*printer, options, round->raise_mm, *plane, round->plane, &doing);
    }
    const bool is_worse = round->after.mean_mm > round->before.mean_mm && steeper > 1;
    if (is_worse && !options.is_as_published) {
      doing.StepScrews(before_mm,
                       before_mm,
                       Verdict::kRolledBack,
                       "validation is worse than before: undone",
                       i);
      doing.Did(printer->Raise(-round->raise_mm));
      break;
    }
    doing.StepScrews(
        before_mm, printer->raised_mm(), Verdict::kApplied, "raised by the plane", i);
    plane = round->plane;
    report = round->after;
    doing.done().level = report;
  }
  doing.Say(WordsOfLevel(report));
  HoldOut(printer, options, LevelPlane(options.reference_mm), &doing);
  return doing.Take();
}

TripleZResult RunRrfLevelling(TripleZPrinter* printer, const TripleZOptions& options) {
  Doing doing("rrf_levelling", options, printer);
  if (!options.is_as_published) {
    const auto believed_mm = doing.Got(printer->ReadPivots());
    if (!believed_mm || !Foretell(printer, options, *believed_mm, &doing)) {
      return doing.Take();
    }
  }
  std::vector<BedTouch> touches;
  auto plane = ProbePlane(printer, options, &doing, &touches);
  if (!plane) return doing.Take();
  for (int i = 1; i <= options.rounds; ++i) {
    const LevelReport before = ReportLevel(touches, 0);
    const Vec3<double> before_mm = printer->raised_mm();
    const auto said = doing.Got(printer->Level(PointsOf(*printer, options)));
    if (!said) break;
    doing.SayAll(*said);
    const auto again = ProbePlane(printer, options, &doing, &touches);
    if (!again) break;
    const double steeper = Steeper(*again, *plane);
    doing.done().steeper.push_back(steeper);
    if (steeper > kStillTilted && before.mean_mm > options.target_mm) {
      SayStillTilted(
          *printer, options, printer->raised_mm() - before_mm, *plane, *again, &doing);
    }
    plane = again;
    const LevelReport after = ReportLevel(touches, 0);
    if (steeper > 1 && after.mean_mm > before.mean_mm && !options.is_as_published) {
      doing.StepScrews(before_mm,
                       before_mm,
                       Verdict::kRolledBack,
                       "validation is worse than before: undone",
                       i);
      doing.Did(printer->Raise(before_mm - printer->raised_mm()));
      break;
    }
    doing.Step("level_error_mm.mean",
               before.mean_mm,
               after.mean_mm,
               Verdict::kApplied,
               said->empty() ? "" : said->back(),
               i);
    doing.done().level = after;
    if (after.mean_mm < options.target_mm) break;
  }
  if (doing.done().level) doing.Say(WordsOfLevel(*doing.done().level));
  HoldOut(printer, options, LevelPlane(0), &doing);
  return doing.Take();
}

}  // namespace caltwin
