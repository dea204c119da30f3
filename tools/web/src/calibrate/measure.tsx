import { useEffect, useState } from "react";
import { answered, api, type Schemas } from "../api/client";
import { Busy } from "../ui/parts";
import { counting, isThrough, lastJob, optionsOf, stateOf, steps, type Axis, type Bench, type Job, type Reading, type Step } from "./model";
import { JobResult } from "./results";
import { ManualEntry } from "./rough";
import { Scatter } from "./scatter";
import { AxisChoice } from "./welcome";
import { list, plain } from "./words";
import type { BenchHold } from "./use_bench";

const about: Record<number, string> = {
  2: "The machine moves 100 mm and asks what a gauge reads before and after. Skip this where steps/mm are right within 1 %.",
  3: "The probe measures two sizes of the block. Their difference tells steps/mm; backlash and deflection cancel.",
  4: "The probe touches two faces of the block many times. Readings form two clusters, on the way in and on the way out. Their distance tells the backlash.",
  5: "The probe measures one known size. With steps/mm and backlash right, what is left is how far the probe bends before it triggers. Along Z this needs a ledge that can be touched from below; without one it stays not known.",
};

export function startJob(hold: BenchHold, step: Step, chosen: Axis[]): void {
  const [first, ...rest] = chosen;
  if (!first) return;
  const { variant } = hold.entries;
  hold.keep({ queue: rest.length > 0 ? { step: step.n, axes: rest } : null, step: step.n,
    skipped: hold.entries.skipped.filter((one) => one !== step.n) });
  void hold.run(step.procedure, { axis: first, ...(step.n > 2 && variant === "as_published" ? { variant } : {}) });
}

function Advanced({ hold, step }: { hold: BenchHold; step: Step }) {
  const [texts, setTexts] = useState<Schemas["Procedures"]["procedures"]>([]);
  useEffect(() => {
    answered(api.GET("/api/procedures")).then((found) => setTexts(found.procedures), () => setTexts([]));
  }, []);
  const text = texts.find((one) => one.name === step.procedure);
  const options = [
    { value: "corrected", name: "Corrected (recommended): does what the physics says" },
    { value: "as_published", name: "As published: does what the guide's text says, to see what comes of it" },
  ] as const;
  return (
    <details className="cal-fold">
      <summary>Advanced: corrected or as published</summary>
      <fieldset className="cal-choice">
        <legend>Form of the procedure</legend>
        {options.map((one) => (
          <label key={one.value} className="inline">
            <input type="radio" name="variant" value={one.value} checked={hold.entries.variant === one.value}
                   onChange={() => hold.keep({ variant: one.value })} /> {one.name}
          </label>
        ))}
      </fieldset>
      {text ? <><p><strong>Published:</strong> {text.published}</p><p><strong>Physics:</strong> {text.physics}</p></> : null}
    </details>
  );
}

function Progress({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  const axis = bench.job ? optionsOf(bench.job).axis?.toUpperCase() : undefined;
  const touches = hold.readings.length;
  return (
    <>
      {bench.state === "asking" ? null
        : <Busy text={`Measuring${axis ? ` ${axis}` : ""}. ${touches} readings so far.`} />}
      {hold.said.length > 0 ? (
        <details className="cal-fold"><summary>What has been done so far ({hold.said.length} {hold.said.length === 1 ? "line" : "lines"})</summary>
          <ul>{hold.said.map((text, i) => <li key={i}>{plain(text)}</li>)}</ul>
        </details>
      ) : null}
    </>
  );
}

export function Actions({ hold, bench, step }: { hold: BenchHold; bench: Bench; step: Step }) {
  const { entries } = hold;
  const state = stateOf(step, bench, entries);
  const next = steps[step.n];
  const jobs = counting(bench, entries.since);
  const open = entries.axes.filter((axis) => !isThrough(lastJob(jobs, step.procedure, axis)));
  const some = open.length > 0 && open.length < entries.axes.length;
  const idle = bench.state === "idle";
  return (
    <div className="row cal-actions">
      {state === "done" && next ? <button onClick={() => hold.keep({ step: next.n })}>Next: {next.name}</button> : null}
      {some ? <button disabled={!idle} onClick={() => startJob(hold, step, open)}>Continue with {list(open)}</button> : null}
      <button className={state === "done" || some ? "quiet" : ""} disabled={!idle || entries.axes.length === 0}
              onClick={() => startJob(hold, step, entries.axes)}>
        {state === "done" || some ? "Repeat" : "Measure"} {list(entries.axes)}
      </button>
      {state !== "done" && next ? (
        <button className="quiet" onClick={() => hold.keep({ step: next.n, skipped: [...new Set([...entries.skipped, step.n])] })}>
          Skip this step
        </button>
      ) : null}
    </div>
  );
}

// What the server kept of a job, also where it was ended in the middle of it.
function KeptReadings({ job }: { job: Job }) {
  const [readings, setReadings] = useState<Reading[]>([]);
  useEffect(() => {
    void answered(api.GET("/api/bench/results")).then(({ results }) => {
      setReadings((results.find((one) => one.id === job.id)?.readings ?? []) as unknown as Reading[]);
    }, () => undefined);
  }, [job.id]);
  if (readings.length === 0) return null;
  return (
    <details open={job.result?.ending === "interrupted"}>
      <summary>{readings.length} readings by the sense of approach</summary>
      <Scatter readings={readings} />
    </details>
  );
}

export function Measure({ hold, bench, step }: { hold: BenchHold; bench: Bench; step: Step }) {
  const { entries } = hold;
  const runs = bench.state !== "idle" && bench.job?.procedure === step.procedure;
  const jobs = counting(bench, entries.since);
  const queue = entries.queue?.step === step.n ? entries.queue.axes : [];
  return (
    <>
      <p>{about[step.n]}</p>
      {runs ? <Progress hold={hold} bench={bench} /> : (
        <>
          <AxisChoice hold={hold} />
          {entries.axes.length === 0 ? <p>Choose at least one axis.</p> : null}
          <Actions hold={hold} bench={bench} step={step} />
        </>
      )}
      {runs && queue.length > 0 ? <p className="hint">Then: {list(queue)}.</p> : null}
      {entries.variant === "as_published" && step.n > 2 ? (
        <p className="cal-warn">The published form is chosen. It may give wrong values, or run the probe into the block; see Advanced.</p>
      ) : null}
      {runs && step.n === 4 ? <><h3>Readings by the sense of approach</h3><Scatter readings={hold.readings} /></> : null}
      {entries.axes.map((axis) => lastJob(jobs, step.procedure, axis)).map((job) => (job ? (
        <JobResult key={job.id} job={job}>
          {step.n === 4 ? <KeptReadings job={job} /> : null}
        </JobResult>
      ) : null))}
      {step.n === 2 ? <ManualEntry hold={hold} bench={bench} /> : <Advanced hold={hold} step={step} />}
    </>
  );
}
