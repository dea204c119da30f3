#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/kinds/triple_z/doing.h"
#include "sim/effects/motors_swapped.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

// Two rounds of levelling by the drawn screws, watched.
std::optional<std::vector<RaisedTouches>> WatchRounds(TripleZPrinter* printer,
                                                      const TripleZOptions& o,
                                                      Doing* doing) {
  constexpr int kRounds = 2;
  const auto points = ProbeGrid(printer->bench(), 3, 3, o.margin_mm);
  const Vec3<double> start_mm = printer->raised_mm();
  std::vector<RaisedTouches> stands;
  for (int i = 0; i <= kRounds; ++i) {
    auto touches = doing->Got(printer->ProbeAll(points));
    if (!touches) return std::nullopt;
    stands.push_back({printer->raised_mm() - start_mm, *std::move(touches)});
    if (i == kRounds) break;
    const BedPlane plane = FitBedPlane(stands.back().touches,
                                       printer->bench().sigma_mm,
                                       printer->bench().is_sigma_stated);
    const Vec3<double> raise_mm =
        ScrewOffsets_mm(plane, printer->bench().drawn_mm, 0, OffsetRule::kLevel);
    if (!IsSmallEnough(raise_mm, o, doing)) return std::nullopt;
    if (!doing->Did(printer->Raise(raise_mm))) return std::nullopt;
  }
  return stands;
}

void AddPivotEstimates(const ScrewResponse& response,
                       const Pivots<double>& drawn_mm,
                       ProcedureResult* result) {
  for (std::size_t i = 0; i < response.at_mm.size(); ++i) {
    const auto screw = static_cast<std::size_t>(response.screw_of[i]);
    const Eigen::Vector2d off_mm = response.at_mm[i] - drawn_mm[screw];
    for (int k = 0; k < 2; ++k) {
      const Given at{.sd = response.at_sd_mm[i][k], .dof = response.dof};
      result->estimates.push_back(
          {.name = fmt::format(
               "pivot_position.{}.d{}_mm", ScrewName(static_cast<int>(screw)), "xy"[k]),
           .unit = "mm",
           .value = off_mm[k],
           .sd = at.sd,
           .identifiable = true,
           .budget = {InputOf("touches", 1, at)}});
    }
  }
  std::vector<std::string> names;
  for (const Estimate& estimate : result->estimates) {
    if (estimate.name.starts_with("pivot_position.")) names.push_back(estimate.name);
  }
  result->correlations.push_back(CorrelationsOf(
      "pivots_and_wiring", std::move(names), response.at_covariance_mm2));
  for (const std::string_view wiring : MotorsSwapped::kWirings) {
    const bool is_so = MotorsSwapped::ScrewsTurned(wiring) == response.screw_of;
    result->estimates.push_back({.name = fmt::format("motors_swapped.{}", wiring),
                                 .unit = "1",
                                 .value = is_so ? 1.0 : 0.0,
                                 .sd = 0,
                                 .identifiable = true});
  }
}

}  // namespace

TripleZResult RunPivotsAndWiring(TripleZPrinter* printer,
                                 const TripleZOptions& options) {
  Doing doing("pivots_and_wiring", options, printer);
  const TripleZBench& bench = printer->bench();
  const auto believed_mm = doing.Got(printer->ReadPivots());
  if (!believed_mm) return doing.Take();
  const auto stands = options.from_rounds ? WatchRounds(printer, options, &doing)
                                          : TryScrews(printer, options, &doing);
  if (!stands) return doing.Take();
  const ScrewResponse response =
      FitScrewResponse(*stands, bench.drawn_mm, bench.sigma_mm, bench.is_sigma_stated);
  if (response.is_told) doing.SayAll(WordsOfResponse(response, bench.drawn_mm));
  if (!response.is_told) {
    doing.Confess(options.from_rounds
                      ? "two rounds whose corrections are nearly alike tell one "
                        "direction of the screws' places: raise single screws, one by "
                        "one"
                      : fmt::format("touches that scatter by {:.3f} mm do not tell "
                                    "where the screws stand: raise them by more "
                                    "(test_mm), or mend the probe",
                                    response.rms_mm),
                  response.WeakestOf());
    return doing.Take();
  }
  doing.done().response = response;
  const LevellingFactor factor = FactorOf(response, *believed_mm);
  doing.done().predicted_factor = factor.value;
  doing.Say("with M671 as it was, " + WordsOfGain(factor));
  AddPivotEstimates(response, bench.drawn_mm, &doing.done().result);
  if (options.is_as_published) return doing.Take();
  if (!doing.Did(printer->SetPivots(response.at_mm))) return doing.Take();
  for (std::size_t i = 0; i < response.at_mm.size(); ++i) {
    for (int k = 0; k < 2; ++k) {
      doing.Step(
          fmt::format("screw_at_mm.{}.{}", ScrewName(static_cast<int>(i)), "xy"[k]),
          (*believed_mm)[i][k],
          response.at_mm[i][k],
          Verdict::kApplied,
          "M671 says where the screw of this driver stands");
    }
  }
  doing.Say("with M671 as it is now, " +
            WordsOfGain(FactorOf(response, response.at_mm)));
  return doing.Take();
}

}  // namespace caltwin
