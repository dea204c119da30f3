import { withSd } from "../ui/parts";
import { optionsOf, steps, type Axis, type Job } from "./model";

const quantities: Record<string, string> = {
  steps_per_mm: "steps/mm",
  backlash: "backlash",
  probe_pretravel: "probe deflection",
};

// "backlash.x - 2 placement.gauge.x": the names in it, without signs and factors.
function togetherIn(sum: string): string {
  const names = sum.split(/ [+-] /).map((term) => term.replace(/^-?\s*(?:[\d.]+ )?/, ""));
  return `It tells ${names.slice(0, -1).join(", ")} and ${names.at(-1)} only together, not each by itself.`;
}

// "probe_pretravel.x" -> "probe deflection of X", also inside sentences.
export function plain(text: string): string {
  return text
    .replace(/It determines ([^.]*(?:\.\S[^.]*)*?)(?:, each)? as a whole, not (?:its|their) parts\./g,
      (_, sums: string) => sums.split(" and ").map(togetherIn).join(" "))
    .replace(/^([xyz]): /, (_, axis: string) => `${axis.toUpperCase()}: `)
    .replace(/\b(steps_per_mm|backlash|probe_pretravel)\.([xyz])\b/g,
      (_, what: string, axis: string) => `${quantities[what]} of ${axis.toUpperCase()}`)
    .replace(/\bplacement\.gauge\.[xyz]\b/g, "where the gauge stands")
    .replace(/\bplacement\.table\.[xyz]\b/g, "the height of the table")
    .replace(/\bplacement\.\w+\.[xyz]\b/g, "where the block stands")
    .replace(/\btip_size\b/g, "tip radius")
    .replace(/\bprobe_hysteresis\b/g, "hysteresis of the probe's switch")
    .replace(/\btrigger_latency\b/g, "delay of the probe's signal")
    .replace(/\((next_\w+)\)/g, (_, name: string) => `(${nameOf(name)})`)
    .replace(/\b(laser|dial)\.([xyz])\b/g, (_, gauge: string, axis: string) =>
      `the ${gauge === "dial" ? "dial gauge" : "laser"} along ${axis.toUpperCase()}`)
    .replace(/(\d) um\b/g, "$1 µm");
}

export function nameOf(procedure: string): string {
  const step = steps.find((one) => one.procedure === procedure);
  if (procedure === "home") return "Homing";
  if (procedure === "restore") return "Restoring the settings from before";
  if (procedure === "reset") return "Resetting the controller";
  if (procedure === "set") return "Writing settings";
  return step && step.n > 1 ? (step.n === 6 ? "Verification" : step.name) : capital(procedure.replaceAll("_", " "));
}

export function jobName(job: Job): string {
  const { axis, axes } = optionsOf(job);
  const on = axis ? [axis] : axes ?? [];
  return nameOf(job.procedure) + (on.length > 0 ? `, ${on.map((one) => one.toUpperCase()).join(", ")}` : "");
}

export const capital = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);

// "repeatability.x" -> "Repeatability, X"; "block.left" -> "left face of the block".
export function campaignName(campaign: string): string {
  const [what = campaign, axis] = campaign.split(".");
  const name = what === "verify" ? "Verification" : capital(what.replaceAll("_", " "));
  return axis ? `${name}, ${axis.toUpperCase()}` : name;
}

export function featureName(feature: string): string {
  const [what = feature, side] = feature.split(".");
  const thing = what.replaceAll("_", " ");
  return side ? `${side.replaceAll("_", " ")} face of the ${thing}` : thing;
}

export const unitOf = (name: string) => (name.startsWith("steps_per_mm") ? "steps/mm" : "mm");

export function valueOf(name: string, value: number | null | undefined, sd?: number | null): string {
  if (value === null || value === undefined) return "not known";
  return withSd(value, sd, unitOf(name), name.startsWith("steps_per_mm") ? 3 : 4);
}

export const list = (found: readonly Axis[]) => found.map((axis) => axis.toUpperCase()).join(", ");

export const when = (at: string | null | undefined) => (at ? new Date(at).toLocaleString() : "never");

// How a job ended: what it means, and what to do.
export const endings: Record<string, { kind: "good" | "warn" | "bad"; verdict: string; remedy: string }> = {
  done: { kind: "good", verdict: "Done.", remedy: "" },
  confounded: { kind: "warn", verdict: "These measurements cannot tell the value. Nothing was changed.",
    remedy: "What would tell it stands below. You can go on without." },
  reads_zero: { kind: "warn", verdict: "This procedure reads zero whatever the machine is like. Nothing was changed.",
    remedy: "Use the corrected form (Advanced)." },
  aborted: { kind: "warn", verdict: "Stopped on request.",
    remedy: "Settings applied before the stop stay. Measure again, or restore the settings from before." },
  interrupted: { kind: "warn", verdict: "The server ended during it.",
    remedy: "Settings applied before that stay. Measure again, or restore the settings from before." },
  refused: { kind: "bad", verdict: "Refused. Nothing was changed by this.",
    remedy: "Below it says why. Where steps/mm would change by more than 5 %: do the rough steps/mm first, and check the block's sizes." },
  no_trigger: { kind: "bad", verdict: "The probe did not trigger.",
    remedy: "Check that the probe is mounted and connected, and that the block stands where the machine looks for it. Then measure again." },
  collision: { kind: "bad", verdict: "The probe ran into something.",
    remedy: "Check the stylus and the block. Reset the controller (the button in step 1, or its own). Then home, and measure again in the corrected form." },
  alarm: { kind: "bad", verdict: "The controller raised an alarm.", remedy: "Clear the cause. Reset the controller (the button in step 1, or its own). Then home, and measure again." },
  unconverged: { kind: "bad", verdict: "The value did not settle.",
    remedy: "Look for loose parts, a block that moves, or chips on its faces. Then measure again." },
  link_lost: { kind: "bad", verdict: "The link to the machine was lost.",
    remedy: "Check cable and power. Home the machine, then measure again." },
};

export const endingOf = (ending: string) => endings[ending]
  ?? { kind: "bad" as const, verdict: `It ended with "${ending}".`, remedy: "The lines below say more." };
