#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/estimate/deflection.h"
#include "calibration/loop/session.h"
#include "sim/machine/artefact.h"

namespace caltwin {

/// A certified size, measured by touching what it lies between.
struct SpanReading {
  Given size_mm{};  ///< Certified.
  SpanKind kind = SpanKind::kExternal;
  /// After tip compensation by the configured radius, in commanded mm. Of a height over
  /// a datum that is not touched: up to a constant.
  Given span_mm{};
  bool is_height = false;  ///< One face and the machine's zero: no tip, no reversal.
  std::vector<Touched> faces{};
  double scatter_mm = 0;  ///< Pooled sample standard deviation of the repeats.

  double error_mm() const { return span_mm.value - size_mm.value; }
};

/// Has the operator turn a 1-2-3 block so that `length_mm` lies along `axis`; nothing
/// where it does already. A block that is moved counts as put down anew.
Expected<void> LayBlock(Session* session, Artefact* block, Axis axis, double length_mm);

/// Touches both faces across `axis`, or for z the top. Throws InputError at `place`
/// where the artefact lies askew or has no such faces.
struct SpanPlan {
  Axis axis = Axis::kX;
  int repeats = 5;
  std::string campaign{};
  Place place{};
};
Expected<SpanReading> MeasureSpan(Session* session,
                                  const Artefact& artefact,
                                  const SpanPlan& plan);

/// A certified size as a source that results share: "size of block along x".
std::string SizeOf(const Artefact& artefact, Axis axis);

/// The faces that MeasureSpan would touch.
std::vector<Face> FacesForSpan(const Artefact& artefact, const SpanPlan& plan);

/// The probe's stated noise, or what the repeats show where they contradict it
/// (NoiseSeen), pooled over the faces, all across `axis`.
TouchNoise NoiseOf(Session* session, Axis axis, std::span<const Touched> faces);

/// Ledger's gap less the compensation in force: what is left. kNotGiven where nobody
/// has measured it.
Given BacklashLeft(Session* session, Axis axis);

/// The ball's radius as a source that results share.
inline constexpr char kTipRadius[] = "tip radius";
/// Uncertainty of a ball's radius as its maker states it.
inline constexpr double kTipDoubt_mm = 0.001;

/// The ball's radius: as told, else from `calliper.tip` where a calliper is among the
/// instruments and knows it better than the maker or contradicts what was entered, else
/// as entered. Says so where the two differ.
Given TipRadius(Session* session, const std::optional<Given>& told);

/// How far the stylus may be pushed on after the trigger [mm] without moving the
/// carriage in its gap: 0.05, or 0 where half the rail's friction would not hold it.
double PushOn_mm(Session* session, Axis axis);

/// Warns by message where repeats scatter by more than 5 um, and says why, where the
/// touches of each face (in their order) tell it.
void WarnOfScatter(Session* session,
                   const std::string& what,
                   double scatter_mm,
                   std::span<const std::vector<double>> faces_mm);

}  // namespace caltwin
