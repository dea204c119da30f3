import { useEffect, useState } from "react";
import { answered, api, problemOf, type Problem } from "../api/client";
import { Busy, Notice, ProblemNotice } from "../ui/parts";
import { axes, counting, lastJob, steps, type Bench, type Job, type Settings } from "./model";
import { JobResult, verdictOf } from "./results";
import { settingRows, settingText } from "./status";
import { AxisChoice } from "./welcome";
import { capital, jobName, list, plain, valueOf, when } from "./words";
import type { BenchHold } from "./use_bench";

function BeforeAfter({ bench, since }: { bench: Bench; since: number }) {
  const { settings, settings_before: before } = bench;
  if (!settings || !before) return <p>Nothing was changed yet, so there is nothing to compare.</p>;
  const jobs = counting(bench, since);
  return (
    <div className="scroll" tabIndex={0} role="region" aria-label="Before and after">
      <table>
        <thead><tr><th scope="col">Setting</th><th scope="col">Before</th><th scope="col">Now</th></tr></thead>
        <tbody>
          {settingRows.flatMap((row) => axes.map((axis) => (
            <tr key={row.key + axis}>
              <th scope="row">{row.title} of {axis.toUpperCase()}</th>
              <td>{valueOf(row.name, before[row.key][axis])}</td>
              <td>{settingText(settings, jobs, row, axis)}</td>
            </tr>
          )))}
        </tbody>
      </table>
    </div>
  );
}

interface Check { axis: string; name: string; found: string; limit: string; isGood: boolean }

function checkOf(text: string): Check | null {
  const found = /^([xyz]): \d\. ([^:]+): (?:worst )?([+-][\d.]+) mm, (within|beyond) ([\d.]+)$/.exec(text);
  if (!found) return null;
  return { axis: found[1]!.toUpperCase(), name: found[2]!, found: found[3]!, limit: found[5]!, isGood: found[4] === "within" };
}

function Checks({ job }: { job: Job }) {
  const messages = [...new Set(job.result?.messages ?? [])];
  const checks = messages.map(checkOf).filter((one) => one !== null);
  const rest = messages.filter((one) => !checkOf(one));
  const others = rest.filter((one) => !one.includes("revisit") && !one.includes("a pocket not calibrated on"));
  if (rest.some((one) => one.includes("a pocket not calibrated on: there is none"))) {
    others.push("A pocket that was not calibrated on would be the best proof. There is none on the table: mill one and measure it.");
  }
  const bad = checks.filter((one) => !one.isGood);
  return (
    <>
      {checks.length > 0 ? (
        <Notice kind={bad.length > 0 ? "warn" : "good"}>
          <p><strong>{bad.length > 0 ? `${bad.length} of ${checks.length} checks are beyond their limit.`
            : `All ${checks.length} checks are within their limits.`}</strong></p>
          {rest.filter((one) => one.includes("revisit")).map((one) => <p key={one}>{plain(one)}</p>)}
        </Notice>
      ) : null}
      {checks.length > 0 ? (
        <div className="scroll" tabIndex={0} role="region" aria-label="Checks">
          <table>
            <thead><tr><th scope="col">Axis</th><th scope="col">Check</th><th scope="col" className="number">Found, mm</th>
              <th scope="col" className="number">Limit, mm</th><th scope="col">Verdict</th></tr></thead>
            <tbody>
              {checks.map((one) => (
                <tr key={one.axis + one.name}>
                  <td>{one.axis}</td><td>{one.name}</td><td className="number">{one.found}</td>
                  <td className="number">{one.limit}</td>
                  <td className={one.isGood ? "cal-good" : "cal-warn"}>{one.isGood ? "within" : "beyond"}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      ) : null}
      {others.length > 0 ? <ul className="hint">{others.map((one) => <li key={one}>{plain(one)}</li>)}</ul> : null}
    </>
  );
}

function save(name: string, type: string, text: string) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// grbl and Marlin: steps/mm alone, and Marlin's backlash.
function OtherFirmware({ settings }: { settings: Settings }) {
  const steps = axes.map((axis) => settings.steps_per_mm[axis].toFixed(3));
  const gaps = axes.map((axis) => settings.backlash_mm[axis].toFixed(3));
  return (
    <details>
      <summary>The same for grbl or Marlin</summary>
      <h3>grbl</h3>
      <pre tabIndex={0} aria-label="Settings for grbl">{steps.map((value, i) => `$${100 + i}=${value}`).join("\n")}</pre>
      <p className="hint">grbl corrects no backlash; a sender or the CAM program may.</p>
      <h3>Marlin</h3>
      <pre tabIndex={0} aria-label="Settings for Marlin">{`M92 X${steps[0]} Y${steps[1]} Z${steps[2]}\nM425 F1 X${gaps[0]} Y${gaps[1]} Z${gaps[2]}\nM500`}</pre>
    </details>
  );
}

function UserVars({ settings }: { settings: Settings | null }) {
  const [text, setText] = useState<string | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [copied, setCopied] = useState("");
  const key = JSON.stringify(settings);
  useEffect(() => {
    answered<string>(api.GET("/api/bench/user-vars", { parseAs: "text" })).then(
      (found) => { setText(found); setProblem(null); }, (fault: unknown) => setProblem(problemOf(fault)));
  }, [key]);
  if (problem) return <ProblemNotice problem={problem} />;
  if (text === null) return <Busy text="Fetching the settings file" />;
  const copy = () => void navigator.clipboard.writeText(text).then(
    () => setCopied("Copied."), () => setCopied("The browser does not allow copying here. Select the text instead."));
  return (
    <>
      <p>Settings live in the controller's memory until it restarts. This file is for RepRapFirmware: put it beside config.g
        and call it from there with <code>M98 P"nxt-user-vars.g"</code>. Other firmware takes only the lines below it.</p>
      <pre tabIndex={0} aria-label="nxt-user-vars.g">{text}</pre>
      <div className="row">
        <button onClick={() => save("nxt-user-vars.g", "text/plain", text)}>Download nxt-user-vars.g</button>
        <button className="quiet" onClick={copy}>Copy</button>
        <span role="status">{copied}</span>
      </div>
      {settings ? <OtherFirmware settings={settings} /> : null}
    </>
  );
}

function jobText(job: Job): string {
  if (!job.result) return "no result";
  const checks = job.result.messages.map(checkOf).filter((one) => one !== null);
  const bad = new Set(checks.filter((one) => !one.isGood).map((one) => one.axis + one.name)).size;
  if (job.procedure !== "next_verify" || checks.length === 0) return verdictOf(job.result).text;
  return bad > 0 ? `${bad} checks beyond their limit` : "all checks within their limits";
}

function Jobs({ bench }: { bench: Bench }) {
  if (bench.results.length === 0) return <p>No job has been run yet.</p>;
  return (
    <>
      <div className="scroll" tabIndex={0} role="region" aria-label="Jobs">
        <table>
          <thead><tr><th scope="col">Job, and when it ended</th><th scope="col">Result</th></tr></thead>
          <tbody>
            {[...bench.results].reverse().map((job) => (
              <tr key={job.id}><th scope="row">{jobName(job)}<br /><span className="hint">{when(job.ended_at)}</span></th>
                <td>{capital(jobText(job))}</td></tr>
            ))}
          </tbody>
        </table>
      </div>
      <button className="quiet" onClick={async () => save("calibration-jobs.json", "application/json", await (await fetch("/api/bench/results")).text())}>
        Download all jobs with their readings (JSON)
      </button>
    </>
  );
}

export function Report({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  const { entries } = hold;
  const runs = bench.state !== "idle" && bench.job?.procedure === "next_verify";
  const job = lastJob(counting(bench, entries.since), steps[5]!.procedure);
  const gauge = entries.gauge;
  const verify = () => void hold.run("next_verify", { axes: entries.axes, instrument: gauge });
  return (
    <>
      <p>The probe measures every size of the block again. A gauge tells whether one position is reached alike from both
        sides. Nothing is changed.</p>
      {runs ? (bench.state === "asking" ? null : <Busy text={`Verifying. ${hold.readings.length} readings so far.`} />) : (
        <>
          <AxisChoice hold={hold} />
          <div className="row cal-actions">
            <label>Gauge for the reversal check
              <select value={gauge} onChange={(event) => hold.keep({ gauge: event.target.value as typeof gauge })}>
                <option value="dial">dial gauge</option><option value="laser">laser</option>
                <option value="none">none: skip this check</option>
              </select>
            </label>
            <button disabled={bench.state !== "idle" || entries.axes.length === 0} onClick={verify}>
              {job ? "Verify again" : "Verify"} {list(entries.axes)}
            </button>
          </div>
        </>
      )}
      {job?.result ? (job.result.ending === "done" ? <Checks job={job} /> : <JobResult job={job} hideChanges />) : null}
      <h3>Before and after</h3>
      <BeforeAfter bench={bench} since={entries.since} />
      <h3>Settings to keep</h3>
      <UserVars settings={bench.settings} />
      <h3>Jobs so far</h3>
      <Jobs bench={bench} />
      <p><button className="quiet" disabled={bench.state !== "idle"} onClick={() => hold.keep({
        step: 1, skipped: [], queue: null, since: Math.max(0, ...bench.results.map((one) => one.id)) })}>
        Start over with all steps open
      </button></p>
    </>
  );
}
