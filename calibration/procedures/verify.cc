#include "calibration/procedures/verify.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/procedures/gap_reading.h"
#include "calibration/procedures/plan_model.h"
#include "calibration/procedures/span.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kSize_mm = 0.02;        // NeXT 3.7, points 1 and 5.
constexpr double kReversal_mm = 0.01;    // Point 2.
constexpr double kScatter_mm = 0.005;    // Point 3.
constexpr double kOffset_mm = 0.01;      // Point 4.
constexpr double kProportion_mm = 0.01;  // Between the smallest and largest size.
constexpr double kLongest_mm = 76.2;     // Where a proportional error is judged.
constexpr int kRepeatability = 10;       // Touches of point 3.

// Error of a size with the stored deflection taken off each face.
double CompensatedError_mm(Session* session, Axis axis, const SpanReading& span) {
  if (span.is_height) return span.error_mm();
  const double sign = span.kind == SpanKind::kExternal ? 1 : -1;
  return span.error_mm() + sign * 2 * session->Believed(Setting::kDeflection, axis);
}

struct Line {
  double offset = 0;
  double slope = 0;
};

// Least squares e = offset + slope * D; one size has an offset only.
Line FitLine(const std::vector<double>& sizes_mm,
             const std::vector<double>& errors_mm) {
  const double size_mm = Mean(sizes_mm);
  const double error_mm = Mean(errors_mm);
  double product = 0, square = 0;
  for (std::size_t i = 0; i < sizes_mm.size(); ++i) {
    product += (sizes_mm[i] - size_mm) * (errors_mm[i] - error_mm);
    square += (sizes_mm[i] - size_mm) * (sizes_mm[i] - size_mm);
  }
  const double slope = square > 0 ? product / square : 0;
  return {.offset = error_mm - slope * size_mm, .slope = slope};
}

Expected<void> CheckSizes(Session* session,
                          Axis axis,
                          const VerifyOptions& o,
                          Checks* checks) {
  Artefact* block =
      FindArtefact(&session->bench(), o.artefact, {ArtefactType::kBlock123}, o.place);
  const SpanPlan plan{.axis = axis,
                      .repeats = o.repeats,
                      .campaign = "verify." + Name(axis),
                      .place = o.place};
  std::vector<double> sizes_mm, errors_mm;
  bool heights = false;
  for (const double size_mm : o.sizes_mm) {
    if (const auto laid = LayBlock(session, block, axis, size_mm); !laid) return laid;
    const auto span = MeasureSpan(session, *block, plan);
    if (!span) return tl::unexpected(span.error());
    heights = span->is_height;
    sizes_mm.push_back(size_mm);
    errors_mm.push_back(CompensatedError_mm(session, axis, *span));
    checks->sd_mm = span->span_mm.sd;
  }
  const Line line = FitLine(sizes_mm, errors_mm);
  checks->slope = line.slope;
  // Heights have no datum: their common offset is the table's.
  if (!heights) checks->offset_mm = line.offset;
  for (const double error_mm : errors_mm) {
    const double off_mm = heights ? error_mm - errors_mm.front() : error_mm;
    checks->worst_size_mm = std::max(checks->worst_size_mm, std::abs(off_mm));
  }
  const Face face = FacesForSpan(*block, plan).front();
  const auto touched = session->probing().Touch(
      face, {.repeats = kRepeatability, .campaign = "repeatability." + Name(axis)});
  if (!touched) return tl::unexpected(touched.error());
  checks->scatter_mm = Scatter(touched->trigger_mm);
  return {};
}

Expected<void> CheckReversal(Session* session,
                             Axis axis,
                             const VerifyOptions& o,
                             Checks* checks) {
  if (o.instrument == "none") return {};
  const auto left_mm =
      ReadGapLeft(session, axis, o.instrument + "." + Name(axis), o.repeats);
  if (!left_mm) {
    if (left_mm.error().kind != MachineFault::Kind::kRefused) {
      return tl::unexpected(left_mm.error());
    }
    session->Tell("No instrument reads the axis: the reversal is not checked. " +
                  left_mm.error().reply);
    return {};
  }
  checks->reversal_mm = left_mm->value;
  checks->compensated_mm = session->Believed(Setting::kBacklash, axis);
  checks->reversal_known = true;
  return {};
}

Expected<void> CheckPocket(Session* session,
                           Axis axis,
                           const VerifyOptions& o,
                           Checks* checks) {
  const Artefact* pocket =
      SeekArtefact(&session->bench(), "", {ArtefactType::kPocket}, o.place);
  if (pocket == nullptr || axis == Axis::kZ) return {};
  const auto span = MeasureSpan(session,
                                *pocket,
                                {.axis = axis,
                                 .repeats = o.repeats,
                                 .campaign = "verify_pocket." + Name(axis),
                                 .place = o.place});
  if (!span) return tl::unexpected(span.error());
  checks->pocket_mm = CompensatedError_mm(session, axis, *span);
  checks->pocket_known = true;
  return {};
}

std::string Judged(double value_mm, double limit_mm) {
  return fmt::format("{:+.4f} mm, {} {:.3g}",
                     value_mm,
                     std::abs(value_mm) <= limit_mm ? "within" : "beyond",
                     limit_mm);
}

void Print(Session* session, Axis axis, const Checks& checks) {
  const std::string name(1, Letter(axis));
  const auto tell = [&](std::string_view what, const std::string& how) {
    session->Tell({fmt::format("{}: {} {}", name, what, how), Message::Kind::kCheck});
  };
  tell("1. sizes: worst", Judged(checks.worst_size_mm, kSize_mm));
  tell(
      "2. reversal:",
      checks.reversal_known ? Judged(checks.reversal_mm, kReversal_mm) : "not checked");
  tell("3. repeatability:", Judged(checks.scatter_mm, kScatter_mm));
  tell("4. both directions:", Judged(checks.offset_mm, kOffset_mm));
  tell("5. a pocket not calibrated on:",
       checks.pocket_known ? Judged(checks.pocket_mm, kSize_mm) : "there is none");
}

Expected<void> VerifyAxis(Session* session, Axis axis, const VerifyOptions& o) {
  Checks checks;
  if (const auto done = CheckSizes(session, axis, o, &checks); !done) return done;
  if (const auto done = CheckReversal(session, axis, o, &checks); !done) return done;
  if (const auto done = CheckPocket(session, axis, o, &checks); !done) return done;
  Print(session, axis, checks);
  const std::vector<std::string> revisit = WhatToRevisit(axis, checks);
  for (const std::string& message : revisit) {
    session->Tell({message, Message::Kind::kCause});
  }
  session->Measured(
      NameOf(Setting::kStepsPerMm, axis),
      session->Believed(Setting::kStepsPerMm, axis),
      revisit.empty() ? fmt::format("{}: verified.", Letter(axis)) : revisit.front());
  return {};
}

Expected<void> Restart(Session* session) {
  const Settings wanted = session->believed();
  if (const auto restarted = session->controller().Restart(); !restarted) {
    return restarted;
  }
  const Settings now = session->believed();
  for (const Axis axis : kAxes) {
    for (const Setting setting :
         {Setting::kStepsPerMm, Setting::kBacklash, Setting::kDeflection}) {
      constexpr double kPrinted = 0.00051;
      const double lost = ValueOf(now, setting, axis) - ValueOf(wanted, setting, axis);
      if (std::abs(lost) < kPrinted) continue;
      session->Tell(
          fmt::format("{} did not survive the restart: {:.4f}, before {:.4f}. "
                      "Its line is missing from nxt-user-vars.g.",
                      NameOf(setting, axis),
                      ValueOf(now, setting, axis),
                      ValueOf(wanted, setting, axis)));
    }
  }
  return session->probing().Home();
}

}  // namespace

std::vector<std::string> WhatToRevisit(Axis axis, const Checks& checks) {
  constexpr double kSigmas = 3;
  std::vector<std::string> messages;
  const auto say = [&](const std::string& what) {
    messages.push_back(fmt::format("{}: {}", Letter(axis), what));
  };
  const double proportion_mm = checks.slope * kLongest_mm;
  if (std::abs(proportion_mm) > std::max(kProportion_mm, kSigmas * checks.sd_mm)) {
    say(
        fmt::format("errors grow with the size ({:+.3f} %): revisit steps/mm "
                    "(next_dual_dimension).",
                    PercentFromFraction(checks.slope)));
  }
  const bool directional =
      checks.reversal_known && std::abs(checks.reversal_mm) > kReversal_mm;
  if (directional) {
    say(
        fmt::format("approaches from both sides differ by {:+.4f} mm: revisit the "
                    "backlash compensation (next_cluster_backlash).",
                    checks.reversal_mm));
    const std::string why =
        WhyTooMuchCompensation(checks.compensated_mm, checks.reversal_mm);
    if (!why.empty()) say(why + ".");
  }
  // A gap left makes every block read that much small; what remains is the probe's.
  const double probe_mm = checks.offset_mm + checks.reversal_mm;
  if (std::abs(probe_mm) > kOffset_mm) {
    say(
        fmt::format("every size is off by the same {:+.4f} mm: revisit the probe's "
                    "deflection (next_deflection){}.",
                    probe_mm,
                    checks.reversal_known ? ""
                                          : ", or the backlash, which no "
                                            "instrument looked at"));
  }
  if (checks.scatter_mm > kScatter_mm) {
    say(
        fmt::format("ten touches scatter by {:.1f} um: look at the mechanics (loose "
                    "probe, spindle runout).",
                    UmFromMm(checks.scatter_mm)));
  }
  if (checks.pocket_known && std::abs(checks.pocket_mm) > kSize_mm) {
    say(
        fmt::format("the pocket reads {:+.4f} mm off: bores and blocks disagree, see "
                    "deflection and tip radius.",
                    checks.pocket_mm));
  }
  return messages;
}

Expected<void> RunVerify(Session* session, const VerifyOptions& o) {
  if (o.restart) {
    if (const auto restarted = Restart(session); !restarted) return restarted;
  }
  for (const Axis axis : o.axes) {
    if (const auto done = VerifyAxis(session, axis, o); !done) return done;
  }
  return {};
}

namespace {

PreparedProcedure PrepareVerify(YamlMap map, const Machine& /*drawing*/) {
  VerifyOptions o;
  o.place = map.place();
  o.axes = ReadAxes(&map);
  const std::string variant =
      map.WordOr("variant", "corrected", {"as_published", "corrected"});
  o.artefact = map.TextOr("artefact", "");
  o.sizes_mm = ReadDimensions(&map, o.sizes_mm);
  o.repeats = static_cast<int>(map.IntegerOr("repeats", 3, 1, 1000));
  o.instrument = map.WordOr("instrument", "dial", {"dial", "laser", "none"});
  o.restart = map.FlagOr("restart", false);
  map.NoMoreKeys();
  return [o, variant](Bench* bench) {
    Session session(bench, "next_verify", variant, {});
    if (const auto begun = session.Begin(); !begun) return session.Finish(begun);
    return session.Finish(RunVerify(&session, o));
  };
}

}  // namespace

constinit const Procedure kVerify{
    .name = "next_verify",
    .about =
        "NeXT phase 5: verifies all calibrations together and says which to "
        "revisit.",
    .source = "NeXT machine calibration guide 1.0, section 3.7.",
    .published =
        "1. several sizes within 0.02 mm; 2. one surface from opposite directions "
        "within 0.01 mm; 3. ten touches within 0.005 mm standard deviation; 4. both "
        "directions within 0.01 mm; 5. a machined pocket measured. Proportional: "
        "steps; "
        "directional: backlash; fixed offset: deflection; scatter: mechanics.",
    .physics =
        "Point 2 cannot be done with a stylus (a solid has one side), so a dial or a "
        "laser reads one commanded position come to from both senses. The errors of "
        "three sizes are split into a part that grows with the size (steps/mm) and a "
        "constant; of the constant, the gap left counts -b, the rest is pre-travel and "
        "tip. Heights have no datum, so along z only the proportional part shows.",
    .has_variants = false,
    .prepare = PrepareVerify};

}  // namespace caltwin
