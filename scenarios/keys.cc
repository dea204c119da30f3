#include "scenarios/keys.h"

#include <array>

namespace caltwin {
namespace {

constexpr std::array kKeys = {
    Word{"about", "One sentence for people."},
    Word{"machine",
         "A name (sought in ./models, then in the models the program came with) or a "
         "path, relative to this file: the drawing. May be a machine.ext.yaml."},
    Word{"seed", "The only source of chance: same file, same seed, same result."},
    Word{"fidelity",
         "physics (MuJoCo steps the mechanism, contact decides the trigger) or fast "
         "(closed forms). A claim of recovery needs physics."},
    Word{"effects",
         "How the built machine differs from its drawing: cause.axis: {parameter: "
         "value}. A value may be a distribution."},
    Word{"settings",
         "What the firmware wrongly believes at power-up: steps_per_mm, backlash_mm, "
         "probe_deflection_mm by axis, tip_radius_mm. The rest is as the machine file "
         "says. A value may be a distribution."},
    Word{"instruments",
         "By id: {kind, sigma_um, resolution_um, u_um}. `probe` is the touch probe."},
    Word{
        "artefacts",
        "By id: {type, at_mm, ...}: block123, web, ring, pocket, ledge or plate; at_mm "
        "is the centre of the base."},
    Word{
        "firmware",
        "The controller: m400_ignores_backlash (a defect before RepRapFirmware 3.6.1), "
        "files (its own storage by path, such as sys/nxt-user-vars.g), probe (missing: "
        "none is configured; open: it never reads triggered; stuck: always), on a "
        "triple-Z "
        "printer still_alone (z1, z2, z3: that motor stays when it is told to move "
        "alone)."},
    Word{"calibrate",
         "A list of what is done, in order, each a procedure with its options: `- "
         "next_dual_dimension: {axis: x, variant: corrected}`."},
    Word{"controller",
         "In place of calibrate: {klipper: {gcode: [G28, DELTA_CALIBRATE, "
         "SAVE_CONFIG]}}: "
         "Klipper's own host drives the machine and says those lines. `config`: its "
         "printer.cfg, else one is made of the machine; `add`: further lines of it. Or "
         "{linuxcnc: {mdi: [G38.2 Z-5 F60]}}: LinuxCNC does; `program`: a .ngc file, "
         "`ini`: its configuration, `set`: values of it (JOINT_0.BACKLASH: 0.05), "
         "`files`: tables that it names, `home: false`: not homed first."},
    Word{"external",
         "A step of calibrate: somebody else's program, {command: [python3, mine.py], "
         "timeout_s: 600}, with the machine on its standard input and output."},
    Word{"gcode", "A step of calibrate: {lines: [M500, M999]}, sent as they are."},
    Word{"variant",
         "An option of a procedure: as_published (what the text says) or corrected "
         "(what physics says)."},
    Word{"expect", "What the run must show; each entry is a check."},
    Word{"outcome", "How the run must end; recovers where nothing is said."},
    Word{"truth_within",
         "Of a parameter: abs(recovered - built value) is at most this, in its unit."},
    Word{"truth_within_sd",
         "Of a parameter: its error is at most so many of its stated uncertainties."},
    Word{"sd_below", "Of a parameter: its stated uncertainty is below this."},
    Word{"identifiable",
         "Of a parameter: whether the engine must say that it can be told."},
    Word{"reads",
         "Of a parameter: {value, within}, what it ends at, right or wrong; for "
         "published formulas that read something else than their name says."},
    Word{"steps",
         "Of a parameter: {after: [...], within: }, its value after each step, in "
         "order."},
    Word{"position_error_mm.p95",
         "{below: }: 95 % quantile of the tip's position error at 1000 seeded poses, "
         "both senses, mean offset removed, in mm."},
    Word{"messages", "Texts that must occur in what the run says."}};

constexpr std::array kStudyKeys = {
    Word{"scenarios",
         "A list of scenario files; numbers in them may be distributions. Each is a "
         "contender, or each with each of `compare`."},
    Word{
        "plan",
        "In place of scenarios: a measuring plan, whose rows are estimated jointly for "
        "what `vary` names."},
    Word{"vary",
         "Number or distribution by name: cause.axis.parameter, settings.KEY.AXIS, "
         "instruments.ID.sigma_um, built.probe.hysteresis_mm."},
    Word{"compare", "Procedures put in place of `calibrate:`, on the same machines."},
    Word{
        "fidelity (study)",
        "fast, physics, or of a plan linear: rows drawn from one design straight about "
        "the median machine; refused where 1000 machines by the closed forms differ."},
    Word{"trials", "How many machines."},
    Word{
        "adaptive",
        "In place of trials: {digits: 2, most_trials: 1000000}, batches of 10000 until "
        "means, standard deviations and interval ends of all errors are known to so "
        "many digits (JCGM 101, 7.9). Not with --shard."},
    Word{"keep",
         "all: every trial in study.sqlite and trials.csv. none: aggregates alone, in "
         "fixed memory; usual for linear."}};

constexpr std::array kOutcomeWords = {
    Word{
        "recovers",
        "Every procedure ran to its end, every expected truth was met, and the machine "
        "is at truth as good as its kind asks for (docs/scenarios.md)."},
    Word{
        "diverges",
        "The error grew in two or more passes, even if a limit then stopped it; or the "
        "machine is at truth worse than before, by more than chance."},
    Word{"no_trigger", "A probe move ended without the contact it was to find."},
    Word{"collision", "The stylus was bent beyond its overtravel."},
    Word{"reads_zero", "The reading is zero whatever the machine is like."},
    Word{"confounded", "The procedure said that it cannot tell."},
    Word{"refused",
         "A procedure was refused, which ends a run: by a limit, the operator, or a "
         "check before."},
    Word{"alarm", "The machine stopped itself for another reason."},
    Word{"misses",
         "All was done, but an expected truth was missed, something told is wrong, or "
         "the machine is not as good as its kind asks for."}};

constexpr std::array kUncertaintyWords = {
    Word{"u",
         "Combined standard uncertainty of a result: the root of the sum of squares of "
         "what its inputs add (docs/uncertainty.md)."},
    Word{
        "k",
        "Coverage factor: U = k u holds 95 %. Student's t for the effective degrees of "
        "freedom; 1.65 where one rounding is all there is."},
    Word{"U", "Expanded uncertainty k u: value +- U holds the truth 95 % of the time."},
    Word{"dof",
         "Effective degrees of freedom of u by Welch and Satterthwaite; none written: "
         "so many that u itself is known."},
    Word{"sd",
         "U / 1.96: the standard uncertainty where degrees of freedom are many. What "
         "tables and studies count +-1.96 of."},
    Word{
        "budget",
        "What each input adds to u, and its share of u squared: readings, sizes of the "
        "block, the ball's radius, priors."},
    Word{"share", "Of an input: its part of u squared; all together are 1."},
    Word{
        "scatter",
        "Of joint_estimate: what uncertainties rest on: stated (the noise, unless the "
        "residuals contradict it), rows (each row's residual, HC3) or faces (residuals "
        "of a face's touches together, CR3)."},
    Word{"profile",
         "Of joint_estimate: true adds the 95 % interval by profile likelihood, all "
         "else "
         "fitted anew at each value."}};

constexpr std::array kUnitWords = {
    Word{"mm", "Millimetres: all lengths, unless the name ends in another unit."},
    Word{"um", "Micrometres: sigmas, amplitudes."},
    Word{"mrad", "Milliradians: small angles; 1 mrad is 1 mm in a metre."},
    Word{"deg", "Degrees, counter-clockwise from above."},
    Word{"s", "Seconds."},
    Word{"ms", "Milliseconds: latencies."},
    Word{"mm_s", "Millimetres per second: feeds. Only G-code's F is in mm/min."},
    Word{"n", "Newtons."},
    Word{"kg", "Kilograms."},
    Word{"ppm", "Parts per million."},
    Word{"1/mm", "Per millimetre: microsteps per millimetre of travel."}};

}  // namespace

std::span<const Word> ScenarioKeys() {
  return kKeys;
}

std::span<const Word> StudyKeys() {
  return kStudyKeys;
}

std::span<const Word> OutcomeWords() {
  return kOutcomeWords;
}

std::span<const Word> UnitWords() {
  return kUnitWords;
}

std::span<const Word> UncertaintyWords() {
  return kUncertaintyWords;
}

}  // namespace caltwin
