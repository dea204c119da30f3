import type { Schemas } from "../api/client";

export type Bench = Schemas["Bench"];
export type Job = Schemas["Job"];
export type Result = Schemas["ProcedureResult"];
export type Question = Schemas["Question"];
export type Settings = Schemas["Settings"];

export type Axis = "x" | "y" | "z";
export type Variant = "corrected" | "as_published";
export const axes: readonly Axis[] = ["x", "y", "z"];
export const usualBlock = ["25.4", "50.8", "76.2"] as const;

// The schema leaves vectors open; the server sends an object of three numbers.
export type Reading = Omit<Schemas["Reading"], "n" | "dir" | "at_mm"> & {
  n: Record<Axis, number>;
  dir: Record<Axis, number>;
};

export interface Entries {
  step: number;
  axes: Axis[];
  block: string[];
  hasProbe: boolean;
  manual: Partial<Record<Axis, { commanded: string; measured: string }>>;
  skipped: number[];
  variant: Variant;
  gauge: "dial" | "laser" | "none";
  // Axes that wait for their turn in a step.
  queue: { step: number; axes: Axis[] } | null;
  // Only jobs after this one count: "start over" moves it.
  since: number;
  twinHands: boolean;
}

const fresh: Entries = {
  step: 1, axes: [...axes], block: [...usualBlock], hasProbe: true, manual: {}, skipped: [],
  variant: "corrected", gauge: "dial", queue: null, since: 0, twinHands: false,
};

const isAxis = (one: unknown): one is Axis => one === "x" || one === "y" || one === "z";
const isText = (one: unknown): one is string => typeof one === "string";

function axesOf(raw: unknown): Axis[] | null {
  return Array.isArray(raw) ? axes.filter((axis) => raw.filter(isAxis).includes(axis)) : null;
}

function manualOf(raw: unknown): Entries["manual"] {
  const found: Entries["manual"] = {};
  if (!raw || typeof raw !== "object") return found;
  for (const axis of axes) {
    const one = (raw as Record<string, unknown>)[axis] as Record<string, unknown> | undefined;
    if (one && isText(one.commanded) && isText(one.measured)) {
      found[axis] = { commanded: one.commanded, measured: one.measured };
    }
  }
  return found;
}

function queueOf(raw: unknown): Entries["queue"] {
  if (!raw || typeof raw !== "object") return null;
  const { step, axes: waiting } = raw as { step?: unknown; axes?: unknown };
  const found = axesOf(waiting);
  return typeof step === "number" && found && found.length > 0 ? { step, axes: found } : null;
}

// Anybody may have kept anything: what does not fit is as if nobody had entered it.
export function readEntries(raw: Record<string, unknown>): Entries {
  const step = typeof raw.step === "number" ? Math.round(raw.step) : fresh.step;
  const block = Array.isArray(raw.block) && raw.block.length === 3 && raw.block.every(isText)
    ? raw.block : fresh.block;
  return {
    step: step >= 1 && step <= 6 ? step : 1,
    axes: axesOf(raw.axes) ?? fresh.axes,
    block,
    hasProbe: raw.hasProbe !== false,
    manual: manualOf(raw.manual),
    skipped: Array.isArray(raw.skipped) ? raw.skipped.filter((one) => typeof one === "number") : [],
    variant: raw.variant === "as_published" ? "as_published" : "corrected",
    gauge: raw.gauge === "laser" || raw.gauge === "none" ? raw.gauge : "dial",
    queue: queueOf(raw.queue),
    since: typeof raw.since === "number" ? raw.since : 0,
    twinHands: raw.twinHands === true,
  };
}

export interface Step {
  n: number;
  name: string;
  procedure: string;
}

export const steps: readonly Step[] = [
  { n: 1, name: "Welcome and what you need", procedure: "home" },
  { n: 2, name: "Rough steps/mm by hand", procedure: "next_rough_steps" },
  { n: 3, name: "Precise steps/mm", procedure: "next_dual_dimension" },
  { n: 4, name: "Backlash", procedure: "next_cluster_backlash" },
  { n: 5, name: "Probe deflection", procedure: "next_deflection" },
  { n: 6, name: "Verification and report", procedure: "next_verify" },
];

export const stepOf = (procedure: string) => steps.find((step) => step.procedure === procedure);

export const optionsOf = (job: Job) => job.options as { axis?: string; axes?: string[]; variant?: string };

// Jobs that still count: after the last "start over", and not undone by a restore.
export function counting(bench: Bench, since: number): Job[] {
  const restored = bench.results.filter((job) => job.procedure === "restore" && job.result?.ending === "done").at(-1);
  return bench.results.filter((job) => job.id > Math.max(since, restored?.id ?? 0));
}

export const lastJob = (jobs: Job[], procedure: string, axis?: Axis) =>
  jobs.filter((job) => job.procedure === procedure && (!axis || optionsOf(job).axis === axis)).at(-1);

export type StepState = "open" | "running" | "done" | "skipped" | "stopped";

// Not where the job was ended: its open question is then refused too, and nobody said "No".
export const isDeclined = (result: Result) => result.ending !== "aborted" &&
  result.steps.some((step) => step.verdict === "refused" && step.message.includes("not confirmed"));

// "It cannot be told" is an answer too, and so is a person's "No": the step is through.
export const isThrough = (job: Job | undefined) => !!job?.result
  && (job.result.ending === "done" || job.result.ending === "confounded" || isDeclined(job.result));

// After these nobody knows where the axes are.
const losesHome = (job: Job) => ["alarm", "collision", "link_lost"].includes(job.result?.ending ?? "");

export function stateOf(step: Step, bench: Bench, entries: Entries): StepState {
  if (bench.state !== "idle" && bench.job?.procedure === step.procedure) return "running";
  // The machine stays homed when settings are restored.
  const jobs = step.n === 1 ? bench.results.filter((job) => job.id > entries.since) : counting(bench, entries.since);
  const perAxis = step.n >= 2 && step.n <= 5;
  const last = perAxis
    ? entries.axes.map((axis) => lastJob(jobs, step.procedure, axis))
    : [lastJob(jobs, step.procedure)];
  if (step.n === 1 && jobs.some((job) => job.id >= (last[0]?.id ?? 0) && losesHome(job))) return "stopped";
  if (last.length > 0 && last.every(isThrough)) return "done";
  if (entries.skipped.includes(step.n)) return "skipped";
  if (last.some((job) => job?.result && !isThrough(job))) return "stopped";
  return "open";
}

// The newest estimate of a quantity among the jobs that count.
export function estimateOf(jobs: Job[], name: string) {
  for (const job of [...jobs].reverse()) {
    const found = job.result?.estimates.find((one) => one.name === name);
    if (found) return found;
  }
  return undefined;
}
