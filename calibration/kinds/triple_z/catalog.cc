#include "calibration/kinds/triple_z/catalog.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/procedures.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::string_view kTripleZKind = "triple_z";
constexpr std::array<std::string_view, 5> kNames = {"plane_tilt",
                                                    "bed_tilt",
                                                    "bed_tilt_iterated",
                                                    "rrf_levelling",
                                                    "pivots_and_wiring"};

void ReadGrid(YamlMap* map, TripleZOptions* options) {
  const auto grid = map->Optional("grid");
  if (!grid) return;
  const auto numbers = grid->Numbers(2, {2, 20});
  if (numbers.size() != 2) return;
  options->columns = static_cast<int>(numbers[0]);
  options->rows = static_cast<int>(numbers[1]);
  if (numbers[0] != options->columns || numbers[1] != options->rows) {
    grid->Fail("is no pair of whole numbers", "as in `grid: [3, 3]`");
  }
  if (options->at_screws && !options->holds_out) {
    grid->Fail("is not touched with `at: screws`", "leave one of them out");
  }
}

// Where the bed is touched; for pivots always three by three.
void ReadProbing(std::string_view name, YamlMap* map, TripleZOptions* options) {
  options->margin_mm = map->NumberOr("margin_mm", options->margin_mm, {0, 100});
  if (name == "pivots_and_wiring") return;
  if (const auto at = map->Optional("at")) {
    options->at_screws = at->Word({"grid", "screws"}) == "screws";
  }
  const auto hold_out = map->Optional("hold_out");
  options->holds_out = hold_out && hold_out->Flag();
  ReadGrid(map, options);
}

void ReadLevelling(YamlMap* map, TripleZOptions* options) {
  options->reference_mm = map->NumberOr("reference_mm", 0, {-50, 250});
  if (options->is_as_published) {
    const std::string sign = map->WordOr("offsets", "example", {"example", "formula"});
    options->rule = sign == "formula" ? OffsetRule::kFormula : OffsetRule::kExample;
  }
  options->largest_mm = map->NumberOr("largest_mm", options->largest_mm, {0, 250});
}

void ReadRounds(YamlMap* map, int otherwise, TripleZOptions* options) {
  options->rounds = static_cast<int>(map->IntegerOr("rounds", otherwise, 1, 50));
  options->target_mm = map->NumberOr("target_mm", options->target_mm, {0, 10});
}

TripleZOptions ReadTripleZOptions(std::string_view name, YamlMap* map) {
  TripleZOptions o;
  o.is_as_published =
      map->WordOr("variant", "corrected", {"as_published", "corrected"}) ==
      "as_published";
  const bool finds_pivots = name == "pivots_and_wiring";
  if (finds_pivots) {
    o.from_rounds =
        map->WordOr("from", "single_screws", {"single_screws", "rounds"}) == "rounds";
  }
  ReadProbing(name, map, &o);
  if (finds_pivots && o.from_rounds) {
    o.largest_mm = map->NumberOr("largest_mm", o.largest_mm, {0, 250});
  }
  if (name == "bed_tilt" || name == "bed_tilt_iterated") ReadLevelling(map, &o);
  if (name == "plane_tilt")
    o.reference_mm = map->NumberOr("reference_mm", 0, {-50, 250});
  o.iterates = name == "bed_tilt_iterated";
  if (o.iterates) ReadRounds(map, 5, &o);
  if (name == "rrf_levelling") ReadRounds(map, 2, &o);
  const bool foretells = (o.iterates || name == "rrf_levelling") && !o.is_as_published;
  if (foretells || (finds_pivots && !o.from_rounds)) {
    // To tell wiring half a millimetre does, to tell places more is better.
    o.test_mm = map->NumberOr("test_mm", finds_pivots ? 2 : 0.5, {0.01, 10});
  }
  map->NoMoreKeys();
  return o;
}

// What the engine knows of the printer, from one procedure to the next.
TripleZPrinter* PrinterOn(Bench* bench) {
  if (auto* const kept = bench->kept.Find<TripleZPrinter>()) return kept;
  const auto probe = bench->instruments.find("probe");
  const double sigma_mm =
      probe == bench->instruments.end() ? 0 : MmFromUm(probe->second.sigma_um);
  return bench->kept.Put(
      TripleZPrinter(BenchOf(bench->machine, bench->link, sigma_mm)));
}

// The bed touched, and what levelling it would raise: refused, since nobody agreed.
TripleZResult OnlyTouch(TripleZPrinter* printer, const TripleZOptions& options) {
  TripleZResult done = RunPlaneTilt(printer, options);
  if (!done.plane || !done.plane->is_told()) return done;
  if (done.result.ending == Ending::kDone) done.result.ending = Ending::kRefused;
  const Vec3<double> raise_mm = ScrewOffsets_mm(
      *done.plane, printer->bench().drawn_mm, options.reference_mm, options.rule);
  done.result.messages.push_back(
      fmt::format("levelling would raise the screws by {:+.4f} {:+.4f} {:+.4f} mm",
                  raise_mm[0],
                  raise_mm[1],
                  raise_mm[2]));
  return done;
}

// Whether the step is to be done as it is: the person is asked before screws stay
// moved.
bool MayApply(std::string_view name, Operator* person) {
  const std::string what =
      name == "pivots_and_wiring"
          ? "pivots_and_wiring: write where the screws are found to stand (M671)?"
          : fmt::format("{}: move the screws?", name);
  return person->Do({.kind = Act::Kind::kConfirm, .text = what}).has_value();
}

TripleZResult Perform(std::string_view name,
                      TripleZOptions o,
                      Operator* person,
                      TripleZPrinter* printer) {
  if (name == "plane_tilt") return RunPlaneTilt(printer, o);
  const bool may_apply = MayApply(name, person);
  if (name == "pivots_and_wiring") {
    if (!may_apply && o.from_rounds) return OnlyTouch(printer, o);
    o.is_as_published = o.is_as_published || !may_apply;  // Says it, writes nothing.
    return RunPivotsAndWiring(printer, o);
  }
  if (!may_apply) return OnlyTouch(printer, o);
  return name == "rrf_levelling" ? RunRrfLevelling(printer, o) : RunBedTilt(printer, o);
}

ProcedureResult TripleZOnBench(std::string_view name,
                               const TripleZOptions& o,
                               Bench* bench) {
  TripleZResult done = Perform(name, o, bench->person, PrinterOn(bench));
  auto& figures = done.result.figures;
  if (done.predicted_factor) figures["predicted_factor"] = *done.predicted_factor;
  if (done.level) figures["validation_mm.mean"] = done.level->mean_mm;
  if (done.hold_out) figures["hold_out_mm.mean"] = done.hold_out->mean_mm;
  figures["rounds_steeper"] = static_cast<double>(
      std::ranges::count_if(done.steeper, [](double times) { return times > 1; }));
  const bool levels = name.starts_with("bed_tilt") || name == "rrf_levelling";
  if (levels) figures["reference_mm"] = o.reference_mm;
  const bool is_grid = name == "plane_tilt" && !o.at_screws && !o.holds_out &&
                       done.result.ending == Ending::kDone;
  if (is_grid) {
    figures["grid.columns"] = o.columns;
    figures["grid.rows"] = o.rows;
  }
  return done.result;
}

template <std::size_t kIndex>
PreparedProcedure PrepareTripleZ(YamlMap map, const Machine& /*drawing*/) {
  const TripleZOptions options = ReadTripleZOptions(kNames[kIndex], &map);
  return [options](Bench* bench) {
    return TripleZOnBench(kNames[kIndex], options, bench);
  };
}

constexpr std::array kTripleZCatalog = {
    Procedure{.name = "plane_tilt",
              .about =
                  "Touches the bed, fits z = a x + b y + c and reports; nothing is "
                  "moved. Options: grid, at, margin_mm, reference_mm and hold_out as "
                  "of bed_tilt.",
              .prepare = PrepareTripleZ<0>,
              .kind = kTripleZKind},
    Procedure{.name = "bed_tilt",
              .about =
                  "Levels a bed on three screws: touches a grid, fits z = a x + b y + "
                  "c, raises each screw, touches again. Options: grid ([3, 3]; 2 to 5 "
                  "are usual), at (grid or screws, the manual way), margin_mm, "
                  "reference_mm, largest_mm, variant. corrected raises by reference - "
                  "z, and undoes what validates worse. as_published takes offsets: "
                  "example (z less the smallest, which doubles the tilt) or formula "
                  "(reference - z less the smallest: level, at another height). "
                  "hold_out: true touches the middles of the grid's cells afterwards, "
                  "which were not fitted.",
              .has_variants = true,
              .prepare = PrepareTripleZ<1>,
              .kind = kTripleZKind},
    Procedure{.name = "bed_tilt_iterated",
              .about =
                  "bed_tilt again until the mean error is below target_mm, at most "
                  "rounds times. corrected first raises each screw alone by test_mm, "
                  "tells by what each round will multiply the tilt, and refuses a loop"
                  " that would diverge.",
              .has_variants = true,
              .prepare = PrepareTripleZ<2>,
              .kind = kTripleZKind},
    Procedure{.name = "rrf_levelling",
              .about =
                  "The firmware levels by its drivers: G30 P0 .. S3 with the screws of"
                  " M671. Options: grid, at, rounds, target_mm, test_mm, variant. "
                  "corrected foretells the factor of each round as bed_tilt_iterated "
                  "does.",
              .has_variants = true,
              .prepare = PrepareTripleZ<3>,
              .kind = kTripleZKind},
    Procedure{.name = "pivots_and_wiring",
              .about =
                  "Where the screws stand and which driver turns which: raises each "
                  "alone by test_mm and touches a grid, or (from: rounds) watches two "
                  "levelling rounds. Names swapped motors and pivots that are off; "
                  "corrected writes M671 as found.",
              .has_variants = true,
              .prepare = PrepareTripleZ<4>,
              .kind = kTripleZKind}};

}  // namespace

std::span<const Procedure> TripleZProcedures() {
  return kTripleZCatalog;
}

}  // namespace caltwin
