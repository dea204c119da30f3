import { Busy, Notice } from "../ui/parts";
import { isThrough, lastJob, stateOf, steps, usualBlock, type Axis, axes, type Bench, type Entries } from "./model";
import { JobResult } from "./results";
import type { BenchHold } from "./use_bench";

export function AxisChoice({ hold }: { hold: BenchHold }) {
  const chosen = hold.entries.axes;
  const toggle = (axis: Axis) => hold.keep({
    axes: axes.filter((one) => (one === axis ? !chosen.includes(one) : chosen.includes(one))),
  });
  return (
    <fieldset className="cal-choice">
      <legend>Axes to calibrate</legend>
      {axes.map((axis) => (
        <label key={axis} className="inline">
          <input type="checkbox" checked={chosen.includes(axis)} onChange={() => toggle(axis)} /> {axis.toUpperCase()}
        </label>
      ))}
    </fieldset>
  );
}

const isUsual = (block: string[]) =>
  block.map((one) => Number(one.replace(",", "."))).sort((a, b) => a - b)
    .every((size, i) => size === Number(usualBlock[i]));

function Block({ hold, bench, entries }: { hold: BenchHold; bench: Bench; entries: Entries }) {
  const change = (at: number, text: string) =>
    hold.keep({ block: entries.block.map((one, i) => (i === at ? text : one)) });
  return (
    <>
      <h3>Reference block</h3>
      <p>
        Default: the 1-2-3 block, 1 × 2 × 3 inch. Its sizes must be known to 0.01 mm or better.
        {bench.is_twin ? " On this simulated machine it already lies on the table." : " Clamp it clean and square, in the middle of the table."}
      </p>
      <fieldset className="cal-choice">
        <legend>Sizes of the block in mm</legend>
        {entries.block.map((size, i) => (
          <label key={i}>Size {i + 1}
            <input inputMode="decimal" size={7} value={size} onChange={(event) => change(i, event.target.value)} />
          </label>
        ))}
      </fieldset>
      {isUsual(entries.block) ? null : (
        <Notice kind="warn">
          <p><strong>Other sizes are kept here, but the measurements use those the server was started with.</strong></p>
          <p>Start it with <code>caltwin serve --bench FILE</code>, where FILE names your block's sizes, before you measure.</p>
        </Notice>
      )}
    </>
  );
}

export function Welcome({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  const { entries } = hold;
  const state = stateOf(steps[0]!, bench, entries);
  const homed = state === "done";
  const failed = state === "stopped" ? lastJob(bench.results, "home") : undefined;
  const idle = bench.state === "idle";
  return (
    <>
      <p>
        This finds three things, each on its own: steps/mm, backlash, and how far the touch probe bends before it
        triggers. You need a touch probe and a block of known size. Allow half an hour on a real machine.
      </p>
      <Notice kind="info">
        <p><strong>Nothing is lost.</strong> Values from before are kept, and one button restores them. Every change
          asks you first. Steps/mm change by at most 5 % in one pass; more is refused. Abort stops the machine at its
          next line of G-code.</p>
      </Notice>
      <div className="row cal-actions">
        <button disabled={!idle || !entries.hasProbe} onClick={() => void hold.run("home", {})}>
          {homed ? "Home again" : "Home the machine and go on"}
        </button>
        {state === "stopped" ? <button className="quiet" disabled={!idle} onClick={() => void hold.run("reset", {})}>Reset the controller</button> : null}
        {homed ? <button onClick={() => hold.keep({ step: 2 })}>Next: rough steps/mm</button> : null}
      </div>
      {bench.state !== "idle" && bench.job?.procedure === "home" ? <Busy text="Homing" /> : null}
      {failed && !isThrough(failed) ? <JobResult job={failed} /> : null}
      {failed && isThrough(failed) ? <Notice kind="warn"><p>A job after the last homing ended in an alarm. Home again.</p></Notice> : null}
      <p className="hint">Homing moves every axis. Clear the travel first.</p>
      <h3>Machine and probe</h3>
      <p>{bench.machine}, {bench.is_twin ? "simulated: practise without risk" : "a real machine"}. Tip radius set:{" "}
        {bench.settings ? `${bench.settings.tip_radius_mm.toFixed(3)} mm (as configured)` : "not known"}.</p>
      <label className="inline">
        <input type="checkbox" checked={entries.hasProbe} onChange={(event) => hold.keep({ hasProbe: event.target.checked })} />
        The touch probe is mounted, connected and configured in the firmware
      </label>
      <AxisChoice hold={hold} />
      <Block hold={hold} bench={bench} entries={entries} />
      <h3>Why steps/mm come before backlash</h3>
      <p>
        The published wizard measures backlash first; here precise steps/mm come first, because the difference of two
        sizes cancels backlash and deflection, while backlash is measured better with exact steps/mm (section 2.2 of the
        NeXT guide says so too).
      </p>
    </>
  );
}
