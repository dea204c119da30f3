import { useRef, useState } from "react";
import { operatorName } from "../api/client";
import { Card, useFocusAfter } from "../ui/parts";
import { axes, counting, estimateOf, type Axis, type Bench, type Job, type Settings } from "./model";
import { jobName, valueOf, when } from "./words";
import type { BenchHold } from "./use_bench";

const rows = [
  { title: "Steps/mm", name: "steps_per_mm", key: "steps_per_mm" },
  { title: "Backlash", name: "backlash", key: "backlash_mm" },
  { title: "Probe deflection", name: "probe_pretravel", key: "probe_deflection_mm" },
] as const;

// Whether a job wrote this value, as one that was aborted after it does without an estimate.
const wasApplied = (jobs: Job[], name: string, value: number) => jobs.some((job) =>
  job.result?.steps.some((step) => step.name === name && step.verdict === "applied" && Math.abs(step.after - value) < 1e-9 + 1e-6 * Math.abs(value)));

// A setting with the uncertainty of the estimate it came from; without one, as configured.
export function settingText(settings: Settings, jobs: Job[], row: (typeof rows)[number], axis: Axis): string {
  const name = `${row.name}.${axis}`;
  const value = settings[row.key][axis];
  const estimate = estimateOf(jobs, name);
  if (estimate && !estimate.is_known) return `not known (set to ${valueOf(name, value)})`;
  const fits = estimate?.value != null && estimate.sd != null
    && Math.abs(estimate.value - value) <= Math.max(2 * estimate.sd, 1e-9);
  if (fits) return valueOf(name, value, estimate.sd);
  return `${valueOf(name, value)}, ${wasApplied(jobs, name, value) ? "measured and applied, not verified" : "not measured"}`;
}
export const settingRows = rows;

function SettingsTable({ bench, since }: { bench: Bench; since: number }) {
  const { settings } = bench;
  if (!settings) return <p>The settings are not known yet: the machine has not told them.</p>;
  const jobs = counting(bench, since);
  return (
    <div className="scroll" tabIndex={0} role="region" aria-label="Settings in force">
      <table className="cal-narrow">
        <caption className="cal-hidden">Settings in force, by axis</caption>
        <thead>
          <tr><th scope="col">Setting</th>{axes.map((axis) => <th key={axis} scope="col">{axis.toUpperCase()}</th>)}</tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={row.key}>
              <th scope="row">{row.title}</th>
              {axes.map((axis) => <td key={axis}>{settingText(settings, jobs, row, axis)}</td>)}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function linkText(hold: BenchHold): string {
  if (hold.connection === "lost") return "lost, trying again";
  if (hold.connection === "connecting") return "connecting";
  return hold.bench?.is_twin ? "open, a simulated machine" : "open, a real machine";
}

function whoMoves(bench: Bench): string {
  if (!bench.held_by) return "nobody, the machine is free";
  return bench.held_by === operatorName() ? "you, from this browser" : bench.held_by;
}

function RestoreButton({ hold }: { hold: BenchHold }) {
  const [asks, setAsks] = useState(false);
  const { bench } = hold;
  if (!bench) return null;
  const same = JSON.stringify(bench.settings) === JSON.stringify(bench.settings_before);
  const off = bench.state !== "idle" || !bench.settings_before || same;
  if (asks && !off) {
    return (
      <>
        <span>Put back every setting from before the first change?</span>
        <button className="danger" onClick={() => { setAsks(false); hold.restore(); }}>Yes, restore</button>
        <button className="quiet" onClick={() => setAsks(false)}>No</button>
      </>
    );
  }
  return (
    <>
      <button className="quiet" disabled={off} onClick={() => setAsks(true)}>Restore the settings from before</button>
      {same ? <span className="hint">Nothing has been changed.</span> : null}
    </>
  );
}

function nowText(bench: Bench, isLost: boolean): string {
  if (isLost) return "What the machine does now is not known.";
  if (bench.state === "idle" || !bench.job) return "The machine is idle.";
  const name = jobName(bench.job);
  return bench.state === "asking" ? `${name}: waits for your answer.` : `${name}: running.`;
}

// Stays in sight while the page scrolls, so that Abort is always within reach.
export function NowBar({ hold }: { hold: BenchHold }) {
  const { bench } = hold;
  const said = useRef<HTMLParagraphElement>(null);
  useFocusAfter(bench?.state, said);
  if (!bench) return null;
  return (
    <div className={bench.state === "idle" ? "" : "cal-bar"}>
      <p className="cal-now" role="status" ref={said} tabIndex={-1}><strong>{nowText(bench, hold.connection === "lost")}</strong></p>
      {bench.state === "idle" ? null : <button className="danger" onClick={hold.abort}>Abort</button>}
    </div>
  );
}

function calibratedText(bench: Bench): string {
  if (bench.calibrated_at) return when(bench.calibrated_at);
  const restored = bench.results.filter((job) => job.procedure === "restore" && job.result?.ending === "done").at(-1);
  return restored ? `undone: settings restored ${when(restored.ended_at)}` : "never";
}

export function Status({ hold }: { hold: BenchHold }) {
  const { bench, entries } = hold;
  if (!bench) return null;
  return (
    <Card title={`Status of the ${bench.machine.replaceAll("_", " ")}`}>
      <SettingsTable bench={bench} since={entries.since} />
      <dl className="figures">
        <div className="figure"><dt>Last calibration</dt><dd>{calibratedText(bench)}</dd></div>
        <div className="figure"><dt>Link</dt><dd>{linkText(hold)}</dd></div>
        <div className="figure"><dt>Who moves the machine</dt><dd>{whoMoves(bench)}</dd></div>
        <div className="figure"><dt>Your entries</dt><dd>{hold.isSaved ? "kept on the server" : "not kept yet"}</dd></div>
      </dl>
      <div className="row"><RestoreButton hold={hold} /></div>
    </Card>
  );
}
